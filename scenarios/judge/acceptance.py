"""Hold the figures of a run against the limits of its scenario."""

from __future__ import annotations

import difflib
import itertools
from collections.abc import Mapping
from dataclasses import dataclass

from scenarios.format.errors import ScenarioError
from scenarios.format.scenario import Acceptance
from scenarios.judge.expressions import check_expression, columns_in, evaluate
from scenarios.judge.measures import MEASURES, Run
from scenarios.judge.verdicts import FAILED, PASSED, UNJUDGED


@dataclass(frozen=True)
class Check:
    """One figure, its limit in words, and whether it holds."""

    figure: str
    value: float
    limit: str
    holds: bool


def check_acceptance(acceptance: Acceptance, columns: Mapping[str, object] | None = None) -> None:
    """Raise ScenarioError if a run cannot be judged by this: unknown measure, figure or column.

    With the columns of a record also those that figures read, and the body, are looked up.
    """
    if acceptance.measure and acceptance.measure not in MEASURES:
        raise ScenarioError(
            f"acceptance.measure: none is called '{acceptance.measure}'"
            f"{_instead(acceptance.measure, MEASURES)}"
        )
    for name, expression in acceptance.figures.items():
        check_expression(f"acceptance.figures.{name}", expression)
        for column in columns_in(expression):
            if columns is not None and column not in columns:
                raise ScenarioError(
                    f"acceptance.figures.{name}: no column is called '{column}'"
                    f"{_instead(column, columns)}"
                )
    if columns is not None and acceptance.body and f"{acceptance.body}.z" not in columns:
        bodies = [name.removesuffix(".z") for name in columns if name.endswith(".z")]
        raise ScenarioError(
            f"acceptance.body: no body that moves is called '{acceptance.body}'"
            f"{_instead(acceptance.body, bodies)}"
        )
    if acceptance.measure and MEASURES[acceptance.measure].needs_body and not acceptance.body:
        raise ScenarioError(f"acceptance.body is missing: '{acceptance.measure}' looks at one")
    known = figure_names(acceptance)
    for name in acceptance.limits:
        if name not in known:
            raise ScenarioError(
                f"acceptance.limits: no figure is called '{name}'{_instead(name, known)}"
            )


def figure_names(acceptance: Acceptance) -> tuple[str, ...]:
    """Return the names of the figures that a run will be measured by."""
    measured = MEASURES[acceptance.measure].figures if acceptance.measure else ()
    return (*measured, *acceptance.figures)


def columns_read(acceptance: Acceptance) -> frozenset[str] | None:
    """Return the columns of a record that its figures read; None where a measure says which."""
    if acceptance.measure:
        return None
    return frozenset(itertools.chain.from_iterable(map(columns_in, acceptance.figures.values())))


def _instead(name: str, known: Mapping[str, object] | tuple[str, ...] | list[str]) -> str:
    """Return the nearest of the known names, or all of them if none is near."""
    near = difflib.get_close_matches(name, known, 1)
    if near:
        return f"; did you mean '{near[0]}'?"
    return f"; there are: {', '.join(known)}" if known else ""


def measure(run: Run) -> dict[str, float]:
    """Return the figures of a finished run: those of its measure, then its own expressions."""
    acceptance = run.scenario.acceptance
    figures = MEASURES[acceptance.measure](run) if acceptance.measure else {}
    for name, expression in acceptance.figures.items():
        figures[name] = evaluate(expression, run.record, acceptance.window)
    return figures


def judge(acceptance: Acceptance, figures: Mapping[str, float]) -> tuple[str, list[Check]]:
    """Return the verdict and a check for each limit; raise ScenarioError for unknown figures."""
    if unknown := [name for name in acceptance.limits if name not in figures]:
        raise ScenarioError(
            f"acceptance.limits: no figure is called {', '.join(unknown)}; "
            f"'{acceptance.measure}' gives {', '.join(figures)}"
        )
    checks = [
        Check(name, figures[name], str(limit), limit.holds(figures[name]))
        for name, limit in acceptance.limits.items()
    ]
    if not checks:
        return UNJUDGED, checks
    return (PASSED if all(check.holds for check in checks) else FAILED), checks
