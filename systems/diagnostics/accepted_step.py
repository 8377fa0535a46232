"""AcceptedStep: one step of a simulation, as contact went through it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contact_toolkit import ContactArrays, ContactModel, ContactState, Forces

Poses = Callable[[], NDArray[np.float64]]  # gives X_WB (nb, 4, 4) of the bodies


@dataclass(frozen=True)
class AcceptedStep:
    """From one contact state to the next.

    Attributes
    ----------
    before, after
        The step tables at its start and end; those before the first step have no forces.
    forces
        At its end, before friction's anchors are dragged along.
    """

    before: ContactState
    after: ContactState
    forces: Forces

    @property
    def duration(self) -> float:
        """[s]; not positive where a step is looked at again, or time was set back."""
        return self.after.time - self.before.time

    @property
    def jumped(self) -> bool:
        """Whether a body is elsewhere than its velocities took it: somebody put it there."""
        start = self.before.forces
        if start is None:
            return False
        v0, v1 = start.V_FB[:, 3:], self.forces.V_FB[:, 3:]
        way = self.forces.loaded.p_FBo - start.loaded.p_FBo
        aside = np.linalg.norm(way - self.duration * (v0 + v1) / 2, axis=1)
        fastest = np.maximum(np.linalg.norm(v0, axis=1), np.linalg.norm(v1, axis=1))
        return bool((aside > 2 * self.duration * fastest).any())


def busiest_pair(model: ContactModel, contacts: ContactArrays) -> str:
    """Return `contact of A and B`, the two that push hardest on each other."""
    loads = np.bincount(contacts.pair, np.abs(contacts.normal_force))
    a, b = model.pair_names(int(loads.argmax()))
    return f"contact of {a} and {b}"
