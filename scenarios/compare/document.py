"""What the engines made of a scenario, in a document: between its marks, with the figure beside."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path

from scenarios.compare.outcome import Outcome
from scenarios.compare.tables import comparison_rows
from scenarios.format.scenario import Scenario
from scenarios.report.report import between_marks

PICTURES = "compare"  # the folder of the figures, beside the document


def check_document(document: Path, name: str) -> None:
    """Raise ScenarioError if there is no place in the document for a scenario."""
    between_marks(document, name)


def write_into(
    document: Path, name: str, scenario: Scenario, outcomes: Sequence[Outcome], folder: Path
) -> None:
    """Write results into a document, and the figure of the comparison in `folder` beside it."""
    picture = document.parent / PICTURES / f"{name}.png"
    picture.parent.mkdir(exist_ok=True)
    shutil.copyfile(folder / "comparison.png", picture)
    before, _, after = between_marks(document, name)
    results = comparison_markdown(name, scenario, outcomes)
    document.write_text(before + results + after, encoding="utf-8")


def comparison_markdown(name: str, scenario: Scenario, outcomes: Sequence[Outcome]) -> str:
    """Return the table, what is known of the engines, and the figure."""
    heads, rows = comparison_rows(scenario, outcomes)
    lines = [heads, ["---"] * len(heads), *rows]
    table = "\n".join(f"| {' | '.join(line)} |" for line in lines)
    said = [f"- {outcome.engine}: {outcome.error}" for outcome in outcomes if outcome.error]
    known = [f"- {engine}: {why}" for engine, why in scenario.cannot.items()]
    told = "\n".join(said + known)
    picture = f"![{name}: the engines beside each other]({PICTURES}/{name}.png)"
    return f"Truth: {scenario.acceptance.truth}\n\n{table}\n\n{told}\n\n{picture}\n\n"
