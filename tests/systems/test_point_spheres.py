"""Spheres that stand for points, as Drake's own contact wants them at the corners of boxes."""

from __future__ import annotations

import itertools
import math

import pytest
from pydrake.geometry import AddContactMaterial, Box, ProximityProperties, Sphere
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from systems import AddNonlinearDamperContact, ContactConfig

MASS, GRAVITY, EDGE = 0.5, 9.81, 0.1
FRICTION = CoulombFriction(0.5, 0.5)


def stand(
    properties: ProximityProperties,
    radius: float,
    *,
    slope: float = 0.0,
    config: ContactConfig | None = None,
):
    """A box on spheres at its four lower corners, after 0.4 s: height lost, contacts and way."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=1e-3)
    X_WG = RigidTransform(RollPitchYaw(0, slope, 0), [0, 0, 0])
    table = X_WG @ RigidTransform([0, 0, -0.05])
    plant.RegisterCollisionGeometry(plant.world_body(), table, Box(1, 1, 0.1), "table", FRICTION)
    body = plant.AddRigidBody("body", SpatialInertia.SolidBoxWithMass(MASS, EDGE, EDGE, EDGE))
    for i, (x, y) in enumerate(itertools.product((-EDGE / 2, EDGE / 2), repeat=2)):
        X_BG = RigidTransform([x, y, -EDGE / 2])
        plant.RegisterCollisionGeometry(body, X_BG, Sphere(radius), f"point{i}", properties)
    start = X_WG @ RigidTransform([0, 0, EDGE / 2 + radius])
    plant.SetDefaultFloatingBaseBodyPose(body, start)
    plant.Finalize()
    contact = AddNonlinearDamperContact(builder, plant, scene_graph, config=config)
    simulator = Simulator(builder.Build())
    context = simulator.get_mutable_context()
    simulator.AdvanceTo(0.4)
    X_WB = plant.EvalBodyPoseInWorld(plant.GetMyContextFromRoot(context), body)
    moved = X_WG.rotation().inverse() @ (X_WB.translation() - start.translation())
    port = contact.get_contacts_output_port()
    return -moved[2], len(port.Eval(contact.GetMyContextFromRoot(context))), moved[0]


def properties(point_stiffness: float | None = None) -> ProximityProperties:
    made = ProximityProperties()
    AddContactMaterial(friction=FRICTION, point_stiffness=point_stiffness, properties=made)
    return made


@pytest.mark.parametrize("radius", [0.0, 1e-7, 1e-5, 1e-3])
def test_a_box_on_points_stands_by_four_springs(radius):
    """It fell through the table (1e-7), or took 7350 springs and 0.09 × real time (1e-3).

    Closed form: each point bears on K π h², the skin h being 1 % of the body.
    """
    sunk, springs, _ = stand(properties(), radius, config=ContactConfig(k=1e9))
    reach = EDGE + 2 * max(radius, 1e-9)
    diagonal = math.hypot(reach, reach, 2 * radius)
    area = math.pi * (0.01 * diagonal) ** 2
    assert springs == 4
    assert sunk == pytest.approx(MASS * GRAVITY / (4 * 1e9 * area), rel=0.01)


def test_its_point_stiffness_is_what_a_point_was_tagged_with():
    """Stiffness worked out from a surface of nanometres."""
    sunk, springs, _ = stand(properties(2e4), 1e-7)
    assert springs == 4
    # In series with the table's skin, of Drake's modulus over 1 % of the body, on the same area.
    skin = 0.01 * math.hypot(EDGE, EDGE)
    table = 1e7 / skin * math.pi * skin**2
    assert sunk == pytest.approx(MASS * GRAVITY / 4 * (1 / 2e4 + 1 / table), rel=0.01)


@pytest.mark.parametrize("slope", [0.98, 1.1])
def test_points_hold_up_to_the_friction_angle(slope):
    """Points without an anchor creep."""
    angle = slope * math.atan(0.5)
    _, _, way = stand(properties(), 1e-7, slope=angle)
    slides = GRAVITY * (math.sin(angle) - 0.5 * math.cos(angle))
    assert way == pytest.approx(max(slides, 0) * 0.4**2 / 2, rel=0.1, abs=1e-3)
