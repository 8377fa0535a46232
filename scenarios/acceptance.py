"""Hold the figures of a run against the limits of its scenario."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from scenarios.errors import ScenarioError
from scenarios.scenario import Acceptance

PASSED, FAILED = "passed", "failed"
INTERRUPTED, CRASHED, UNJUDGED = "interrupted", "crashed", "not judged"


@dataclass(frozen=True)
class Check:
    """One figure, its limit in words, and whether it holds."""

    figure: str
    value: float
    limit: str
    holds: bool


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
