"""Prints the worst errors that the accuracy tests met, and writes them where asked."""

from pathlib import Path

import pytest

_COLUMNS = ("query", "facet pairs", "distance", "point off facet", "gap", "cases")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--accuracy-table", metavar="FILE", type=Path, help="write the table of worst errors there"
    )


def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter, config: pytest.Config
) -> None:
    rows = [
        value
        for reports in terminalreporter.stats.values()
        for report in reports
        for name, value in getattr(report, "user_properties", ())
        if name == "accuracy" and report.when == "call"
    ]
    if not rows:
        return
    cells = [[f"{x:.0e}" if isinstance(x, float) else str(x) for x in row] for row in rows]
    table = "\n".join(
        "| " + " | ".join(row) + " |" for row in [_COLUMNS, ["---"] * len(_COLUMNS), *cells]
    )
    terminalreporter.section("worst errors, as shares of the coordinates' size")
    terminalreporter.write_line(table)
    if path := config.getoption("--accuracy-table"):
        path.write_text(table + "\n")
