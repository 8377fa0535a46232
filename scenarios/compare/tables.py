"""What the engines made of a scenario, in a table."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from rich.table import Table
from rich.text import Text

from scenarios.compare.outcome import Outcome
from scenarios.format.scenario import Scenario


def comparison_table(name: str, scenario: Scenario, outcomes: Sequence[Outcome]) -> Table:
    """Return one column an engine: verdict, the figures judged, and what any run can be asked."""
    heads, lines = comparison_rows(scenario, outcomes)
    table = Table(title=name, title_justify="left")
    for head in ("", *(row[0] for row in lines)):
        table.add_column(head)
    verdicts = (Text(row[1], "green" if row[1] == "passed" else "red") for row in lines)
    table.add_row(heads[1], *verdicts)
    for number, head in enumerate(heads[2:], start=2):
        table.add_row(Text(head), *(row[number] for row in lines))
    for outcome in outcomes:
        if outcome.error:
            table.caption = f"{table.caption or ''}{outcome.engine}: {outcome.error}\n"
    return table


def comparison_rows(
    scenario: Scenario, outcomes: Sequence[Outcome]
) -> tuple[list[str], list[list[str]]]:
    """Return the heads of the table's columns and a row an engine."""
    acceptance = scenario.acceptance
    judged = [name for name in acceptance.limits if any(name in o.figures for o in outcomes)]
    found, values = [], dict[str, str]()
    for outcome in outcomes:
        of_any = {
            "creep [µm/s]": outcome.creep(acceptance.window),
            "energy gained [J]": outcome.energy_gained(),
            "deepest overlap [mm]": 1e3 * outcome.penetration,
            "wall-clock [s]": outcome.wall_time if outcome.record is not None else np.nan,
            "× real time": outcome.real_time_factor,
        }
        values = {
            f"{name} ({acceptance.limits[name]})": f"{outcome.figures.get(name, np.nan):.5g}"
            for name in judged
        } | {name: f"{value:.2g}" for name, value in of_any.items() if name not in judged}
        cells = ["–" if value == "nan" else value for value in values.values()]
        found.append([outcome.engine, outcome.verdict, *cells])
    return ["engine", "verdict", *values], found
