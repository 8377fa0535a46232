"""ForceSource: what the contact system's ports put out, however forces go along with steps."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import ExternallyAppliedSpatialForce
from pydrake.systems.framework import Context, DependencyTicket, LeafSystem, State

from contact_toolkit import ContactState, Forces
from systems.step.linearized_step import LinearizedStep
from systems.step.solved_step import SolvedStep

Floats = NDArray[np.float64]


class ForceSource(ABC):
    """Keeps the contact state in the system's context, and the forces in its cache.

    Its methods take the context of the system.

    Attributes
    ----------
    forces_tickets, applied_tickets
        What `forces`, and what is applied to the plant, depends on.
    record_ticket
        Of the state that it keeps.
    """

    forces_tickets: set[DependencyTicket]
    applied_tickets: set[DependencyTicket]
    record_ticket: DependencyTicket

    @abstractmethod
    def set_state(self, context: Context, contact_state: ContactState) -> None:
        """Put a contact state into the context, as if a step had just led to it."""

    @abstractmethod
    def declare_in(self, system: LeafSystem) -> Callable[[Context], ContactState]:
        """Declare in another system what keeps the contact state; return what reads it there."""

    @abstractmethod
    def forces(self, context: Context) -> Forces:
        """Return the contact forces at the present."""

    @abstractmethod
    def present_state(self, context: Context) -> ContactState:
        """Return the contact state as it would be were the present the end of a step."""

    @abstractmethod
    def generalized_forces(self, context: Context) -> Floats:
        """Return (nv,) to be applied to the plant."""

    @abstractmethod
    def spatial_forces(self, context: Context) -> list[ExternallyAppliedSpatialForce]:
        """Return those to be applied to bodies that the generalized forces leave out."""

    @abstractmethod
    def last_step(self, context: Context) -> SolvedStep | None:
        """Return the last implicit step, if there was one."""

    @abstractmethod
    def linearize_step(self, context: Context, input_port: str) -> LinearizedStep:
        """Linearize the implicit step that starts here, by the state and an input of the plant."""

    @abstractmethod
    def begin(
        self, context: Context, state: State, start: Callable[[ContactState], ContactState]
    ) -> None:
        """Write into `state` the contact state that `start` makes of the one there is."""

    @abstractmethod
    def advance(self, context: Context, state: State) -> None:
        """Write into `state` what an accepted step leaves; warn of what went wrong in it."""
