"""SweptContactMonitor: a pass-through between two steps is told, an honest contact is not."""

from __future__ import annotations

import numpy as np
import pytest
from pydrake.geometry import Box, Sphere
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import DiagramBuilder

from systems import AddNonlinearDamperContact, ContactConfig, SweptContactMonitor

STEP = 1e-3


class Shot:
    """VALIDATION row 25: a plate 1 mm thick, a bullet at up to 100 m/s, steps of 1 ms."""

    def __init__(
        self,
        velocity: float,
        when_passed: str = "raise",
        offset: float = 0.0,
        time_step: float = 0.0,
    ) -> None:
        builder = DiagramBuilder()
        self.plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step)
        plate = self.plant.AddRigidBody("plate", SpatialInertia.SolidBoxWithMass(1, 0.001, 1, 1))
        bullet = self.plant.AddRigidBody("bullet", SpatialInertia.SolidSphereWithMass(0.01, 0.005))
        for body, shape in ((plate, Box(0.001, 1, 1)), (bullet, Sphere(0.005))):
            self.plant.RegisterCollisionGeometry(
                body, RigidTransform(), shape, "shape", CoulombFriction(0, 0)
            )
        self.plant.mutable_gravity_field().set_gravity_vector([0, 0, 0])
        self.plant.Finalize()
        config = ContactConfig(web="facet", standoff=5e-4, k=1e5, alpha=0.0)
        contact = AddNonlinearDamperContact(builder, self.plant, scene_graph, config=config)
        self.monitor = SweptContactMonitor.AddToBuilder(builder, contact, when_passed=when_passed)
        self.simulator = Simulator(builder.Build())
        if time_step == 0:
            ResetIntegratorFromFlags(self.simulator, "explicit_euler", STEP)
        context = self.simulator.get_mutable_context()
        self.bullet_context = self.plant.GetMyContextFromRoot(context)
        self.monitor_context = self.monitor.GetMyContextFromRoot(context)
        # Both are seen from a frame of odd orientation, so that no axis is special.
        odd = RollPitchYaw(0.3, -0.4, 0.5).ToRotationMatrix()
        self.plant.SetFreeBodyPose(self.bullet_context, plate, RigidTransform(odd, np.zeros(3)))
        start = odd @ np.array([-0.233, offset, 0.0])
        self.plant.SetFreeBodyPose(self.bullet_context, bullet, RigidTransform(start))
        flight = np.zeros(12)
        flight[bullet.floating_velocities_start_in_v() + 3 :][:3] = odd @ np.array([velocity, 0, 0])
        self.plant.SetVelocities(self.bullet_context, flight)

    def passes(self) -> float:
        return float(self.monitor.get_passes_output_port().Eval(self.monitor_context)[0])


def test_bullet_through_plate_stops_the_simulation_naming_both():
    shot = Shot(100.0)
    message = r"plate/shape and bullet/shape passed .* between t = 0\.002 s and 0\.003 s"
    with pytest.raises(RuntimeError, match=message):
        shot.simulator.AdvanceTo(0.01)


def test_discrete_plant_is_watched_too():
    with pytest.raises(RuntimeError, match="passed through each other"):
        Shot(100.0, time_step=STEP).simulator.AdvanceTo(0.01)


def test_warning_lets_the_simulation_go_on_and_counting_is_silent():
    shot = Shot(100.0, "warn")
    with pytest.warns(RuntimeWarning, match="passed through each other") as told:
        shot.simulator.AdvanceTo(0.01)
    assert len(told) == 1
    assert shot.passes() == 1
    shot = Shot(100.0, "count")
    shot.simulator.AdvanceTo(0.01)
    assert shot.passes() == 1


def test_passing_beside_the_plate_is_no_contact():
    shot = Shot(100.0, offset=0.51)
    shot.simulator.AdvanceTo(0.01)
    assert shot.passes() == 0


def test_bullet_that_contact_stops_is_not_told():
    shot = Shot(0.2)
    ResetIntegratorFromFlags(shot.simulator, "runge_kutta3", STEP)
    shot.simulator.AdvanceTo(2.0)
    velocity = shot.plant.GetVelocities(shot.bullet_context)[-3:]
    assert np.linalg.norm(velocity) == pytest.approx(0.2 * 0.99 / 1.01, rel=0.02), "it bounced"
    assert shot.passes() == 0


def test_setting_the_state_anew_is_no_motion():
    shot = Shot(0.0)
    shot.simulator.AdvanceTo(0.01)
    mirrored = -shot.plant.GetPositions(shot.bullet_context)[-3:]
    positions = shot.plant.GetPositions(shot.bullet_context).copy()
    positions[-3:] = mirrored
    shot.simulator.AdvancePendingEvents()
    shot.plant.SetPositions(shot.bullet_context, positions)
    shot.simulator.Initialize()
    shot.simulator.AdvanceTo(0.02)
    assert shot.passes() == 0


def test_unknown_reaction_is_refused():
    with pytest.raises(ValueError, match="when_passed must be"):
        Shot(0.0, "shrug")
