"""Prints what the accuracy and validation tests measured, and writes it where asked.

In a file with a table between marks, `<!-- accuracy -->` to `<!-- /accuracy -->` say, the rows
measured replace those of the same names, and the others stay: so README.md is kept up to date,
even by some of the tests.
"""

import re
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

_TABLES = {
    "accuracy": "worst errors, as shares of the coordinates' size",
    "validation": "closed forms and published figures: expected, got, error",
}


def pytest_configure() -> None:
    """Let Ctrl-C reach what tests start, where a shell started these in the background."""
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_addoption(parser: pytest.Parser) -> None:
    for name, title in _TABLES.items():
        help_text = f"write a table there: {title}"
        parser.addoption(f"--{name}-table", metavar="FILE", type=Path, help=help_text)


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
    tables = {"accuracy": _accuracy_rows, "validation": _validation_rows}
    for name, rows_of in tables.items():
        head, *rows = rows_of(_recorded(terminalreporter, name))
        if not rows:
            continue
        terminalreporter.section(_TABLES[name])
        terminalreporter.write_line(_table(head, rows))
        if path := config.getoption(f"--{name}-table"):
            _write(path, name, head, rows)


def _table(head: list[str], rows: list[list[str]]) -> str:
    return "\n".join(f"| {' | '.join(row)} |" for row in [head, ["---"] * len(head), *rows])


def _write(path: Path, name: str, head: list[str], rows: list[list[str]]) -> None:
    text = path.read_text() if path.is_file() else ""
    between = re.compile(rf"(?<=<!-- {name} -->\n).*?(?=<!-- /{name} -->)", re.DOTALL)
    if not (found := between.search(text)):
        path.write_text(_table(head, rows) + "\n")
        return
    lines = found[0].splitlines()[2:]
    old = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    kept = {tuple(row[:2]): row for row in old} | {tuple(row[:2]): row for row in rows}
    if head[0] == "#":
        kept = dict(sorted(kept.items(), key=lambda item: int(item[0][0])))
    table = _table(head, list(kept.values())) + "\n"
    path.write_text(text[: found.start()] + table + text[found.end() :])


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
    """Sort by row number; numbers may be given as such or, with a unit, as text.

    Of several cases of one name the worst is shown.
    """

    def text(value: object) -> str:
        return value if isinstance(value, str) else f"{value:.5g}"

    def error_text(value: object) -> str:
        return value if isinstance(value, str) else f"{value:.1e}"

    cases: dict[tuple[int, str], list[Any]] = {}
    for row, experiment, *figures in recorded:
        cases.setdefault((row, experiment), []).append(figures)
    rows = [["#", "experiment", "expected", "got", "error", "tolerance"]]
    for (row, experiment), figures in sorted(cases.items(), key=lambda item: item[0][0]):
        several = f" (the worst of {len(figures)} cases)" if len(figures) > 1 else ""
        expected, got, error, tolerance = max(figures, key=lambda f: f[2])
        found = [text(expected), text(got), error_text(error), error_text(tolerance)]
        rows.append([str(row), experiment + several, *found])
    return rows
