"""Tables and figures of runs, for the terminal."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from rich.table import Table
from rich.text import Text

from scenarios.acceptance import FAILED, PASSED
from scenarios.figures import draw_series
from scenarios.record import Record
from scenarios.scenario import Scenario
from scenarios.summary import Summary

_COLOURS = {PASSED: "green", FAILED: "red"}


def scenario_table(scenarios: Mapping[str, Scenario]) -> Table:
    """Return the names of scenarios and what they show."""
    table = Table("scenario", "what it shows", box=None, pad_edge=False)
    for name, scenario in scenarios.items():
        table.add_row(Text(name, "bold"), Text(scenario.description))
    return table


def summary_tables(summary: Summary) -> list[Table | Text]:
    """Return the figures of a run, with their limits, and its counts and verdict."""
    table = Table("figure", "got", "accepted", "", title=summary.scenario, title_justify="left")
    table.columns[1].justify = "right"
    checks = {check.figure: check for check in summary.checks}
    for name, value in summary.figures.items():
        check = checks.get(name)
        mark = "" if check is None else "[green]✓[/]" if check.holds else "[red]✗[/]"
        table.add_row(Text(name), _number(value), check.limit if check else "", mark)
    table.add_section()
    table.add_row(Text("simulated time [s]"), _number(summary.simulated_time))
    table.add_row("steps", _number(summary.steps))
    if summary.force_evaluations:  # an integrator's: a discrete plant has none
        table.add_row("force evaluations", _number(summary.force_evaluations))
    table.add_row("real-time factor", f"{summary.real_time_factor:.2f}")
    colour = _COLOURS.get(summary.verdict, "yellow")
    table.add_row("acceptance", f"[bold {colour}]{summary.verdict}[/]")
    return [table, Text(summary.error)] if summary.error else [table]


def redraw(folder: Path) -> list[Path]:
    """Draw the time series in a run folder afresh and return the figures' paths."""
    return draw_series(Record.load(folder / "series.parquet"), folder / "figures")


def _number(value: float) -> str:
    if float(value).is_integer():
        return f"{value:,.0f}".replace(",", " ")
    return f"{value:.4f}"
