"""A rigid body is one solid, however its geometry was cut into pieces."""

from __future__ import annotations

import logging
from collections.abc import Sequence

import numpy as np
import pytest
from pydrake.common import MemoryFile
from pydrake.geometry import Box, Convex, InMemoryMesh, Mesh, Shape, Sphere
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import (
    AddMultibodyPlantSceneGraph,
    CoulombFriction,
    MultibodyPlant,
)
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from contact_toolkit.shapes.primitives import box
from systems import AddNonlinearDamperContact, ContactConfig, NonlinearDamperContact

Part = tuple[Shape, Sequence[float]]

K, MASS, GRAVITY = 1e9, 1.0, 9.81  # [Pa/m], [kg], [m/s²]
EDGE, RADIUS = 0.1, 0.02  # [m] of the cube, of the ball
MU = 0.45

CUBE: list[Part] = [(Box(EDGE, EDGE, EDGE), (0, 0, 0))]
SLAB: list[Part] = [(Box(1, 1, 0.1), (0, 0, -0.05))]


def _file(*boxes: tuple[Sequence[float], Sequence[float]]) -> InMemoryMesh:
    """An .obj of these boxes (size, middle), a shell each."""
    text, count = "", 1
    for size, middle in boxes:
        vertices, faces = box(size)
        text += "".join("v {} {} {}\n".format(*(float(x) for x in p + middle)) for p in vertices)
        text += "".join("f {} {} {}\n".format(*(f + count)) for f in faces)
        count += len(vertices)
    return InMemoryMesh(mesh_file=MemoryFile(text, ".obj", "parts.obj"))


def _shells(overlap: float) -> list[Part]:
    half = (0.5 + overlap, 1, 0.1)
    middles = [(x * (0.25 - overlap / 2), 0, 0) for x in (-1, 1)]
    return [(Mesh(_file(*((half, np.array(p)) for p in middles))), (0, 0, -0.05))]


FLOORS: dict[str, list[Part]] = {
    "flush": [(Box(0.5, 1, 0.1), (x, 0, -0.05)) for x in (-0.25, 0.25)],
    "overlapping": [(Box(0.55, 1, 0.1), (x, 0, -0.05)) for x in (-0.225, 0.225)],
    "tiled": [
        (Box(0.25, 0.25, 0.1), (-0.375 + 0.25 * i, -0.375 + 0.25 * j, -0.05))
        for i in range(4)
        for j in range(4)
    ],
    "twice": 2 * SLAB,
    "convex pieces": [
        (Convex(_file(((0.6, 1, 0.1), np.zeros(3)))), (x, 0, -0.05)) for x in (-0.2, 0.2)
    ],
    "within": [*SLAB, (Box(0.3, 0.3, 0.05), (0, 0, -0.05))],
    "shells that abut": _shells(0.0),
    "shells that overlap": _shells(0.05),
}
BODIES: dict[str, list[Part]] = {
    "flush": [(Box(EDGE / 2, EDGE, EDGE), (x, 0, 0)) for x in (-EDGE / 4, EDGE / 4)],
    "overlapping": [(Box(0.7 * EDGE, EDGE, EDGE), (x, 0, 0)) for x in (-0.015, 0.015)],
}


def scene(
    ground: list[Part],
    body: list[Part],
    p: Sequence[float],
    *,
    v: Sequence[float] = (0, 0, 0),
    time: float = 0.3,
) -> tuple[RigidTransform, NonlinearDamperContact]:
    """Where a body is after a while that begins at `p` with velocity `v`."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=1e-3)
    inertia = SpatialInertia.SolidBoxWithMass(MASS, EDGE, EDGE, EDGE)
    moving = plant.AddRigidBody("body", inertia)
    _register(plant, "world", ground)
    _register(plant, "body", body)
    plant.SetDefaultFloatingBaseBodyPose(moving, RigidTransform(p))
    plant.Finalize()
    contact = AddNonlinearDamperContact(builder, plant, scene_graph, config=ContactConfig(k=K))
    simulator = Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    plant.SetVelocities(context, np.array([0, 0, 0, *v], float))
    simulator.AdvanceTo(time)
    return plant.EvalBodyPoseInWorld(context, moving), contact


def _register(plant: MultibodyPlant, name: str, parts: list[Part], mu: float = MU) -> None:
    body, friction = plant.GetBodyByName(name), CoulombFriction(mu, mu)
    for shape, p in parts:
        label = f"{name}{len(plant.GetCollisionGeometriesForBody(body))}"
        plant.RegisterCollisionGeometry(body, RigidTransform(p), shape, label, friction)


@pytest.mark.parametrize("floor", FLOORS)
def test_a_cube_across_a_seam_weighs_once(floor):
    """An overlap that bears the weight twice: half as deep (0.49 µm for 0.98)."""
    sag = MASS * GRAVITY / (K * EDGE**2)
    X_WB, _ = scene(FLOORS[floor], CUBE, (0.01, 0, EDGE / 2))
    assert EDGE / 2 - X_WB.translation()[2] == pytest.approx(sag, rel=1e-3)
    np.testing.assert_allclose(X_WB.translation()[:2], [0.01, 0], atol=1e-12)
    assert np.abs(RollPitchYaw(X_WB.rotation()).vector()).max() < 1e-12


@pytest.mark.parametrize("body", BODIES)
def test_a_cube_in_two_pieces_stands_as_one(body):
    sag = MASS * GRAVITY / (K * EDGE**2)
    X_WB, _ = scene(SLAB, BODIES[body], (0, 0, EDGE / 2))
    assert EDGE / 2 - X_WB.translation()[2] == pytest.approx(sag, rel=1e-3)


@pytest.mark.parametrize("offset", [0.0, 1e-3])
@pytest.mark.parametrize("floor", ["flush", "overlapping", "shells that overlap"])
def test_a_ball_presses_into_a_seam_as_into_a_slab(floor, offset):
    """Sides within the floor that bear load: the ball was pushed aside by 2 mm, and 3 % too high.

    Closed form: π K R δ² = m g.
    """
    ball: list[Part] = [(Sphere(RADIUS), (0, 0, 0))]
    depth = np.sqrt(MASS * GRAVITY / (np.pi * K * RADIUS))
    X_WB, _ = scene(FLOORS[floor], ball, (offset, 0, RADIUS), time=0.5)
    truth, _ = scene(SLAB, ball, (offset, 0, RADIUS), time=0.5)
    assert RADIUS - X_WB.translation()[2] == pytest.approx(depth, rel=5e-3)
    # Facets split the other way push it the other way, by 1.4 µm.
    np.testing.assert_allclose(X_WB.translation(), truth.translation(), atol=4e-6)


@pytest.mark.parametrize("floor", ["flush", "overlapping", "tiled"])
def test_a_cube_slides_over_seams_without_a_snag(floor):
    """Closed form: v² / (2 μ g), short of it by half of a step's way as on a slab."""
    start, speed = np.array([-0.15, 0, EDGE / 2 - MASS * GRAVITY / (K * EDGE**2)]), 1.5
    X_WB, _ = scene(FLOORS[floor], CUBE, start, v=(speed, 0, 0), time=0.5)
    way = X_WB.translation()[0] - start[0]
    assert way == pytest.approx(speed**2 / (2 * MU * GRAVITY) - speed * 1e-3 / 2, abs=2e-5)
    assert np.abs(RollPitchYaw(X_WB.rotation()).vector()).max() < 1e-7


def _model(parts: list[Part], *others: tuple[list[Part], float]) -> NonlinearDamperContact:
    """The contact of a cube with what the world is made of; others of other friction."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=1e-3)
    plant.AddRigidBody("body", SpatialInertia.SolidBoxWithMass(MASS, EDGE, EDGE, EDGE))
    _register(plant, "world", parts)
    for other, mu in others:
        _register(plant, "world", other, mu)
    _register(plant, "body", CUBE)
    plant.Finalize()
    return AddNonlinearDamperContact(builder, plant, scene_graph)


def _names(contact: NonlinearDamperContact) -> list[str]:
    return [g.name.split("/")[1] for g in contact.model.geometries if g.name.startswith("world")]


def test_what_was_united_goes_by_all_names():
    flush = _model(FLOORS["flush"])
    assert _names(flush) == ["world0 + world1"]
    assert len(flush.model.pairs) == 1
    floor = flush.model.geometries[0].mesh
    assert len(floor.faces) == 12
    assert floor.volume == pytest.approx(0.1, rel=1e-8)
    assert _names(_model(FLOORS["tiled"])) == ["world0 + world1 + world2 + 13 more"]


def test_what_differs_or_does_not_touch_stays_apart(caplog):
    """A mat on a floor with the floor's friction; a union of what no seam joins."""
    left, right = ([part] for part in FLOORS["overlapping"])
    assert _names(_model(left, (right, 2 * MU))) == ["world0", "world1"]
    aside: list[Part] = [(Box(0.1, 0.1, 0.1), (3, 0, 0))]
    assert _names(_model([*left, *aside])) == ["world0", "world1"]
    round_one: list[Part] = [(Sphere(0.1), (0, 0, 0))]
    contact = _model([*left, *round_one])
    assert _names(contact) == ["world0", "world1"]
    assert contact.model.geometries[1].mesh.primitive is not None
    hollow = _file(((0.2, 0.2, 0.2), np.zeros(3)))
    with caplog.at_level(logging.WARNING):
        assert _names(_model([(Mesh(hollow), (0, 0, 0))])) == ["world0"]
    assert not caplog.records
