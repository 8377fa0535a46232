"""ContactWatch: says, once, where contact goes beyond what its model or the time step can do."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex

from contact_toolkit import ContactModel, ContactStatus, Forces
from systems.accepted_step import AcceptedStep, Poses
from systems.chatter import Chatter, Streak
from systems.explicit_stability import ContactFrequency
from systems.step_resolution import Ledger, StepResolution

# Of the stable time step 2/ω: to there, energy swings within 0.2 % (measured on bouncing balls).
_WARN_ABOVE = 0.2
# How much worse it must get to be said again.
_WORSE = 1.5

_MEANING = {
    ("area", ContactStatus.BEYOND_CAPTURE): (
        "one is in deeper than half the other's thickness, and may be pushed out the wrong way"
    ),
    ("area", ContactStatus.CROSSED): (
        "one has passed through the other's open surface, and is not pushed back"
    ),
    ("facet", ContactStatus.CROSSED): (
        "their surfaces cross: one is in deeper than the standoff, and may be pushed the wrong way"
    ),
}


@dataclass(frozen=True)
class Reported:
    """What has been warned about: the worst share of the stable step, and (pair, status).

    Of a continuous plant, also what its steps have been like.
    """

    stable_share: float = 0.0
    statuses: frozenset[tuple[int, ContactStatus]] = frozenset()
    ledger: Ledger = field(default_factory=Ledger)
    streak: Streak = field(default_factory=Streak)

    def __deepcopy__(self, memo: dict[int, Any]) -> Reported:
        """Return itself: immutable, so a context may copy it for free."""
        return self


class ContactWatch:
    """Looks at every accepted step.

    Parameters
    ----------
    plant
        A discrete one takes forces explicitly: its time step is held against the stable limit. Of a
        continuous one, the integrator's steps are held against what contact does in them.
    model, bodies
        The contact model, and the plant's body for each of its bodies.
    when_deep
        What to do when bodies penetrate farther than the web can tell: "warn" or "raise".
    when_chattering
        What to do when leaping forces leave the integrator no step to take: "warn" or "raise".
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        model: ContactModel,
        bodies: Sequence[BodyIndex],
        *,
        when_deep: str = "warn",
        when_chattering: str = "raise",
    ) -> None:
        if when_deep not in ("warn", "raise"):
            raise ValueError(f"when_deep must be warn or raise, not {when_deep!r}")
        self._when_deep = when_deep
        self._model = model
        self._time_step = plant.time_step()
        body_of = model.geometry_bodies
        pair_bodies = np.array([[body_of[pair.a], body_of[pair.b]] for pair in model.pairs])
        self._frequency = ContactFrequency(plant, bodies, pair_bodies)
        gravity = float(np.linalg.norm(plant.gravity_field().gravity_vector()))
        self._resolution = StepResolution(model, self._frequency, gravity)
        self._chatter = Chatter(model, self._frequency, when_chattering)

    def look(self, reported: Reported, step: AcceptedStep, poses: Poses) -> Reported:
        """Warn of what is new in a step; return what has been reported then.

        Parameters
        ----------
        step
            It.
        poses
            Gives the poses X_WB (nb, 4, 4) of the bodies, if asked.

        Raises
        ------
        RuntimeError
            Where the time step of a discrete plant exceeds the stable limit; where bodies are too
            deep and `when_deep` says so, or contact chatters and `when_chattering` says so.
        """
        reported = self._look_for_depth(reported, step.forces)
        if self._time_step > 0:
            return self._look_for_instability(reported, step.forces, poses)
        ledger = self._resolution.look(reported.ledger, step, poses)
        streak = self._chatter.look(reported.streak, step, poses)
        if ledger is reported.ledger and streak is reported.streak:
            return reported
        return Reported(reported.stable_share, reported.statuses, ledger, streak)

    def _look_for_depth(self, reported: Reported, forces: Forces) -> Reported:
        status = forces.found.status
        if not status.any():
            return reported
        pairs = forces.found.pairs
        seen = {
            (int(pairs[i]), bit)
            for i in np.flatnonzero(status)
            for bit in ContactStatus
            if status[i] & bit
        }
        for pair, bit in sorted(seen - reported.statuses):
            a, b = self._model.pair_names(pair)
            meaning = _MEANING[self._model.pairs[pair].web, bit]
            message = f"contact of {a} and {b}: {meaning}; take shorter steps, or stiffer contact"
            if self._when_deep == "raise":
                raise RuntimeError(message)
            warnings.warn(message, RuntimeWarning, stacklevel=2)
        return replace(reported, statuses=reported.statuses | seen)

    def _look_for_instability(self, reported: Reported, forces: Forces, poses: Poses) -> Reported:
        frequency = self._frequency.bound(poses(), forces.contacts)
        share = self._time_step * frequency / 2
        if share <= min(1.0, max(_WARN_ABOVE, _WORSE * reported.stable_share)):
            return reported
        message = (
            f"the discrete plant's time step of {self._time_step:g} s is {share:.2g} times the "
            f"stable limit 2/ω of contact that swings at up to ω = {frequency:.3g} rad/s; take "
            f"{2 * _WARN_ABOVE / frequency:.1g} s, softer contact, or a continuous plant"
        )
        if share > 1:
            raise RuntimeError(message)
        warnings.warn(message, RuntimeWarning, stacklevel=2)
        return replace(reported, stable_share=share)
