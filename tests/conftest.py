"""Prints what the accuracy and validation tests measured, and writes it where asked."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

_OPTIONS = {
    "--accuracy-table": "write the table of worst errors there",
    "--validation-table": "write the table of validation rows there: expected, got, error",
}


def pytest_addoption(parser: pytest.Parser) -> None:
    for option, purpose in _OPTIONS.items():
        parser.addoption(option, metavar="FILE", type=Path, help=purpose)


def pytest_runtest_makereport(item: pytest.Item) -> None:
    """Make recorded numpy numbers plain ones: workers can send nothing else."""

    def plain(value: Any) -> Any:
        if isinstance(value, tuple):
            return tuple(map(plain, value))
        return value.item() if isinstance(value, np.generic) else value

    item.user_properties[:] = [(name, plain(value)) for name, value in item.user_properties]


def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter, config: pytest.Config
) -> None:
    def show(option: str, title: str, rows: list[list[str]]) -> None:
        if len(rows) == 1:
            return
        rows.insert(1, ["---"] * len(rows[0]))
        table = "\n".join(f"| {' | '.join(row)} |" for row in rows)
        terminalreporter.section(title)
        terminalreporter.write_line(table)
        if path := config.getoption(option):
            path.write_text(table + "\n")

    show(
        "--accuracy-table",
        "worst errors, as shares of the coordinates' size",
        _accuracy_rows(_recorded(terminalreporter, "accuracy")),
    )
    show(
        "--validation-table",
        "closed forms and published figures",
        _validation_rows(_recorded(terminalreporter, "validation")),
    )


def _recorded(terminalreporter: pytest.TerminalReporter, name: str) -> Iterator[Any]:
    """Yield what tests recorded as properties of this name."""
    for reports in terminalreporter.stats.values():
        for report in reports:
            if getattr(report, "when", "") == "call":
                yield from (value for key, value in report.user_properties if key == name)


def _accuracy_rows(recorded: Iterator[Any]) -> list[list[str]]:
    worst: dict[tuple[str, float], dict[str, float]] = {}
    for cases, limit, query, error in recorded:
        worst.setdefault((cases, limit), {})[query] = error
    queries = list(dict.fromkeys(query for row in worst.values() for query in row))
    rows = [["facet pairs", "allowed", *(f"`{query}`" for query in queries)]]
    for (cases, limit), row in worst.items():
        errors = (f"{row[query]:.0e}" if query in row else "" for query in queries)
        rows.append([cases, f"{limit:.0e}", *errors])
    return rows


def _validation_rows(recorded: Iterator[Any]) -> list[list[str]]:
    """Sort by row number; numbers may be given as such or, with a unit, as text."""

    def text(value: object) -> str:
        return value if isinstance(value, str) else f"{value:.5g}"

    def error_text(value: object) -> str:
        return value if isinstance(value, str) else f"{value:.1e}"

    rows = [["#", "experiment", "expected", "got", "error", "tolerance"]]
    for row, experiment, expected, got, error, tolerance in sorted(recorded, key=lambda r: r[0]):
        figures = [text(expected), text(got), error_text(error), error_text(tolerance)]
        rows.append([str(row), experiment, *figures])
    return rows
