"""PlantTwin: what a discrete plant would do in a step, asked without touching the plant."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, JacobianWrtVariable, JointActuatorIndex
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, State

from systems.plant.pairs import GeometryPair
from systems.wiring.builtin_contact import take_over_pairs

Floats = NDArray[np.float64]
_OURS = "applied_generalized_force"


class PlantTwin:
    """A copy of a discrete plant and its scene graph, whose update is called as a function.

    With it the plant's own step is known whatever it holds: gravity, actuation and controllers with
    their limits, joint damping and limits, constraints, built-in contact of other bodies. Contexts
    are scratch, one for each thread; every answer depends on the arguments alone.

    Parameters
    ----------
    plant
        Finalized and discrete.
    scene_graph
        Its scene graph.
    pairs
        Geometries that do not touch by built-in contact.
    """

    def __init__(
        self, plant: MultibodyPlant, scene_graph: SceneGraph, pairs: Sequence[GeometryPair]
    ) -> None:
        builder = DiagramBuilder()
        self._plant = builder.AddSystem(plant.Clone())
        copy = builder.AddSystem(scene_graph.Clone())
        take_over_pairs(copy, self._plant.get_source_id(), pairs)
        _copy_controllers(plant, self._plant)
        builder.Connect(
            self._plant.get_geometry_pose_output_port(),
            copy.get_source_pose_port(self._plant.get_source_id()),
        )
        builder.Connect(copy.get_query_output_port(), self._plant.get_geometry_query_input_port())
        inspector = copy.model_inspector()
        self._touching = {
            self._plant.GetBodyFromFrameId(inspector.GetFrameId(geometry)).index()
            for pair in inspector.GetCollisionCandidates()
            for geometry in pair
        }
        self._diagram = builder.Build()
        self._sampled = self._plant.has_sampled_output_ports()
        self._world = self._plant.world_frame()
        self._local = threading.local()

    @property
    def plant(self) -> MultibodyPlant:
        """The copy."""
        return self._plant

    @property
    def touching(self) -> set[BodyIndex]:
        """Bodies that may yet touch others by built-in contact."""
        return self._touching

    def default_context(self) -> Context:
        """Return a context of the copy, at its default state."""
        return self._plant.CreateDefaultContext()

    def with_derivatives(self) -> tuple[Diagram, MultibodyPlant]:
        """Return a copy of AutoDiffXd, and the plant in it."""
        diagram = self._diagram.ToAutoDiffXd()
        return diagram, diagram.GetSystems()[0]

    def at(self, q: Floats, v: Floats, inputs: Mapping[str, object]) -> TwinAtState:
        """Return the twin at a state, with values at the plant's input ports of these names."""
        if not hasattr(self._local, "scratch"):
            self._local.scratch = _Scratch(
                self._plant.GetMyMutableContextFromRoot(self._diagram.CreateDefaultContext()),
                self._plant.GetMyMutableContextFromRoot(self._diagram.CreateDefaultContext()),
            )
        return TwinAtState(self, self._local.scratch, q, v, inputs)


class _Scratch:
    """Contexts that one thread works in, and the values last fixed at input ports."""

    def __init__(self, context: Context, result: Context) -> None:
        self.context = context
        self.result: State = result.get_mutable_state()
        self.result_context = result  # owns the state
        self.fixed: dict[str, object] = {}


class TwinAtState:
    """A twin at a state and inputs; good until the thread asks for another."""

    def __init__(
        self,
        twin: PlantTwin,
        scratch: _Scratch,
        q: Floats,
        v: Floats,
        inputs: Mapping[str, object],
    ) -> None:
        self._twin, self._scratch, self._q, self._v = twin, scratch, q, v
        self._plant, self._context = twin.plant, scratch.context
        for name, value in inputs.items():
            self._fix(name, value)
        self._go_to(q, v)

    def reached(self, forces: Floats) -> Floats:
        """Return the velocities (nv,) at the end of a step under generalized forces (nv,)."""
        self._fix(_OURS, forces)
        if self._twin._sampled:  # noqa: SLF001
            self._plant.CalcForcedUnrestrictedUpdate(self._context, self._scratch.result)
            values = self._scratch.result.get_discrete_state().get_vector(0)
        else:
            values = self._plant.EvalUniquePeriodicDiscreteUpdate(self._context).get_vector(0)
        return values.get_value()[len(self._q) :].copy()

    def mass_matrix(self) -> Floats:
        """Return (nv, nv)."""
        return self._plant.CalcMassMatrix(self._context)

    def kinematics_after(
        self, v: Floats, duration: float, bodies: Mapping[int, BodyIndex], X_WB: Floats, J: Floats
    ) -> None:
        """Fill poses (nb, 4, 4) and Jacobians (nb, 6, nv) of bodies, by row, after a motion at v.

        The Jacobians are those of spatial velocities in W by v.
        """
        q_dot = self._plant.MapVelocityToQDot(self._context, v)
        self._plant.SetPositions(self._context, self._q + duration * q_dot)
        for row, index in bodies.items():
            body = self._plant.get_body(index)
            X_WB[row] = self._plant.EvalBodyPoseInWorld(self._context, body).GetAsMatrix4()
            J[row] = self._plant.CalcJacobianSpatialVelocity(
                self._context,
                JacobianWrtVariable.kV,
                body.body_frame(),
                np.zeros(3),
                self._twin._world,  # noqa: SLF001
                self._twin._world,  # noqa: SLF001
            )
        self._go_to(self._q, self._v)

    def _go_to(self, q: Floats, v: Floats) -> None:
        self._plant.SetPositionsAndVelocities(self._context, np.concatenate([q, v]))

    def _fix(self, name: str, value: object) -> None:
        last = self._scratch.fixed.get(name)
        if isinstance(value, np.ndarray):
            if isinstance(last, np.ndarray) and np.array_equal(last, value):
                return
            value = value.copy()
        self._plant.GetInputPort(name).FixValue(self._context, value)
        self._scratch.fixed[name] = value


def _copy_controllers(source: MultibodyPlant, copy: MultibodyPlant) -> None:
    """Give the copy the gains of PD-controlled actuators, which Drake's `Clone` leaves out."""
    for i in range(source.num_actuators()):
        actuator = source.get_joint_actuator(JointActuatorIndex(i))
        mine = copy.get_mutable_joint_actuator(JointActuatorIndex(i))
        if actuator.has_controller() and not mine.has_controller():
            mine.set_controller_gains(actuator.get_controller_gains())
