"""Memory of diagrams built, run and dropped in one process."""

from __future__ import annotations

import gc
import weakref
from pathlib import Path

import pytest
from pydrake.geometry import Box
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from contact_toolkit import (
    AreaWeb,
    CollisionMesh,
    ContactGeometry,
    ContactModel,
    ContactPair,
    NonlinearDamper,
)
from contact_toolkit.shapes.shared_mesh import shared_mesh
from scenarios.parts import box, mug
from systems import AddNonlinearDamperContact

_PAGE = 4096


def resident() -> float:
    """[MB]."""
    gc.collect()
    return int(Path("/proc/self/statm").read_text().split()[1]) * _PAGE / 1e6


def build_run_and_drop() -> None:
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=2e-3)
    friction = CoulombFriction(0.5, 0.5)
    plant.RegisterCollisionGeometry(
        plant.world_body(), RigidTransform([0, 0, -0.5]), Box(2, 2, 1), "table", friction
    )
    inertia = SpatialInertia.SolidBoxWithMass(1.0, 0.1, 0.1, 0.1)
    for i in range(10):
        box = plant.AddRigidBody(f"box{i}", inertia)
        cube = Box(0.1, 0.1, 0.1)
        plant.RegisterCollisionGeometry(box, RigidTransform(), cube, f"box{i}", friction)
        X_WB = RigidTransform([0.15 * i - 0.7, 0, 0.05])
        plant.SetDefaultFloatingBaseBodyPose(box, X_WB)
    plant.Finalize()
    AddNonlinearDamperContact(builder, plant, scene_graph)
    Simulator(builder.Build()).AdvanceTo(0.01)


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="reads Linux's /proc")
def test_the_same_scene_built_again_and_again_takes_little_more():
    """A sweep of ten boxes grew by 61 MB a run, as Drake's binding never frees a system."""
    build_run_and_drop()
    build_run_and_drop()
    before = resident()
    for _ in range(3):
        build_run_and_drop()
    assert (resident() - before) / 3 < 6.0


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="reads Linux's /proc")
def test_partners_of_ever_new_sizes_leave_nothing_behind():
    """A table kept bounds and regions for the spacing of each mug it had ever touched: 0.9 MB."""
    table = CollisionMesh(*box(0.4, 0.4, 0.02))
    vertices, faces = mug(sections=24)

    def touch(scale: float) -> None:
        geometries = [
            ContactGeometry("table", "table", table),
            ContactGeometry("mug", "mug", CollisionMesh(scale * vertices, faces)),
        ]
        web = AreaWeb(field="exact", resolution=0.1)
        ContactModel(["table", "mug"], geometries, [ContactPair(0, 1, NonlinearDamper(1e9), web)])

    for i in range(10):
        touch(1 + 1e-3 * i)
    before = resident()
    for i in range(10, 60):
        touch(1 + 1e-3 * i)
    assert (resident() - before) / 50 < 0.05


def test_equal_surfaces_are_one_mesh_only_while_somebody_has_it():
    """Two hundred bricks of one shape would take two hundred fields; or stay for ever."""
    vertices, faces = [[0, 0, 0], [1, 0, 0], [0, 1, 0.0]], [[0, 1, 2]]
    mesh = shared_mesh(CollisionMesh(vertices, faces))
    assert shared_mesh(CollisionMesh(vertices, faces)) is mesh
    other = CollisionMesh([[0, 0, 0], [2, 0, 0], [0, 1, 0.0]], faces)
    assert shared_mesh(other) is other
    alive = weakref.ref(mesh)
    del mesh
    gc.collect()
    assert alive() is None
