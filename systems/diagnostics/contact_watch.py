"""ContactWatch: says, once, where contact goes beyond what its model or the time step can do."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex

from contact_toolkit import (
    AreaWeb,
    ContactArrays,
    ContactModel,
    ContactStatus,
    FacetWeb,
    Forces,
    PointWeb,
)
from systems.diagnostics.accepted_step import AcceptedStep, Poses
from systems.diagnostics.chatter import Chatter, Streak
from systems.diagnostics.contact_frequency import ContactFrequency
from systems.diagnostics.step_resolution import Ledger, StepResolution

Floats = NDArray[np.float64]

# Of the stable time step 2/ω: to there, energy swings within 0.2 % (measured on bouncing balls).
_WARN_ABOVE = 0.2
# How much worse it must get to be said again.
_WORSE = 1.5

_MEANING = {
    (AreaWeb, ContactStatus.BEYOND_CAPTURE): (
        "one is in deeper than half the other's thickness, and may be pushed out the wrong way"
    ),
    (PointWeb, ContactStatus.BEYOND_CAPTURE): (
        "one is in deeper than half the other's thickness, and may be pushed out the wrong way"
    ),
    (AreaWeb, ContactStatus.CROSSED): (
        "one has passed through the other's open surface, and is not pushed back"
    ),
    (FacetWeb, ContactStatus.CROSSED): (
        "their surfaces cross: one is in deeper than the standoff, and may be pushed the wrong way"
    ),
}


@dataclass(frozen=True)
class Reported:
    """What has been warned about: the worst fraction of the stable step, and (pair, status).

    Of a continuous plant, also what its steps have been like; of implicit steps, how many were not
    solved, and whether any landed elsewhere.
    """

    stable_fraction: float = 0.0
    statuses: frozenset[tuple[int, ContactStatus]] = frozenset()
    ledger: Ledger = field(default_factory=Ledger)
    streak: Streak = field(default_factory=Streak)
    failed_steps: int = 0
    mismatched: bool = False

    def __deepcopy__(self, memo: dict[int, Any]) -> Reported:
        """Return itself: immutable, so a context may copy it for free."""
        return self


class ContactWatch:
    """Checks every accepted step.

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
        dampers = [pair.damper for pair in model.pairs]
        self._alpha, self._settling, self._smallest = (
            np.array([getattr(damper, name) for damper in dampers])
            for name in ("alpha", "settling", "smallest")
        )
        gravity = float(np.linalg.norm(plant.gravity_field().gravity_vector()))
        self._resolution = StepResolution(model, self._frequency, gravity)
        self._chatter = Chatter(model, self._frequency, when_chattering)

    def check(self, reported: Reported, step: AcceptedStep, poses: Poses) -> Reported:
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
        reported = self.check_depth(reported, step.forces)
        if self._time_step > 0:
            return self._check_stability(reported, step.forces, poses)
        ledger = self._resolution.check(reported.ledger, step, poses)
        streak = self._chatter.check(reported.streak, step, poses)
        if ledger is reported.ledger and streak is reported.streak:
            return reported
        return replace(reported, ledger=ledger, streak=streak)

    def check_depth(self, reported: Reported, forces: Forces) -> Reported:
        """Warn of, or raise for, pairs that are deeper than their web can tell."""
        loaded = forces.loaded
        if loaded.nominal:
            return reported
        pairs, status = loaded.pairs, loaded.status
        seen = {
            (int(pairs[i]), bit)
            for i in np.flatnonzero(status)
            for bit in ContactStatus
            if status[i] & bit
        }
        for pair, bit in sorted(seen - reported.statuses):
            a, b = self._model.pair_names(pair)
            meaning = _MEANING[type(self._model.pairs[pair].web), bit]
            message = f"contact of {a} and {b}: {meaning}; take shorter steps, or stiffer contact"
            if self._when_deep == "raise":
                raise RuntimeError(message)
            warnings.warn(message, RuntimeWarning, stacklevel=2)
        return replace(reported, statuses=reported.statuses | seen)

    def _damping(self, contacts: ContactArrays) -> Floats:
        """Return ∂F/∂δ̇ [N s/m] of each spring, (nc,)."""
        pair, speed = contacts.pair, np.abs(contacts.rate)
        smallest, settling = self._smallest[pair], self._settling[pair]
        share = np.divide(settling, settling + speed, out=np.zeros_like(speed), where=settling > 0)
        counted = 1 + (smallest * settling - speed**2) * (share / (smallest + speed)) ** 2
        return 1.5 * self._alpha[pair] * counted * np.maximum(contacts.normal_force, 0.0)

    def _check_stability(self, reported: Reported, forces: Forces, poses: Poses) -> Reported:
        # Explicit steps are stable where h² ω² + 2 h c/m < 4: damping is as a stiffness 2 c/h.
        contacts = forces.contacts
        stiffness = contacts.stiffness + 2 * self._damping(contacts) / self._time_step
        allowed = min(1.0, max(_WARN_ABOVE, _WORSE * reported.stable_fraction))
        frequency = self._frequency.bound(
            poses(), contacts, stiffness=stiffness, enough=2 * allowed / self._time_step
        )
        fraction = self._time_step * frequency / 2
        if fraction <= allowed:
            return reported
        message = (
            f"the discrete plant's time step of {self._time_step:g} s is {fraction:.2g} times the "
            f"stable limit 2/ω of contact that swings at up to ω = {frequency:.3g} rad/s; take "
            f"{2 * _WARN_ABOVE / frequency:.1g} s, softer contact, or a continuous plant"
        )
        if fraction > 1:
            raise RuntimeError(message)
        warnings.warn(message, RuntimeWarning, stacklevel=2)
        return replace(reported, stable_fraction=fraction)
