"""Scenes of the validation rows: shapes on the area web, through a whole Drake diagram.

Axes: an incline falls towards +x. Bodies are homogeneous; spheres are Drake's own shape, cut into
facets so small that what they lack of the ball is well inside the tolerances.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray
from pydrake.geometry import Box, HalfSpace, Shape, Sphere
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import AddMultibodyPlant, CoulombFriction, MultibodyPlantConfig
from pydrake.multibody.tree import PrismaticJoint, PrismaticSpring, RigidBody, SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder, EventStatus, LeafSystem

from systems import AddNonlinearDamperContact, ContactConfig, FrictionConfig

GRAVITY = 9.81
HEAVY = 1e9  # [kg]
Floats = NDArray[np.float64]


# Steps of a plant [s]; 0: a continuous one, which is slow where its contact is stiff.
ON_BOTH_PLANTS = pytest.mark.parametrize("time_step", [0.0, 1e-3])
ON_BOTH_PLANTS_BUT_SLOW = pytest.mark.parametrize(
    "time_step", [pytest.param(0.0, marks=pytest.mark.slow), 1e-3]
)


def on(time_step: float) -> str:
    """Return what a row of the table adds to the name of an experiment on such a plant."""
    return f", discrete, {1e3 * time_step:g} ms" if time_step else ""


def check(record_property, row: tuple[int, str], expected, got, tolerance, *, relative=True):
    """Record a figure for the table, then hold it to the tolerance of its row."""
    error = float(abs(got / expected - 1) if relative else abs(got - expected))
    record_property("validation", (*row, expected, float(got), error, tolerance))
    assert error <= tolerance, f"{row[1]}: {got}, not {expected}"


def judge(record_property, row: tuple[int, str], expected: str, got: str):
    """Record a verdict for the table, then hold it to the expected one."""
    record_property("validation", (*row, expected, got, "", "verdict"))
    assert got == expected


def check_first_order(
    record_property, row: tuple[int, str], expected: float, step: float, measure, tolerance: float
):
    """Hold what discrete plants tend to, as steps shrink, to the tolerance of its row.

    `measure` tells a figure at a step [s]. What it changes by must halve with the step, as it does
    by backward Euler; what it is without steps is then known from the last two.
    """
    coarse, middle, fine = (measure(step / part) for part in (1, 2, 4))
    number, name = row
    steps = f"discrete, from {1e3 * step:g} ms down"
    order = (number, f"{name}, {steps}: order of convergence")
    got = math.log2((coarse - middle) / (middle - fine))
    check(record_property, order, 1.0, got, 0.2)
    limit = (number, f"{name}, {steps}: limit")
    check(record_property, limit, expected, 2 * fine - middle, tolerance)


@dataclass(frozen=True)
class Log:
    """What was seen after every step: time (n,), positions (n, nq), velocities (n, nv)."""

    time: Floats
    q: Floats
    v: Floats

    def after(self, time: float) -> Log:
        late = self.time >= time
        return Log(self.time[late], self.q[late], self.v[late])


def slope(time: Floats, values: Floats) -> float:
    """Fit a straight line; return its slope."""
    return float(np.polyfit(time, values, 1)[0])


class Push(LeafSystem):
    """A generalized force that depends on time alone."""

    def __init__(self, num_velocities: int, force: Callable[[float], Floats]) -> None:
        super().__init__()
        self.DeclareVectorOutputPort(
            "force",
            num_velocities,
            lambda context, output: output.SetFromVector(force(context.get_time())),
            {self.time_ticket()},
        )


class Scene:
    """A plant to fill with bodies, then to `build` and run."""

    def __init__(self, *, time_step: float = 0.0, gravity: float = GRAVITY) -> None:
        self.builder = DiagramBuilder()
        config = MultibodyPlantConfig(time_step=time_step)
        self.plant, self.scene_graph = AddMultibodyPlant(config, self.builder)
        self.plant.mutable_gravity_field().set_gravity_vector([0, 0, -gravity])

    def floor(self, incline: float = 0.0, friction: float = 0.0) -> RotationMatrix:
        """Add a half space through the origin; return its attitude."""
        R_WF = RotationMatrix.MakeYRotation(incline)
        self.shape(self.plant.world_body(), HalfSpace(), RigidTransform(R_WF, [0, 0, 0]), friction)
        return R_WF

    def box(self, name: str, mass: float, size: tuple[float, float, float], friction=0.0):
        body = self.plant.AddRigidBody(name, SpatialInertia.SolidBoxWithMass(mass, *size))
        self.shape(body, Box(*size), friction=friction)
        return body

    def ball(self, name: str, mass: float, radius: float) -> RigidBody:
        body = self.plant.AddRigidBody(name, SpatialInertia.SolidSphereWithMass(mass, radius))
        self.shape(body, Sphere(radius))
        return body

    def slider(self, name: str, mass: float, size, parent: RigidBody, axis) -> RigidBody:
        """Add a box without shape that moves along an axis of its parent only."""
        body = self.plant.AddRigidBody(name, SpatialInertia.SolidBoxWithMass(mass, *size))
        joint = PrismaticJoint(name, parent.body_frame(), body.body_frame(), axis)
        self.plant.AddJoint(joint)
        return body

    def swing(self, name: str, frequency: float) -> RigidBody:
        """Add a body that swings along x [rad/s], so heavy that nothing slows it."""
        body = self.slider(name, HEAVY, (1, 1, 1), self.plant.world_body(), [1, 0, 0])
        joint = self.plant.GetJointByName(name)
        self.plant.AddForceElement(PrismaticSpring(joint, 0.0, HEAVY * frequency**2))
        return body

    def shape(self, body: RigidBody, shape: Shape, X_BG=None, friction: float = 0.0) -> None:
        self.plant.RegisterCollisionGeometry(
            body, X_BG or RigidTransform(), shape, "shape", CoulombFriction(friction, friction)
        )

    def build(
        self,
        contact: ContactConfig | None,
        push: Callable[[float], Floats] | None = None,
        *,
        step: float | None = 1e-3,
    ) -> Run:
        """Connect contact (None: Drake's own) and a force; return the run at time 0.

        A continuous plant takes steps of this length [s], so that no figure hangs on what an error
        control takes for small; None: as Drake's error control has it. A discrete one has its own.
        """
        self.plant.Finalize()
        if push is not None:
            source = self.builder.AddSystem(Push(self.plant.num_velocities(), push))
            self.builder.Connect(
                source.get_output_port(), self.plant.get_applied_generalized_force_input_port()
            )
        system = contact and AddNonlinearDamperContact(
            self.builder, self.plant, self.scene_graph, config=contact
        )
        return Run(self, system, step)


class Run:
    """A built scene in motion; `p`, `v` and `w` are those of a free body's origin, in W."""

    def __init__(self, scene: Scene, contact, step: float | None) -> None:
        self.plant, self.contact = scene.plant, contact
        self.simulator = Simulator(scene.builder.Build())
        self.context = self.simulator.get_mutable_context()
        self.plant_context = self.plant.GetMyMutableContextFromRoot(self.context)
        if step is None or self.plant.time_step():
            return
        integrator = self.simulator.get_mutable_integrator()
        integrator.set_maximum_step_size(step)
        integrator.request_initial_step_size_target(step)
        integrator.set_fixed_step_mode(True)

    def place(self, body: RigidBody, R_WB=None, p=(0, 0, 0), *, v=(0, 0, 0), w=(0, 0, 0)) -> None:
        X_WB = RigidTransform(R_WB or RotationMatrix(), p)
        self.plant.SetFreeBodyPose(self.plant_context, body, X_WB)
        start = body.floating_velocities_start_in_v()
        V = self.plant.GetVelocities(self.plant_context)
        V[start : start + 6] = [*w, *v]
        self.plant.SetVelocities(self.plant_context, V)

    def advance_to(self, time: float) -> Log:
        """Simulate on; return what was seen on the way."""
        rows = []

        def watch(root: Context) -> EventStatus:
            state = self.plant.GetPositionsAndVelocities(self.plant_context)
            rows.append([root.get_time(), *state])
            return EventStatus.DidNothing()

        self.simulator.set_monitor(watch)
        self.simulator.AdvanceTo(time)
        self.simulator.clear_monitor()
        times, q, v = np.split(np.array(rows), [1, 1 + self.plant.num_positions()], axis=1)
        return Log(times[:, 0], q, v)

    def point(self, body: RigidBody, p_BQ=(0, 0, 0)) -> Floats:
        """Where a point of the body is, in W."""
        return self.plant.EvalBodyPoseInWorld(self.plant_context, body) @ np.array(p_BQ)

    def tilt(self, body: RigidBody) -> float:
        """Angle between the vertical and the body's z axis [rad]."""
        R_WB = self.plant.EvalBodyPoseInWorld(self.plant_context, body).rotation()
        return math.acos(min(1.0, R_WB.matrix()[2, 2]))

    def energies(self) -> Floats:
        """Stored normally and tangentially, lost in damping and to friction [J]."""
        context = self.contact.GetMyContextFromRoot(self.context)
        return self.contact.get_energies_output_port().Eval(context)


def area_web(k: float, *, alpha=0.0, mu=0.0, damping=None, **settings) -> ContactConfig:
    """Contact on an elastic foundation of stiffness `k` [Pa/m^n]."""
    friction = FrictionConfig(static=mu, damping=damping)
    return ContactConfig(k=k, alpha=alpha, friction=friction, half_space_reach=10.0, **settings)
