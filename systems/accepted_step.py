"""AcceptedStep: one step of a simulation, as contact went through it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contact_toolkit import ContactArrays, ContactModel, Forces, StepTable


@dataclass(frozen=True)
class AcceptedStep:
    """From one step table to the next.

    Attributes
    ----------
    before, after
        The step tables at its start and end; those before the first step have no forces.
    forces
        At its end, before friction's anchors are dragged along.
    """

    before: StepTable
    after: StepTable
    forces: Forces

    @property
    def duration(self) -> float:
        """[s]; not positive where a step is looked at again, or time was set back."""
        return self.after.time - self.before.time


def busiest_pair(model: ContactModel, contacts: ContactArrays) -> str:
    """Return `contact of A and B`, the two that push hardest on each other."""
    loads = np.bincount(contacts.pair, np.abs(contacts.normal_force))
    a, b = model.pair_names(int(loads.argmax()))
    return f"contact of {a} and {b}"
