"""Tables and figures of runs, for the terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from rich.table import Table
from rich.text import Text

from scenarios.format.errors import ScenarioError
from scenarios.format.scenario import Scenario
from scenarios.judge.verdicts import FAILED, PASSED
from scenarios.report.figures import draw_series
from scenarios.report.summary import Summary
from scenarios.simulation.record import Record

_COLOURS = {PASSED: "green", FAILED: "red"}


def scenario_table(scenarios: Mapping[str, Scenario]) -> Table:
    """Return the names of scenarios and what they show."""
    table = Table("scenario", "what it shows", box=None, pad_edge=False)
    for name, scenario in scenarios.items():
        said = scenario.description + (" (takes minutes)" if scenario.long else "")
        table.add_row(Text(name, "bold"), Text(said))
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
    table.add_row(Text("wall-clock [s]"), f"{summary.wall_time:.1f}")
    if summary.truth:
        table.add_row("truth", "", Text(summary.truth))
    table.add_row("acceptance", f"[bold {colour}]{summary.verdict}[/]")
    return [table, Text(summary.error)] if summary.error else [table]


def results_table(summaries: Sequence[Summary]) -> Table:
    """Return the verdicts of several runs."""
    table = Table("scenario", "verdict", "real-time factor", "wall-clock [s]", "")
    for summary in summaries:
        colour = _COLOURS.get(summary.verdict, "yellow")
        missed = [check.figure for check in summary.checks if not check.holds]
        why = summary.error or ", ".join(missed)
        table.add_row(
            Text(summary.scenario),
            Text(summary.verdict, colour),
            f"{summary.real_time_factor:.2f}",
            f"{summary.wall_time:.1f}",
            Text(why),
        )
    return table


def results_markdown(summaries: Sequence[Summary], scenarios: Mapping[str, Scenario]) -> str:
    """Return a table for a document: what each scenario shows, its truth and what came out."""
    rows = ["| scenario | what it shows | truth | got | verdict | × real time |",
            "|---|---|---|---|---|---|"]  # fmt: skip
    for summary in summaries:
        got = "; ".join(
            f"{check.figure} {check.value:.5g} ({check.limit})" for check in summary.checks
        )
        cells = (
            f"`{summary.scenario}`",
            scenarios[summary.scenario].description,
            summary.truth,
            got or summary.error,
            summary.verdict,
            f"{summary.real_time_factor:.2g}",
        )
        rows.append("| " + " | ".join(cell.replace("|", "∣") for cell in cells) + " |")
    return "\n".join(rows) + "\n"


def between_marks(path: Path, mark: str) -> tuple[str, str, str]:
    """Return what a document holds before, between and after its two lines <!-- mark -->.

    The second is <!-- /mark -->. Raises ScenarioError if it has no such lines.
    """
    before, begin, rest = path.read_text(encoding="utf-8").partition(f"<!-- {mark} -->\n")
    between, end, after = rest.partition(f"<!-- /{mark} -->")
    if not (begin and end):
        raise ScenarioError(
            f"{path}: no lines <!-- {mark} --> and <!-- /{mark} --> to write between"
        )
    return before + begin, between, end + after


def redraw(folder: Path) -> list[Path]:
    """Draw the time series in a run folder afresh and return the figures' paths."""
    return draw_series(Record.load(folder / "series.parquet"), folder / "figures")


def _number(value: float) -> str:
    if float(value).is_integer():
        return f"{value:,.0f}".replace(",", " ")
    return f"{value:.4f}"
