"""PlantTwin: what a discrete plant would do in a step, asked without touching the plant."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    BodyIndex,
    JacobianWrtVariable,
    JointActuatorIndex,
    RigidBody,
    RigidBodyFrame,
)
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, FixedInputPortValue

from systems.plant.pairs import GeometryPair
from systems.step.free_motion import FORCES, FreeMotion
from systems.wiring.builtin_contact import take_over_pairs

Floats = NDArray[np.float64]
Link = tuple[int, RigidBody, RigidBodyFrame]
"""Row in the contact model, the body and its frame, looked up once."""
_ORIGIN = np.zeros(3)


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

    def at(self, x: Floats, inputs: Mapping[str, object]) -> TwinAtState:
        """Return the twin at a state (nq + nv), with values at the plant's inputs of these names.

        It is good until the thread asks for another.
        """
        if not hasattr(self._local, "twin"):
            self._local.twin = TwinAtState(self._diagram, self._plant)
        self._local.twin.go_to(x, inputs)
        return self._local.twin

    def apart(self, x: Floats, inputs: Mapping[str, object]) -> TwinAtState:
        """Return one of its own, whose inputs `at` does not see later."""
        twin = TwinAtState(self._diagram, self._plant)
        twin.go_to(x, inputs)
        return twin


class TwinAtState:
    """A twin at a state and inputs: the contexts that one thread works in.

    Parameters
    ----------
    diagram, plant
        Of the twin.
    """

    def __init__(self, diagram: Diagram, plant: MultibodyPlant) -> None:
        self._plant, self._world = plant, plant.world_frame()
        self._context = plant.GetMyMutableContextFromRoot(diagram.CreateDefaultContext())
        self._ahead = plant.CreateDefaultContext()  # where kinematics are looked at
        self._result = plant.CreateDefaultContext()  # that an update leads to
        self._after = self._result.get_mutable_state()
        self._sampled = plant.has_sampled_output_ports()
        self._fixed: dict[str, FixedInputPortValue] = {}
        self._nq = plant.num_positions()

    def go_to(self, x: Floats, inputs: Mapping[str, object]) -> None:
        """Put it at a state (nq + nv), with values at the inputs of these names."""
        self._x = x
        self._plant.SetPositionsAndVelocities(self._context, x)
        for name, value in inputs.items():
            self._fix(name, value)

    def reached(self, forces: Floats) -> Floats:
        """Return the velocities (nv,) at the end of a step under generalized forces (nv,)."""
        self._fix(FORCES, forces)
        if self._sampled:
            self._plant.CalcForcedUnrestrictedUpdate(self._context, self._after)
            x = self._after.get_discrete_state().get_vector(0)
        else:
            x = self._plant.EvalUniquePeriodicDiscreteUpdate(self._context).get_vector(0)
        return x.get_value()[self._nq :].copy()

    def mass_matrix(self) -> Floats:
        """Return (nv, nv)."""
        return self._plant.CalcMassMatrix(self._context)

    def free_motion(self, free: FreeMotion, inputs: Mapping[str, object], A: Floats) -> Floats:
        """Return the velocities (nv,) at the end of a step, in closed form."""
        return free.at(self._context, self._x, inputs, A if len(A) else self.mass_matrix())

    def kinematics_after(
        self, duration: float, v: Floats, links: Sequence[Link], X_WB: Floats, J: Floats
    ) -> None:
        """Fill poses (nb, 4, 4) and Jacobians (nb, 6, nv) of links, by row, after a motion.

        At velocities v (nv,). The Jacobians are those of spatial velocities in W by v.
        """
        plant, ahead, world = self._plant, self._ahead, self._world
        q = self._x[: self._nq]
        plant.SetPositions(ahead, q + duration * plant.MapVelocityToQDot(self._context, v))
        for row, body, frame in links:
            X_WB[row] = body.EvalPoseInWorld(ahead).GetAsMatrix4()
            J[row] = plant.CalcJacobianSpatialVelocity(
                ahead, JacobianWrtVariable.kV, frame, _ORIGIN, world, world
            )

    def _fix(self, name: str, value: object) -> None:
        if isinstance(value, np.ndarray) and name in self._fixed:
            self._fixed[name].GetMutableData().get_mutable_value().SetFromVector(value)
        else:
            self._fixed[name] = self._plant.GetInputPort(name).FixValue(self._context, value)


def _copy_controllers(source: MultibodyPlant, copy: MultibodyPlant) -> None:
    """Give the copy the gains of PD-controlled actuators, which Drake's `Clone` leaves out."""
    for i in range(source.num_actuators()):
        actuator = source.get_joint_actuator(JointActuatorIndex(i))
        mine = copy.get_mutable_joint_actuator(JointActuatorIndex(i))
        if actuator.has_controller() and not mine.has_controller():
            mine.set_controller_gains(actuator.get_controller_gains())
