"""Chatter: finds discontinuous contact forces that stall an integrator with error control.

Between flat parallel faces the closest points of the facet web jump from corner to corner, and the
torque with them. The integrator's error estimate then asks for ever shorter steps: simulated time
all but stops, or the integrator gives up with an error that names no body. This check notices
either and names the pair.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace

import numpy as np

from contact_toolkit import ContactModel, Forces
from systems.diagnostics.accepted_step import AcceptedStep, Poses, busiest_pair
from systems.diagnostics.contact_frequency import ContactFrequency

# Relative to max(1 s, time), as Drake's least step is: 1000 and 10 times that step. An integrator
# about to give up takes several tiny steps in a row, then one near the least. Events at almost the
# same time make tiny steps too, but not as many.
_TINY, _NEXT_TO_LEAST = 1e-11, 1e-13
_TINY_IN_A_ROW = 4
# An integrator that resolves a contact turns its fastest oscillation by more than _PHASE [rad] in
# _STEPS steps; one that does not is stalled or has reached rest.
_STEPS = 1000
_PHASE = 0.1
# Stalled by jumps rather than at rest: the torque changes by more than this fraction in a step, on
# average over _STEPS steps.
_LEAP = 0.01
# Torque below this fraction of the force times the size of the smallest geometry is rounding.
_NOISE = 1e-6


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
        Whether the thousand before got nowhere; only then, the sum of relative changes of torque.
    warned
        Whether it has been warned of.
    """

    since: float = 0.0
    count: int = 0
    tiny: int = 0
    slow: bool = False
    leaps: float = 0.0
    warned: bool = False


class Chatter:
    """Checks every step of a continuous plant.

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
        self._size = min(geometry.mesh.diagonal for geometry in model.geometries)

    def check(self, streak: Streak, step: AcceptedStep, poses: Poses) -> Streak:
        """Raise RuntimeError, or warn, of chatter; return the streak after the step."""
        start, duration = step.before.forces, step.duration
        if duration == 0 or streak.warned:
            return streak
        found = step.forces.loaded
        # Another run begins, or contact ends. Where surfaces cross, or are in too deep, forces have
        # no side and no potential either.
        if start is None or duration < 0 or not len(found) or found.status.any():
            return Streak() if streak.count else streak
        scale = max(1.0, step.after.time)
        leap = self._leap(start, step.forces) if streak.slow else 0.0
        streak = Streak(
            since=streak.since if streak.count else step.before.time,
            count=streak.count + 1,
            tiny=streak.tiny + 1 if duration < _TINY * scale else 0,
            slow=streak.slow,
            leaps=streak.leaps + leap,
        )
        if streak.tiny >= _TINY_IN_A_ROW and duration < _NEXT_TO_LEAST * scale:
            return self._warn(streak, streak.tiny, duration, step, poses)
        if streak.count < _STEPS:
            return streak
        elapsed = step.after.time - streak.since
        phase = elapsed * self._frequency.bound(poses(), step.forces.contacts)
        # Zero where bodies are heavy only by their joints: then it is not known.
        slow = 0 < phase < _PHASE
        if slow and streak.slow and streak.leaps > _STEPS * _LEAP:
            return self._warn(streak, _STEPS, elapsed / _STEPS, step, poses)
        return Streak(slow=slow)

    def _warn(
        self,
        streak: Streak,
        count: int,
        length: float,
        step: AcceptedStep,
        poses: Poses,
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
        return replace(streak, warned=True)

    def _leap(self, start: Forces, end: Forces) -> float:
        """Return by what fraction the torque on bodies changes, leaving out rounding."""
        before, after = start.body_wrenches, end.body_wrenches
        torque, force = (
            max(np.abs(before[:, part]).max(), np.abs(after[:, part]).max())
            for part in (slice(0, 3), slice(3, 6))
        )
        largest = max(torque, _NOISE * force * self._size)
        return float(np.abs(after - before)[:, :3].max() / largest) if largest > 0 else 0.0
