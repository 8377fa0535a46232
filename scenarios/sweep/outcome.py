"""What one run of a sweep comes to. Without Drake, for who only passes it on."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from scenarios.simulation.record import Record


@dataclass(frozen=True)
class Outcome:
    """What one run comes to.

    The verdict is one of a `Summary`, or "timed out"; `reason` says why a run has no figures.
    Times in [s]; `record` is there only if it was asked for.
    """

    verdict: str
    reason: str = ""
    figures: dict[str, float] = field(default_factory=dict)
    simulated_time: float = 0.0
    wall_time: float = 0.0
    steps: int = 0
    record: Record | None = None

    def row(self) -> dict[str, Any]:
        """Return all but the record as plain values."""
        row = asdict(self)
        del row["record"]
        return row
