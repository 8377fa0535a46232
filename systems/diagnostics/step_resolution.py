"""StepResolution: warns when a continuous plant's steps are too long to resolve its contacts.

The energy balance of a contact is the measure: change of stored energy + losses + work done on the
bodies = 0. The work over a step of length h is taken from the power at both its ends (trapezoidal
rule). For a contact that swings at ω the balance then misses about (ωh)²/4 of a bounce's energy in
the step where contact begins, and (ωh)³/3 within it, whatever the integrator; at rest it misses
nothing. So a large miss means that h is too long for ω.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace

import numpy as np

from contact_toolkit import ContactModel, Forces
from systems.diagnostics.accepted_step import AcceptedStep, Poses, busiest_pair
from systems.diagnostics.contact_frequency import ContactFrequency

# A step whose balance misses more than this fraction of the largest energy stored so far is warned
# of. The energy after a bounce is then wrong by about 4 % (measured with runge_kutta3).
_OFF = 0.25
# The warning is repeated when the miss has grown by this factor.
_WORSE = 1.5
# A step without contact at either end may have passed over one. It is examined when a velocity
# changes by more than this fraction of the largest velocity, as any impact makes one do.
_ABRUPT = 0.5
# Accuracy to ask for, as a fraction of the deformation: an error of some 0.5 % in a bounce's
# energy.
_FINE = 0.01
# Phase of the contact's swing [rad] to ask for in a step.
_PHASE = 0.3


@dataclass(frozen=True)
class Ledger:
    """The most stored [J]; the most a step was off [J], and its length [s]; what was reported."""

    most_stored: float = 0.0
    most_off: float = 0.0
    off_in: float = 0.0
    reported_fraction: float = _OFF / _WORSE  # so that _OFF itself is reported
    missed_reported: bool = False


class StepResolution:
    """Checks the ledger of every step.

    Parameters
    ----------
    model
        The contact model.
    frequency
        Of the plant's bodies on the model's springs.
    gravity
        [m/s²] What it does to a velocity in a step is too slow to count as an impact: bodies at
        rest on stiff contact shake as little as the integrator's accuracy lets them.
    """

    def __init__(self, model: ContactModel, frequency: ContactFrequency, gravity: float) -> None:
        self._model = model
        self._frequency = frequency
        self._gravity = gravity

    def check(self, ledger: Ledger, step: AcceptedStep, poses: Poses) -> Ledger:
        """Warn of a step too long for contact; return the ledger after it."""
        start, end = step.before.forces, step.forces
        if step.duration < 0:  # another run
            return replace(ledger, most_stored=0.0, most_off=0.0)
        if start is None or not step.duration > 0:
            return ledger
        if len(start.loaded) or len(end.loaded):
            return self._balance(ledger, step, start, poses)
        return self._check_between(ledger, step, start, poses)

    def _balance(self, ledger: Ledger, step: AcceptedStep, start: Forces, poses: Poses) -> Ledger:
        had, has = start.stored, step.forces.stored
        lost = step.after.lost - step.before.lost
        given = step.duration / 2 * (start.power_given + step.forces.power_given)
        off = abs(has - had + lost + given)
        most_stored = max(ledger.most_stored, had, has)
        allowed = _WORSE * ledger.reported_fraction * most_stored
        slowest = self._gravity * step.duration
        if (
            off > max(ledger.most_off, allowed)
            and _approach(start, step.forces) > slowest
            and not step.jumped
        ):
            ledger = replace(ledger, most_off=off, off_in=step.duration)
        if most_stored > ledger.most_stored:
            ledger = replace(ledger, most_stored=most_stored)
        # The first step into contact can be judged only when the most has been stored.
        if has >= had or ledger.most_off <= allowed or not ledger.most_stored:
            return ledger
        fraction = ledger.most_off / ledger.most_stored
        self._warn(
            f"a step was off by {fraction:.0%} of the energy that the contact stored"
            if fraction < 1
            else "a step was off by more than the energy that the contact stored",
            ledger.off_in,
            start,
            poses,
        )
        return replace(ledger, reported_fraction=fraction)

    def _check_between(
        self, ledger: Ledger, step: AcceptedStep, start: Forces, poses: Poses
    ) -> Ledger:
        """Look for contact that began and ended within the step."""
        v0, v1 = start.V_FB[:, 3:], step.forces.V_FB[:, 3:]
        slow = max(_ABRUPT * np.abs(v0).max(), self._gravity * step.duration)
        if ledger.missed_reported or np.abs(v1 - v0).max() <= slow or step.jumped:
            return ledger
        met = self._model.coast(step.before, step.duration)
        if met is None or not len(met.contacts):
            return ledger
        self._warn("they met and parted within a step", step.duration, met, poses)
        return replace(ledger, missed_reported=True)

    def _warn(self, found: str, length: float, loaded: Forces, poses: Poses) -> None:
        contacts = loaded.contacts
        # Of bodies that only their joints make heavy it is not known.
        frequency = self._frequency.bound(poses(), contacts) or 1 / length
        deformation = max(contacts.deformation.max(), contacts.rate.max() / frequency)
        warnings.warn(
            f"{busiest_pair(self._model, contacts)}: steps of {length:.2g} s are too long "
            f"for it, {found}; call set_target_accuracy({_FINE * deformation:.0e}) of the "
            f"integrator, or set max_step to {min(_PHASE / frequency, length / 2):.0e} s",
            RuntimeWarning,
            stacklevel=2,
        )


def _approach(start: Forces, end: Forces) -> float:
    """Return the fastest deformation at either end of a step [m/s]."""
    rates = np.concatenate([start.contacts.rate, end.contacts.rate])
    return float(np.abs(rates).max())
