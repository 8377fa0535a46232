"""Prints the worst errors that the accuracy tests met, and writes them where asked."""

from pathlib import Path

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--accuracy-table", metavar="FILE", type=Path, help="write the table of worst errors there"
    )


def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter, config: pytest.Config
) -> None:
    worst: dict[tuple[str, float], dict[str, float]] = {}
    for reports in terminalreporter.stats.values():
        for report in reports:
            if getattr(report, "when", "") != "call":
                continue
            for name, value in report.user_properties:
                if name == "accuracy":
                    cases, limit, query, error = value
                    worst.setdefault((cases, limit), {})[query] = error
    if not worst:
        return
    table = _as_table(worst)
    terminalreporter.section("worst errors, as shares of the coordinates' size")
    terminalreporter.write_line(table)
    if path := config.getoption("--accuracy-table"):
        path.write_text(table + "\n")


def _as_table(worst: dict[tuple[str, float], dict[str, float]]) -> str:
    queries = list(dict.fromkeys(query for row in worst.values() for query in row))
    rows = [["facet pairs", "allowed", *(f"`{query}`" for query in queries)]]
    rows.append(["---"] * len(rows[0]))
    for (cases, limit), row in worst.items():
        errors = (f"{row[query]:.0e}" if query in row else "" for query in queries)
        rows.append([cases, f"{limit:.0e}", *errors])
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)
