"""HeldForces: contact forces whose anchors stay where they were put."""

from __future__ import annotations

from collections.abc import Callable

from pydrake.systems.framework import AbstractParameterIndex, Context, LeafSystem, State

from contact_toolkit import ContactModel, ContactState
from systems.forces.explicit_forces import PresentForces
from systems.python_cache import holding
from systems.wiring.motion_ports import MotionPorts


class HeldForces(PresentForces):
    """Forces of the present; the contact state is a parameter, so that the system has no state.

    Parameters
    ----------
    system, model, motion
        See `PresentForces`.
    """

    def __init__(self, system: LeafSystem, model: ContactModel, motion: MotionPorts) -> None:
        self._start = model.initial_state()
        self._parameter = system.DeclareAbstractParameter(holding(self._start))
        ticket = system.abstract_parameter_ticket(AbstractParameterIndex(self._parameter))
        super().__init__(system, model, motion, ticket)

    def _state(self, context: Context) -> ContactState:
        return context.get_abstract_parameter(self._parameter).get_value()

    def set_state(self, context: Context, contact_state: ContactState) -> None:
        context.get_mutable_abstract_parameter(self._parameter).set_value(contact_state)

    def declare_in(self, system: LeafSystem) -> Callable[[Context], ContactState]:
        index = system.DeclareAbstractParameter(holding(self._start))
        return lambda context: context.get_abstract_parameter(index).get_value()

    def present_state(self, context: Context) -> ContactState:
        return self._state(context)

    def begin(
        self, context: Context, state: State, start: Callable[[ContactState], ContactState]
    ) -> None:
        del context, state, start

    def advance(self, context: Context, state: State) -> None:
        del context, state
