"""Parts that wedge: Morse taper, wedge in a groove, press fit, through the whole Drake diagram.

One part is fixed, the other slides on a prismatic joint along the axis, driven by a force that
changes slowly. Row numbers are those of the table of closed forms in the README.
"""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from pydrake.geometry import Mesh
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import PrismaticJoint, SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder, EventStatus
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial
from validation_scenes import ON_BOTH_PLANTS_BUT_SLOW, check, judge, on

from scenarios import parts
from systems import AddNonlinearDamperContact, ContactConfig, FrictionConfig

MASS = 2.0  # [kg]
MORSE = math.radians(1.45)


@dataclass(frozen=True)
class Pushed:
    """Time, force along the axis and position of the sliding part after every step."""

    time: np.ndarray
    force: np.ndarray
    position: np.ndarray

    def at(self, time: float) -> float:
        return float(np.interp(time, self.time, self.position))

    def force_when_gone(self, start: float, distance: float) -> float:
        """Force at which the part has left the place it held at `start` by a distance [m]."""
        late = self.time >= start
        gone = np.abs(self.position[late] - self.at(start)) > distance
        assert gone.any(), "it never let go"
        return float(abs(self.force[late][np.argmax(gone)]))


def push(folder, time_step, moving, fixed, axis, schedule, *, k, friction) -> Pushed:
    """Drive the moving part by a schedule of (time [s], force [N]) corners."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step)
    slider = plant.AddRigidBody("slider", SpatialInertia(MASS, [0, 0, 0], UnitInertia(1, 1, 1)))
    for body, surface in ((slider, moving), (plant.world_body(), fixed)):
        path = parts.write_obj(folder / f"{body.name()}.obj", surface)
        plant.RegisterCollisionGeometry(
            body, RigidTransform(), Mesh(path), "mesh", CoulombFriction(0, 0)
        )
    joint = plant.AddJoint(
        PrismaticJoint("axis", plant.world_frame(), slider.body_frame(), axis, damping=100.0)
    )
    plant.AddJointActuator("drive", joint)
    plant.mutable_gravity_field().set_gravity_vector([0, 0, 0])
    plant.Finalize()
    times, forces = np.transpose(schedule)
    drive = PiecewisePolynomial.FirstOrderHold(times, forces[None, :])
    source = builder.AddSystem(TrajectorySource(drive))
    builder.Connect(source.get_output_port(), plant.get_actuation_input_port())
    config = ContactConfig(
        k=k,
        alpha=5.0,
        resolution=0.05,
        friction=FrictionConfig(static=friction, stiffness_ratio=1.0),
    )
    AddNonlinearDamperContact(builder, plant, scene_graph, config=config)
    simulator = Simulator(builder.Build())
    simulator.get_mutable_integrator().set_target_accuracy(1e-5)
    context = plant.GetMyContextFromRoot(simulator.get_mutable_context())
    rows = []

    def watch(root: Context) -> EventStatus:
        time = root.get_time()
        rows.append((time, drive.value(time)[0, 0], joint.get_translation(context)))
        return EventStatus.DidNothing()

    simulator.set_monitor(watch)
    simulator.AdvanceTo(times[-1])
    return Pushed(*np.transpose(rows))


PRESS = 400.0  # [N]
# Corners of (time, force): press, hold, unload, wait, pull.
PRESS_AND_PULL = [(0, 0), (0.1, -PRESS), (0.15, -PRESS), (0.25, 0), (0.45, 0), (0.95, PRESS)]

FITS = {
    "Morse taper": (
        lambda: parts.taper_plug(sections=32, rings=8),
        lambda: parts.taper_socket(sections=32, rings=6),
        [0, 0, 1],
        MORSE,
        2e11,
        0.15,
    ),
    "wedge in a groove": (
        lambda: parts.wedge(half_angle=math.radians(4)),
        lambda: parts.v_groove(half_angle=math.radians(4), width=0.06),
        [0, 1, 0],
        math.radians(4),
        2e11,
        0.2,
    ),
}
EACH_FIT = pytest.mark.parametrize(
    "name", [pytest.param("Morse taper", marks=pytest.mark.slow), "wedge in a groove"]
)


@ON_BOTH_PLANTS_BUT_SLOW
@EACH_FIT
def test_pressed_in_it_holds_and_pulls_out(name, tmp_path, record_property, time_step):
    """Row 17: a taper that falls out, creeps, or lets go at the wrong force."""
    plug, socket, axis, beta, k, mu = FITS[name]
    run = push(tmp_path, time_step, plug(), socket(), axis, PRESS_AND_PULL, k=k, friction=mu)
    phi = math.atan(mu)
    expected = math.tan(phi - beta) / math.tan(phi + beta)
    # Unloaded, it stays where it is but for the nanometres of its dying vibration.
    assert abs(run.at(0.45) - run.at(0.3)) < 1e-3 * abs(run.at(0.15)), "does not hold"
    got = run.force_when_gone(0.45, 1e-4) / PRESS
    check(record_property, (17, f"{name}: force out/in" + on(time_step)), expected, got, 0.05)


@ON_BOTH_PLANTS_BUT_SLOW
@EACH_FIT
def test_pops_out_where_friction_is_too_small(name, tmp_path, record_property, time_step):
    """Row 17: a wedge that holds although its angle is above the friction angle."""
    plug, socket, axis, beta, k, _ = FITS[name]
    slippery = 0.6 * math.tan(beta)
    run = push(
        tmp_path, time_step, plug(), socket(), axis, PRESS_AND_PULL[:5], k=k, friction=slippery
    )
    told = "pops out" if run.at(0.45) > -1e-6 else "stays in"
    row = (17, f"{name}: above the friction angle" + on(time_step))
    judge(record_property, row, "pops out", told)
