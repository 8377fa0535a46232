"""Chatter: tells when forces that leap leave an integrator with error control no step to take.

Between flat faces of the facet web the closest points leap from corner to corner, and the torque
with them. The integrator then takes steps that get nowhere, or shrinks them until it gives up, with
an error of its own that names no body.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from contact_toolkit import ContactModel, Forces
from systems.accepted_step import AcceptedStep, busiest_pair
from systems.explicit_stability import ContactFrequency

# [s], and as a share of the time: a thousand and ten times the least step of Drake's integrators.
# After so many tiny steps in a row, one next to the least may be the last. Events that all but
# coincide also make tiny steps, but not so many.
_TINY, _NEXT_TO_LEAST = 1e-11, 1e-13
_TINY_IN_A_ROW = 4
# So many steps should take contact through more than this phase [rad] of its fastest swing.
_STEPS = 1000
_PHASE = 0.1
# By what share the torque changes in a step, on average over them: where forces are smooth, hardly.
_LEAP = 0.01


@dataclass(frozen=True)
class Streak:
    """Steps in contact, in a row.

    Attributes
    ----------
    since, count
        When they began [s], and how many there are.
    tiny
        How many of the last were tiny.
    slow, leaps
        Whether those before got nowhere; then, the sum of relative changes of torque.
    told
        Whether it has been warned of.
    """

    since: float = 0.0
    count: int = 0
    tiny: int = 0
    slow: bool = False
    leaps: float = 0.0
    told: bool = False


class Chatter:
    """Looks at every step of a continuous plant.

    Parameters
    ----------
    model
        The contact model.
    frequency
        Of the plant's bodies on the model's springs.
    when_chattering
        "raise", or "warn" once.
    """

    def __init__(
        self, model: ContactModel, frequency: ContactFrequency, when_chattering: str
    ) -> None:
        if when_chattering not in ("warn", "raise"):
            raise ValueError(f"when_chattering must be warn or raise, not {when_chattering!r}")
        self._model = model
        self._frequency = frequency
        self._raise = when_chattering == "raise"

    def look(
        self, streak: Streak, step: AcceptedStep, poses: Callable[[], NDArray[np.float64]]
    ) -> Streak:
        """Raise RuntimeError, or warn, of chatter; return the streak after the step."""
        start, duration = step.before.forces, step.duration
        if start is None or not duration > 0 or streak.told:
            return streak
        # Where surfaces cross, or are in too deep, forces have no side and no potential either.
        if not len(step.forces.found) or step.forces.found.status.any():
            return Streak() if streak.count else streak
        scale = max(1.0, step.after.time)
        leap = _leap(start, step.forces) if streak.slow else 0.0
        streak = Streak(
            since=streak.since if streak.count else step.before.time,
            count=streak.count + 1,
            tiny=streak.tiny + 1 if duration < _TINY * scale else 0,
            slow=streak.slow,
            leaps=streak.leaps + leap,
        )
        if streak.tiny >= _TINY_IN_A_ROW and duration < _NEXT_TO_LEAST * scale:
            return self._tell(streak, streak.tiny, duration, step, poses)
        if streak.count < _STEPS:
            return streak
        elapsed = step.after.time - streak.since
        phase = elapsed * self._frequency.bound(poses(), step.forces.contacts)
        # Zero where bodies are heavy only by their joints: then it is not known.
        slow = 0 < phase < _PHASE
        if slow and streak.slow and streak.leaps > _STEPS * _LEAP:
            return self._tell(streak, _STEPS, elapsed / _STEPS, step, poses)
        return Streak(slow=slow)

    def _tell(
        self,
        streak: Streak,
        count: int,
        length: float,
        step: AcceptedStep,
        poses: Callable[[], NDArray[np.float64]],
    ) -> Streak:
        contacts = step.forces.contacts
        phase = length * self._frequency.bound(poses(), contacts)
        message = (
            f"{busiest_pair(self._model, contacts)} chatters: {count} steps in a row of "
            f"{length:.1e} s, {phase / (2 * np.pi):.1e} of the period of its fastest swing, as "
            "where its torque leaps between flat faces of the facet web; use the area web, a "
            "coarser accuracy, or a discrete plant"
        )
        if self._raise:
            raise RuntimeError(message)
        warnings.warn(message, RuntimeWarning, stacklevel=2)
        return replace(streak, told=True)


def _leap(start: Forces, end: Forces) -> float:
    """Return by what share of itself the torque on bodies changes."""
    before, after = start.body_wrenches[:, :3], end.body_wrenches[:, :3]
    largest = max(np.abs(before).max(), np.abs(after).max())
    return float(np.abs(after - before).max() / largest) if largest > 0 else 0.0
