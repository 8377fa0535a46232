"""ImplicitForces: contact forces of a discrete plant, solved with its steps."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import AbstractValue
from pydrake.multibody.plant import ExternallyAppliedSpatialForce, MultibodyPlant
from pydrake.systems.framework import Context, LeafSystem, State

from contact_toolkit import ContactModel, ContactState, Forces
from systems.diagnostics.contact_watch import ContactWatch, Reported
from systems.diagnostics.step_watch import StepWatch
from systems.forces.force_source import ForceSource
from systems.python_cache import holding, producer
from systems.step.implicit_step import ImplicitStep
from systems.step.linearized_step import LinearizedStep
from systems.step.solved_step import SolvedStep
from systems.wiring.motion_ports import MotionPorts
from systems.wiring.plant_inputs import PlantInputs

Floats = NDArray[np.float64]


class StepRecord(NamedTuple):
    """Contact as the last step found it, and that step.

    Attributes
    ----------
    state
        At the start of the step.
    x
        The plant's state there, as bytes.
    inputs
        What stood at its inputs.
    step
        The step; None before the first.
    reported
        What has been warned about.
    acted
        The forces of the step before, which led to the start of this one.
    """

    state: ContactState
    x: bytes
    inputs: Mapping[str, object]
    step: SolvedStep | None
    reported: Reported
    acted: Forces | None = None

    def __deepcopy__(self, memo: dict[int, object]) -> StepRecord:
        """Return itself: immutable, so a context may copy it for free."""
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle it without lists of forces: Drake does not pickle them, and they never agree."""
        arrays = {name: each for name, each in self.inputs.items() if isinstance(each, np.ndarray)}
        return StepRecord, (self.state, self.x, arrays, self.step, self.reported, self.acted)


class Arrival(NamedTuple):
    """Where the last step led.

    Attributes
    ----------
    record
        Of that step.
    x
        The plant's state, (nq + nv).
    ahead
        Whether the recorded step starts here, the plant not yet having taken it.
    state
        Of contact.
    acted
        The forces that led here. Where joints bend the way that bodies took, those at the very
        poses that they reached differ a little: the state holds these.
    """

    record: StepRecord
    x: Floats
    ahead: bool
    state: ContactState
    acted: Forces

    def __deepcopy__(self, memo: dict[int, object]) -> Arrival:
        """Return itself, as `StepRecord` does."""
        return self


class ImplicitForces(ForceSource):
    """Puts out, at the start of a step, the forces at its end.

    Parameters
    ----------
    system
        Holds state and cache.
    plant
        Finalized and discrete.
    model
        The contact model.
    motion, inputs
        The system's ports with the motion of the bodies, and with the plant's inputs.
    make_step
        Makes the implicit step, when the first is due.
    watch
        Warns.
    """

    def __init__(
        self,
        system: LeafSystem,
        plant: MultibodyPlant,
        model: ContactModel,
        motion: MotionPorts,
        inputs: PlantInputs,
        make_step: Callable[[], ImplicitStep],
        watch: ContactWatch,
    ) -> None:
        self._model, self._motion, self._inputs = model, motion, inputs
        self._make_step = make_step
        self._step: ImplicitStep | None = None
        self._making = threading.Lock()
        self._watch, self._step_watch = watch, StepWatch()
        self._half_step = plant.time_step() / 2
        self._record = system.DeclareAbstractState(
            holding(StepRecord(model.initial_state(), b"", {}, None, Reported()))
        )
        self.record_ticket = system.abstract_state_ticket(self._record)
        present = motion.pose_tickets | {
            motion.velocity_ticket,
            self.record_ticket,
            system.time_ticket(),
        }
        self._present = system.DeclareCacheEntry("present", producer(self._arrive), present)
        self._solved = system.DeclareCacheEntry(
            "step", producer(self._solve), present | {self._present.ticket()} | inputs.tickets()
        )
        self.forces_tickets = {self._present.ticket()}
        self.applied_tickets = {self._solved.ticket()}

    def _eval_record(self, context: Context) -> StepRecord:
        return context.get_abstract_state(self._record).get_value()

    def _arrive(self, context: Context, output: AbstractValue) -> None:
        """Make the contact state and the forces at the end of the step that led here."""
        record, time = self._eval_record(context), context.get_time()
        x = self._motion.state.Eval(context)
        solution = record.step.solution if record.step else None
        if (
            solution is not None
            and abs(time - solution.start_time) < self._half_step
            and record.x == x.tobytes()
        ):
            assert record.acted is not None
            output.set_value(Arrival(record, x, True, record.state, record.acted))
            return
        X_WB, V_WB = self._motion.read(context)
        if solution is not None and abs(time - solution.end_time) < self._half_step:
            acted = reached = solution.forces
            if not acted.are_at(X_WB, V_WB):
                reached = self._model.evaluate(X_WB, V_WB, record.state)
            state = self._model.advance_implicitly(record.state, solution.end_time, reached)
        else:
            acted = self._model.evaluate(X_WB, V_WB, record.state)
            state = self._model.advance(record.state, time, acted)
        output.set_value(Arrival(record, x, False, state, acted))

    def _solve(self, context: Context, output: AbstractValue) -> None:
        record, x, ahead, state, acted = self._present.Eval(context)
        inputs = self._inputs.read(context)
        if ahead and _same(record.inputs, inputs):
            output.set_value(record)
            return
        time, last = context.get_time(), record.step
        if last is not None and abs(time - last.solution.end_time) >= self._half_step:
            last = None
        step = self._implicit_step().solve(time, x, inputs, state, last)
        output.set_value(StepRecord(state, x.tobytes(), inputs, step, record.reported, acted))

    def _implicit_step(self) -> ImplicitStep:
        if self._step is None:
            with self._making:
                if self._step is None:
                    self._step = self._make_step()
        return self._step

    def linearize_step(self, context: Context, input_port: str) -> LinearizedStep:
        record: StepRecord = self._solved.Eval(context)
        assert record.step is not None
        x, inputs = self._motion.state.Eval(context), self._inputs.read(context)
        return self._implicit_step().linearize(x, inputs, record.state, record.step, input_port)

    def set_state(self, context: Context, contact_state: ContactState) -> None:
        reported = self._eval_record(context).reported
        record = StepRecord(contact_state, b"", {}, None, reported)
        context.get_mutable_abstract_state(self._record).set_value(record)

    def declare_in(self, system: LeafSystem) -> Callable[[Context], ContactState]:
        del system
        raise RuntimeError(
            "contact of a discrete plant is solved with its step, and has no AutoDiffXd: take "
            "contact.LinearizeStep(context) for the derivatives of a step, or a continuous plant "
            "(time_step=0)"
        )

    def forces(self, context: Context) -> Forces:
        return self._present.Eval(context).acted

    def present_state(self, context: Context) -> ContactState:
        return self._present.Eval(context).state

    def generalized_forces(self, context: Context) -> Floats:
        return self._solved.Eval(context).step.generalized_forces

    def spatial_forces(self, context: Context) -> list[ExternallyAppliedSpatialForce]:
        del context
        return []  # all are in the generalized ones

    def last_step(self, context: Context) -> SolvedStep | None:
        return self._eval_record(context).step

    def begin(
        self, context: Context, state: State, start: Callable[[ContactState], ContactState]
    ) -> None:
        record = self._eval_record(context)
        started = start(record.state)
        if started is not record.state:
            self._write(state, StepRecord(started, b"", {}, None, record.reported))

    def advance(self, context: Context, state: State) -> None:
        record: StepRecord = self._solved.Eval(context)
        assert record.step is not None
        assert record.state.forces is not None
        reported = self._watch.check_depth(record.reported, record.state.forces)
        reported = self._step_watch.check(reported, record.step)
        if reported is not record.reported:
            record = record._replace(reported=reported)
        self._write(state, record)

    def _write(self, state: State, record: StepRecord) -> None:
        state.get_mutable_abstract_state(self._record).set_value(record)


def _same(a: Mapping[str, object], b: Mapping[str, object]) -> bool:
    """Whether two sets of input values are the same; lists of forces never are."""
    return a.keys() == b.keys() and all(
        isinstance(value, np.ndarray) and np.array_equal(value, np.asarray(b[name]))
        for name, value in a.items()
    )
