"""NonlinearDamperContact: contact forces between the bodies of a MultibodyPlant."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import ExternallyAppliedSpatialForce, MultibodyPlant
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DependencyTicket,
    DiagramBuilder,
    InputPort,
    LeafSystem,
    OutputPort,
    State,
)

from contact_toolkit import ContactModel, ContactState, Forces
from systems.body_motion import BodyMotion
from systems.diagnostics.accepted_step import AcceptedStep
from systems.diagnostics.contact_watch import ContactWatch, Reported
from systems.diagnostics.initial_overlap import InitialOverlap
from systems.diagnostics.step_watch import StepWatch
from systems.plant.body_pair import BodyPair
from systems.python_cache import holding, producer
from systems.step.implicit_step import ImplicitStep, SolvedStep
from systems.wiring.planning import TakenPairs
from systems.wiring.plant_inputs import PlantInputs

Floats: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True)
class StepRecord:
    """Of a discrete plant under implicit steps: contact as the last step found it, and that step.

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
    """

    state: ContactState
    x: bytes = b""
    inputs: Mapping[str, object] = field(default_factory=dict)
    step: SolvedStep | None = None

    def __deepcopy__(self, memo: dict[int, object]) -> StepRecord:
        """Return itself: immutable, so a context may copy it for free."""
        return self


class NonlinearDamperContact(LeafSystem):
    """Pushes and rubs the bodies of a plant that touch, in place of its built-in contact.

    `AddNonlinearDamperContact` makes and connects one. By hand: connect the inputs to the plant's
    output ports of the same names, and the first two outputs to its `applied_generalized_force` and
    `applied_spatial_force`.

    ::

                                  ┌──────────────────────────┐
        state ───────────────────>│                          │──> generalized_forces
        body_poses ──────────────>│  NonlinearDamperContact  │──> spatial_forces
        body_spatial_velocities ─>│                          │──> contacts
                                  │      (contact state)       │──> poses
                                  │                          │──> body_wrenches
                                  │                          │──> powers
                                  │                          │──> energies
                                  └──────────────────────────┘

    Floating bodies (on quaternions) are read from `state` and pushed by `generalized_forces`, which
    costs next to nothing; the others are read from the lists and pushed by `spatial_forces`. Ports
    that no body needs stay unconnected (see `uses_state`, `uses_lists`).

    - `generalized_forces` (nv,); `spatial_forces`, one for each loaded body of the others.
    - `contacts`: a `contact_toolkit.ContactArrays` in W, one row for each loaded spring.
    - `poses`: X_WB (nb, 4, 4) of the bodies of the model, as a numpy array.
    - `body_wrenches` (6 nb,): torque about Bo [N m] and force [N] in W of each body of the model.
    - `powers` (2,) [W]: lost in damping, lost to friction.
    - `energies` (5,) [J]: stored in normal and in tangential deformation; since the start, lost in
      damping, to friction, and to implicit steps, which take more than the law does.
    - `step_mismatch` (1,) [m/s, rad/s]: how far the last implicit step of the plant lands from
      where contact was solved for.
    - `step_statistics` (5,) of it: Newton iterations, evaluations of the contact forces, islands,
      status (0: converged), rounds until contact and the plant's own limits agreed.

    The contact state (friction anchors, losses, what speeds up the next search) is replaced once an
    accepted step. Apart from what has been warned about there is no other state; nothing changes in
    the object itself, so any number of contexts run independently.

    Contact of a discrete plant is solved with its step (`implicit`): the forces put out at the
    start of a step are those at its end, as backward Euler wants them, stable at any stiffness;
    `contacts` and the other ports tell of the step that has ended. Without `implicit` a discrete
    plant takes forces explicitly: above 0.2 times the stable time step it is warned of, with the
    number; beyond the stable step, RuntimeError.

    A continuous plant meets contact only where its integrator evaluates forces, and in free flight
    that would soon be a tenth of a second apart. So it never steps longer than `max_step`; steps
    still too long for a contact are warned of, with the accuracy to ask of the integrator.

    Parameters
    ----------
    plant
        Finalized; continuous or discrete.
    model
        The contact model.
    bodies
        The plant's body for each body of the model.
    implicit
        Makes the implicit step, when the first is due. None: explicit, or the plant is continuous.
    lists_only
        Read and push floating bodies through the lists too: slower, and equal to round-off.
    max_step
        Longest step of a continuous plant [s]; nothing may cross a body in it. Zero: no limit but
        the integrator's own.
    when_deep
        What to do when bodies penetrate farther than the web can tell: "warn", once a pair and
        context, or "raise".
    when_chattering
        What to do when forces that leap leave the integrator of a continuous plant no step to take:
        "raise", or "warn", once a context.
    initial_overlap, easing_time
        What to do about bodies that overlap at the start; see `ContactConfig`.
    taken_pairs
        Those taken from Drake's own contact, which `RestoreFilters` gives back.

    Examples
    --------
    >>> from pydrake.multibody.parsing import Parser
    >>> from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    >>> from pydrake.systems.analysis import Simulator
    >>> from pydrake.systems.framework import DiagramBuilder
    >>> from systems import AddNonlinearDamperContact
    >>> MODEL = '''<mujoco model="fall"><worldbody><geom type="plane" size="1 1 1"/>
    ...   <body name="ball" pos="0 0 0.05"><freejoint/><geom size="0.05"/></body>
    ... </worldbody></mujoco>'''
    >>> builder = DiagramBuilder()
    >>> plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.002)
    >>> _ = Parser(plant).AddModelsFromString(MODEL, "xml")
    >>> plant.Finalize()
    >>> contact = AddNonlinearDamperContact(builder, plant, scene_graph)
    >>> simulator = Simulator(builder.Build())
    >>> _ = simulator.AdvanceTo(0.5)
    >>> context = contact.GetMyContextFromRoot(simulator.get_context())
    >>> wrenches = contact.get_body_wrenches_output_port().Eval(context).reshape(-1, 6)
    >>> weight = plant.CalcTotalMass(plant.GetMyContextFromRoot(simulator.get_context())) * 9.81
    >>> (wrenches[1, 5] / weight).round(3)  # the ball is carried
    np.float64(1.0)
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        model: ContactModel,
        bodies: Sequence[BodyIndex],
        *,
        implicit: Callable[[], ImplicitStep] | None = None,
        lists_only: bool = False,
        max_step: float = 0.005,
        when_deep: str = "warn",
        when_chattering: str = "raise",
        initial_overlap: str = "ease",
        easing_time: float = 0.2,
        taken_pairs: TakenPairs | None = None,
    ) -> None:
        super().__init__()
        self._model = model
        self._bodies = tuple(bodies)
        self._taken_pairs = taken_pairs
        self._motion = BodyMotion(plant, bodies, lists_only=lists_only)
        self._no_state = np.zeros(plant.num_positions() + plant.num_velocities())
        self._declare_inputs()
        self._make_implicit = implicit
        self._implicit: ImplicitStep | None = None
        self._making = threading.Lock()
        self._inputs = PlantInputs(self, plant) if implicit else None
        self._contact_state = self.DeclareAbstractState(
            holding(StepRecord(model.initial_state()) if implicit else model.initial_state())
        )
        self._watch = ContactWatch(
            plant, model, bodies, when_deep=when_deep, when_chattering=when_chattering
        )
        self._overlap = InitialOverlap(
            plant, model, bodies, policy=initial_overlap, easing_time=easing_time
        )
        self._step_watch = StepWatch()
        self._reported = self.DeclareAbstractState(holding(Reported()))
        self._declare_cache()
        self._declare_outputs(plant.num_velocities())
        self._time_step = plant.time_step()
        self.DeclareInitializationUnrestrictedUpdateEvent(update=self._begin)
        if implicit:
            self.DeclarePeriodicUnrestrictedUpdateEvent(
                self._time_step, 0.0, self._advance_implicitly
            )
        else:
            self.DeclarePerStepUnrestrictedUpdateEvent(update=self._advance)
        if not max_step >= 0:
            raise ValueError(f"max_step must be a time [s] >= 0, not {max_step}")
        if max_step > 0 and plant.time_step() == 0:
            # No step passes the time of an event, be it to do nothing.
            self.DeclarePeriodicPublishEvent(max_step, 0.0, lambda context: None)  # noqa: ARG005

    @property
    def model(self) -> ContactModel:
        """The contact model, with the geometries and pairs that `contacts` refers to."""
        return self._model

    @property
    def bodies(self) -> tuple[BodyIndex, ...]:
        """The plant's body for each body of the model."""
        return self._bodies

    @property
    def uses_state(self) -> bool:
        """Whether `state` must be connected, and `generalized_forces` carries forces."""
        return self._motion.uses_state

    @property
    def uses_lists(self) -> bool:
        """Whether the list inputs must be connected, and `spatial_forces` carries forces."""
        return self._motion.uses_lists

    def force_between(self, context: Context, body_a: str, body_b: str) -> Floats:
        """Return what body b does to body a: (6,) torque about Ao [N m] and force [N], in W.

        Bodies are named as in `model.bodies`, `context` is a root context. For logs there is
        `PairWrenches`.
        """
        own = self.GetMyContextFromRoot(context)
        pair = BodyPair(self._model, body_a, body_b)
        contacts = self._eval_forces(own).contacts
        return pair.wrench(contacts, self.get_poses_output_port().Eval(own))

    def RestoreFilters(self, context: Context) -> None:
        """Let Drake see the pairs taken from it again, in a root context made for planning.

        Its signed distances go by the same filters as its contact: without this, a minimum-distance
        constraint of inverse kinematics is blind to what touches by this system. Do not simulate
        the context: Drake's own contact would push as well.
        """
        if self._taken_pairs is None:
            raise ValueError("no pairs were taken from Drake: this system was connected by hand")
        self._taken_pairs.restore(context)

    def get_state_input_port(self) -> InputPort:
        """Return the port for the plant's `state`, positions then velocities."""
        return self._state

    def get_body_poses_input_port(self) -> InputPort:
        """Return the port for the plant's `body_poses`."""
        return self._body_poses

    def get_body_spatial_velocities_input_port(self) -> InputPort:
        """Return the port for the plant's `body_spatial_velocities`."""
        return self._body_velocities

    def get_generalized_forces_output_port(self) -> OutputPort:
        """Return the port of the generalized forces on floating bodies."""
        return self.GetOutputPort("generalized_forces")

    def get_spatial_forces_output_port(self) -> OutputPort:
        """Return the port of the spatial forces on the other bodies."""
        return self.GetOutputPort("spatial_forces")

    def get_contacts_output_port(self) -> OutputPort:
        """Return the port of the loaded springs, a `contact_toolkit.ContactArrays` in W."""
        return self.GetOutputPort("contacts")

    def get_poses_output_port(self) -> OutputPort:
        """Return the port of the poses of the bodies of the model, (nb, 4, 4) in W."""
        return self.GetOutputPort("poses")

    def get_body_wrenches_output_port(self) -> OutputPort:
        """Return the port of the wrenches on the bodies of the model."""
        return self.GetOutputPort("body_wrenches")

    def get_powers_output_port(self) -> OutputPort:
        """Return the port of the power lost in damping and to friction [W]."""
        return self.GetOutputPort("powers")

    def get_step_mismatch_output_port(self) -> OutputPort:
        """Return the port of the mismatch of the last implicit step."""
        return self.GetOutputPort("step_mismatch")

    def get_step_statistics_output_port(self) -> OutputPort:
        """Return the port of what the last implicit step took to solve."""
        return self.GetOutputPort("step_statistics")

    @property
    def implicit(self) -> bool:
        """Whether contact is solved with the step of a discrete plant."""
        return self._make_implicit is not None

    def connect_plant_forces(self, builder: DiagramBuilder) -> None:
        """Tell the implicit step of the forces of others on the plant, before its own are added."""
        if self._inputs is not None:
            self._inputs.connect_forces(builder)

    def connect_plant_inputs(self, builder: DiagramBuilder) -> None:
        """Tell the implicit step what has been connected to the plant by now.

        `AddNonlinearDamperContact` has it called when the builder builds; only a builder that does
        so unseen (within C++) needs it called by hand, last of all.
        """
        if self._inputs is not None:
            self._inputs.connect(builder)

    def get_energies_output_port(self) -> OutputPort:
        """Return the port of the energies stored and lost [J]."""
        return self.GetOutputPort("energies")

    def _declare_inputs(self) -> None:
        self._state = self.DeclareVectorInputPort("state", len(self._no_state))
        self._body_poses = self.DeclareAbstractInputPort(
            "body_poses", AbstractValue.Make([RigidTransform()])
        )
        self._body_velocities = self.DeclareAbstractInputPort(
            "body_spatial_velocities", AbstractValue.Make([SpatialVelocity()])
        )

    def _declare_cache(self) -> None:
        record = self.abstract_state_ticket(self._contact_state)
        velocities = self.input_port_ticket(self._body_velocities.get_index())
        if self._inputs is not None:
            motion = self._pose_tickets() | {velocities, record, self.time_ticket()}
            self._present = self.DeclareCacheEntry("present", producer(self._arrive), motion)
            self._solved = self.DeclareCacheEntry(
                "step",
                producer(self._solve),
                {self._present.ticket()} | motion | self._inputs.tickets(),
            )
            return
        # The contact state makes springs faster to find, and tells which overlaps are eased out.
        self._found = self.DeclareCacheEntry(
            "loaded springs",
            producer(self._find),
            self._pose_tickets() | {self.abstract_state_ticket(self._contact_state)},
        )
        self._forces = self.DeclareCacheEntry(
            "forces", producer(self._push), {self._found.ticket(), velocities, record}
        )

    def _pose_tickets(self) -> set[DependencyTicket]:
        return {
            self.input_port_ticket(port.get_index()) for port in (self._state, self._body_poses)
        }

    def _declare_outputs(self, num_velocities: int) -> None:
        forces = {(self._present if self.implicit else self._forces).ticket()}
        step = {self._solved.ticket()} if self.implicit else forces
        wrenches = 6 * len(self._bodies)
        self.DeclareVectorOutputPort(
            "generalized_forces",
            num_velocities,
            self._output_generalized_forces,
            step,
        )
        self.DeclareAbstractOutputPort(
            "spatial_forces",
            lambda: AbstractValue.Make([ExternallyAppliedSpatialForce()]),
            self._output_spatial_forces,
            forces,
        )
        self.DeclareAbstractOutputPort("contacts", Value[object], self._output_contacts, forces)
        self.DeclareAbstractOutputPort(
            "poses", Value[object], self._output_poses, self._pose_tickets()
        )
        self.DeclareVectorOutputPort("body_wrenches", wrenches, self._output_wrenches, forces)
        self.DeclareVectorOutputPort("powers", 2, self._output_powers, forces)
        self.DeclareVectorOutputPort(
            "energies", 5, self._output_energies, forces | {self.time_ticket()}
        )
        last = {self.abstract_state_ticket(self._contact_state)}
        self.DeclareVectorOutputPort("step_mismatch", 1, self._output_mismatch, last)
        self.DeclareVectorOutputPort("step_statistics", 5, self._output_statistics, last)

    def _read_motion(self, context: Context) -> tuple[Floats, Floats]:
        """Return poses, and velocities without those of listed bodies."""
        state = self._state.Eval(context) if self._motion.uses_state else self._no_state
        X_WB, V_WB = self._motion.read_state(state)
        if self._motion.uses_lists:
            self._motion.fill_in_poses(X_WB, self._body_poses.Eval(context))
        return X_WB, V_WB

    def _find(self, context: Context, output: AbstractValue) -> None:
        X_WB, V_WB = self._read_motion(context)
        output.set_value((self._model.find(X_WB, self._eval_state(context)), V_WB))

    def _push(self, context: Context, forces: AbstractValue) -> None:
        found, V_WB = self._found.Eval(context)
        if self._motion.uses_lists:
            V_WB = V_WB.copy()
            self._motion.fill_in_velocities(V_WB, self._body_velocities.Eval(context))
        forces.set_value(self._model.forces(found, V_WB, self._eval_state(context)))

    def _eval_state(self, context: Context) -> ContactState:
        return context.get_abstract_state(self._contact_state).get_value()

    def _eval_record(self, context: Context) -> StepRecord:
        """Return the record of implicit steps, which holds the contact state."""
        return context.get_abstract_state(self._contact_state).get_value()

    def _eval_forces(self, context: Context) -> Forces:
        if self.implicit:
            return self._present.Eval(context)[1]
        return self._forces.Eval(context)

    def _eval_advanced_state(self, context: Context) -> ContactState:
        """Return the contact state as it would be were the present the end of a step."""
        if self.implicit:
            return self._present.Eval(context)[0]
        forces = self._eval_forces(context)
        return self._model.advance(self._eval_state(context), context.get_time(), forces)

    def _begin(self, context: Context, state: State) -> None:
        before = self._eval_record(context).state if self.implicit else self._eval_state(context)
        X_WB, V_WB = self._read_motion(context)
        if self._motion.uses_lists:
            self._motion.fill_in_velocities(V_WB, self._body_velocities.Eval(context))
        started = self._overlap.begin(
            before, lambda: self._model.evaluate(X_WB, V_WB), context.get_time()
        )
        if started is not before:
            value = StepRecord(started) if self.implicit else started
            state.get_mutable_abstract_state(self._contact_state).set_value(value)

    def _advance(self, context: Context, state: State) -> None:
        before, advanced = self._eval_state(context), self._eval_advanced_state(context)
        reported = self._watch.check(
            context.get_abstract_state(self._reported).get_value(),
            AcceptedStep(before, advanced, self._eval_forces(context)),
            lambda: self._read_motion(context)[0],
        )
        state.get_mutable_abstract_state(self._reported).set_value(reported)
        state.get_mutable_abstract_state(self._contact_state).set_value(advanced)

    def _is_ahead(self, record: StepRecord, context: Context) -> bool:
        """Whether the recorded step starts here, the plant not yet having taken it."""
        if record.step is None:
            return False
        since = context.get_time() - record.step.solution.start_time
        return abs(since) < self._time_step / 2 and record.x == self._state.Eval(context).tobytes()

    def _arrive(self, context: Context, output: AbstractValue) -> None:
        """Make the contact state and the forces at the end of the step that led here."""
        record = self._eval_record(context)
        if self._is_ahead(record, context):
            output.set_value((record.state, record.state.forces))
            return
        X_WB, V_WB = self._read_motion(context)
        if self._motion.uses_lists:
            V_WB = V_WB.copy()
            self._motion.fill_in_velocities(V_WB, self._body_velocities.Eval(context))
        solution = record.step.solution if record.step else None
        time = context.get_time()
        if solution is not None and abs(time - solution.end_time) < self._time_step / 2:
            forces = solution.forces
            if not forces.are_at(X_WB, V_WB):
                forces = self._model.evaluate(X_WB, V_WB, record.state)
            state = self._model.advance_implicitly(record.state, solution.end_time, forces)
        else:
            forces = self._model.evaluate(X_WB, V_WB, record.state)
            state = self._model.advance(record.state, time, forces)
        output.set_value((state, forces))

    def _solve(self, context: Context, output: AbstractValue) -> None:
        record = self._eval_record(context)
        assert self._inputs is not None
        x, inputs = self._state.Eval(context), self._inputs.read(context)
        if self._is_ahead(record, context) and _same(record.inputs, inputs):
            output.set_value(record)
            return
        state, _ = self._present.Eval(context)
        step = self._implicit_step().solve(context.get_time(), x, inputs, state)
        output.set_value(StepRecord(state, x.tobytes(), inputs, step))

    def _implicit_step(self) -> ImplicitStep:
        with self._making:
            if self._implicit is None:
                assert self._make_implicit is not None
                self._implicit = self._make_implicit()
            return self._implicit

    def _advance_implicitly(self, context: Context, state: State) -> None:
        record: StepRecord = self._solved.Eval(context)
        assert record.step is not None
        before = context.get_abstract_state(self._reported).get_value()
        reported = self._watch.check_depth(before, self._eval_forces(context))
        reported = self._step_watch.check(reported, record.step)
        if reported is not before:
            state.get_mutable_abstract_state(self._reported).set_value(reported)
        state.get_mutable_abstract_state(self._contact_state).set_value(record)

    def _output_generalized_forces(self, context: Context, output: BasicVector) -> None:
        if self.implicit:
            output.SetFromVector(self._solved.Eval(context).step.generalized_forces)
            return
        wrenches = self._eval_forces(context).body_wrenches
        output.SetFromVector(self._motion.generalized_forces(wrenches))

    def _output_spatial_forces(self, context: Context, output: AbstractValue) -> None:
        wrenches = self._eval_forces(context).body_wrenches
        output.set_value([] if self.implicit else self._motion.spatial_forces(wrenches))

    def _output_mismatch(self, context: Context, output: BasicVector) -> None:
        step = self._eval_record(context).step if self.implicit else None
        output.SetFromVector([step.mismatch if step else 0.0])

    def _output_statistics(self, context: Context, output: BasicVector) -> None:
        step = self._eval_record(context).step if self.implicit else None
        output.SetFromVector(step.statistics if step else np.zeros(5))

    def _output_contacts(self, context: Context, output: AbstractValue) -> None:
        output.set_value(self._eval_forces(context).contacts)

    def _output_poses(self, context: Context, output: AbstractValue) -> None:
        output.set_value(self._read_motion(context)[0])

    def _output_wrenches(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._eval_forces(context).body_wrenches.ravel())

    def _output_powers(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._eval_forces(context).powers)

    def _output_energies(self, context: Context, output: BasicVector) -> None:
        stored = self._eval_forces(context).energies
        state = self._eval_advanced_state(context)
        output.SetFromVector(np.concatenate([stored, state.losses, [state.numerical_loss]]))


def _same(a: Mapping[str, object], b: Mapping[str, object]) -> bool:
    """Whether two sets of input values are the same; lists of forces never are."""
    return a.keys() == b.keys() and all(
        isinstance(value, np.ndarray) and np.array_equal(value, np.asarray(b[name]))
        for name, value in a.items()
    )
