"""Contact forces at the state of the plant, as an integrator asks for them."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import NamedTuple, NoReturn

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import AbstractValue
from pydrake.multibody.plant import ExternallyAppliedSpatialForce
from pydrake.systems.framework import Context, DependencyTicket, LeafSystem, State

from contact_toolkit import ContactModel, ContactState, Forces
from systems.diagnostics.accepted_step import AcceptedStep
from systems.diagnostics.contact_watch import ContactWatch, Reported
from systems.forces.force_source import ForceSource
from systems.python_cache import holding, producer
from systems.wiring.motion_ports import MotionPorts

Floats = NDArray[np.float64]


class PresentForces(ForceSource):
    """Forces of the present.

    Parameters
    ----------
    system
        Holds state and cache.
    model
        The contact model.
    motion
        The system's ports with the motion of the bodies.
    ticket
        Of what holds the contact state.
    """

    def __init__(
        self,
        system: LeafSystem,
        model: ContactModel,
        motion: MotionPorts,
        ticket: DependencyTicket,
    ) -> None:
        self._model, self._motion = model, motion
        self.record_ticket = ticket
        # The contact state makes springs faster to find, and tells which overlaps are eased out.
        self._found = system.DeclareCacheEntry(
            "loaded springs", producer(self._find), motion.pose_tickets | {ticket}
        )
        self._forces = system.DeclareCacheEntry(
            "forces",
            producer(self._push),
            {self._found.ticket(), motion.velocity_ticket, ticket},
        )
        self.forces_tickets = self.applied_tickets = {self._forces.ticket()}

    @abstractmethod
    def _state(self, context: Context) -> ContactState:
        """Return the contact state that the context holds."""

    def _find(self, context: Context, output: AbstractValue) -> None:
        X_WB, V_WB = self._motion.read_poses(context)
        output.set_value((self._model.find(X_WB, self._state(context)), V_WB))

    def _push(self, context: Context, output: AbstractValue) -> None:
        found, V_WB = self._found.Eval(context)
        V_WB = self._motion.with_listed(context, V_WB)
        output.set_value(self._model.forces(found, V_WB, self._state(context)))

    def forces(self, context: Context) -> Forces:
        return self._forces.Eval(context)

    def generalized_forces(self, context: Context) -> Floats:
        return self._motion.bodies.generalized_forces(self.forces(context).body_wrenches)

    def spatial_forces(self, context: Context) -> list[ExternallyAppliedSpatialForce]:
        return self._motion.bodies.spatial_forces(self.forces(context).body_wrenches)

    def last_step(self, context: Context) -> None:
        del context

    def linearize_step(self, context: Context, input_port: str) -> NoReturn:
        del context, input_port
        raise RuntimeError(
            "contact is not solved with a discrete plant's step; of a continuous plant take "
            "Drake's Linearize, with ContactConfig(hold_anchors=True)"
        )


class _Record(NamedTuple):
    state: ContactState
    reported: Reported

    def __deepcopy__(self, memo: dict[int, object]) -> _Record:
        """Return itself: immutable, so a context may copy it for free."""
        return self


class ExplicitForces(PresentForces):
    """Forces of the present; the contact state goes along with accepted steps.

    Parameters
    ----------
    system, model, motion
        See `PresentForces`.
    watch
        Warns.
    """

    def __init__(
        self, system: LeafSystem, model: ContactModel, motion: MotionPorts, watch: ContactWatch
    ) -> None:
        self._watch = watch
        self._start = _Record(model.initial_state(), Reported())
        self._record = system.DeclareAbstractState(holding(self._start))
        super().__init__(system, model, motion, system.abstract_state_ticket(self._record))

    def _eval_record(self, context: Context) -> _Record:
        return context.get_abstract_state(self._record).get_value()

    def _state(self, context: Context) -> ContactState:
        return self._eval_record(context).state

    def set_state(self, context: Context, contact_state: ContactState) -> None:
        record = self._eval_record(context)._replace(state=contact_state)
        context.get_mutable_abstract_state(self._record).set_value(record)

    def declare_in(self, system: LeafSystem) -> Callable[[Context], ContactState]:
        index = system.DeclareAbstractState(holding(self._start))
        return lambda context: context.get_abstract_state(index).get_value().state

    def present_state(self, context: Context) -> ContactState:
        state = self._state(context)
        return self._model.advance(state, context.get_time(), self.forces(context))

    def begin(
        self, context: Context, state: State, start: Callable[[ContactState], ContactState]
    ) -> None:
        record = self._eval_record(context)
        self._write(state, record._replace(state=start(record.state)))

    def advance(self, context: Context, state: State) -> None:
        before, reported = self._eval_record(context)
        advanced = self.present_state(context)
        reported = self._watch.check(
            reported,
            AcceptedStep(before, advanced, self.forces(context)),
            lambda: self._motion.read_poses(context)[0],
        )
        self._write(state, _Record(advanced, reported))

    def _write(self, state: State, record: _Record) -> None:
        state.get_mutable_abstract_state(self._record).set_value(record)
