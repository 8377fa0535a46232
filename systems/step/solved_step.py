"""SolvedStep: a step of a discrete plant under contact."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contact_toolkit import StepSolution

Floats = NDArray[np.float64]


class SolvedStep(NamedTuple):
    """A step of the plant under contact.

    Attributes
    ----------
    solution
        As the native solver found it; velocities in its own order.
    velocities
        (nv,) that contact was solved for.
    change
        (nv,) of the velocities in the step.
    generalized_forces
        (nv,) of contact, over the whole step.
    mismatch
        Largest difference [m/s, rad/s] between the velocities that the plant reaches and those that
        contact was solved for; 0 where the plant answers forces as A says, and was not asked.
    allowed
        Mismatch up to which the two count as agreed.
    rounds
        Solves it took contact and the plant's limits and constraints to agree.
    stiffening
        What the plant's limits and constraints were found to add to A, on the velocities that are
        not those of floating bodies; None where they add nothing. Good to begin the next step with.
    trusted
        Whether the plant's answer to contact forces was seen to be A, in this step or before, far
        from all limits.
    """

    solution: StepSolution
    velocities: Floats
    change: Floats
    generalized_forces: Floats
    mismatch: float
    allowed: float
    rounds: int
    stiffening: Floats | None = None
    trusted: bool = False

    def leads_to(self, v: Floats) -> bool:
        """Whether the plant went where its answer to forces, trusted, led to: velocities (nv,)."""
        return self.trusted and bool(np.abs(v - self.velocities).max() <= self.allowed)

    @property
    def statistics(self) -> Floats:
        """(5,) Newton iterations, force evaluations, islands, status, rounds."""
        found = self.solution
        return np.array(
            [found.iterations, found.evaluations, found.islands, found.status, self.rounds], float
        )
