"""A plant's positions, and its joints' motions, against a C-space known in closed form."""

import numpy as np
import pytest
from pydrake.geometry import Box
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import PrismaticJoint, RevoluteJoint, SpatialInertia
from pydrake.systems.framework import DiagramBuilder

from contact_toolkit import CSpaceClass
from systems import PlantCSpace

FREE, NEAR, COLLIDING = CSpaceClass


def _gantry(*, finger=0.2):
    """A finger that slides along x and turns about z, over a wall."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
    inertia = SpatialInertia.SolidSphereWithMass(1, 0.1)
    friction = CoulombFriction(1, 1)
    carriage = plant.AddRigidBody("carriage", inertia)
    arm = plant.AddRigidBody("arm", inertia)
    world = plant.world_body()
    plant.AddJoint(
        PrismaticJoint("x", world.body_frame(), carriage.body_frame(), np.array([1.0, 0, 0]))
    )
    plant.AddJoint(
        RevoluteJoint("turn", carriage.body_frame(), arm.body_frame(), np.array([0, 0, 1.0]))
    )
    plant.RegisterCollisionGeometry(
        arm, RigidTransform([1, 0, 0]), Box(2, finger, 0.1), "finger", friction
    )
    plant.RegisterCollisionGeometry(
        world, RigidTransform([0, 2.9, 0]), Box(10, 2, 1), "wall", friction
    )
    plant.Finalize()
    diagram = builder.Build()
    return diagram, plant, scene_graph


def test_plant_positions():
    """A plant's positions classified in the wrong pose, order or frame."""
    diagram, plant, scene_graph = _gantry()
    cspace = PlantCSpace(plant, scene_graph)
    assert cspace.model.bodies == ("world", "arm")
    turn = np.array([0, 0.5, np.pi / 2, -np.pi / 2])
    q = np.stack([[0, 1, 2, 3], turn], axis=1)
    found = cspace.classify(q, standoff=1.0)
    reach = 2 * np.abs(np.sin(turn)) * (turn > 0) + 0.1 * np.abs(np.cos(turn))
    truth = 1.9 - np.where(turn < 0, 0, reach)
    np.testing.assert_allclose(found.distance, np.maximum(truth, 0), atol=1e-9)
    assert found.kind.tolist() == [FREE, NEAR, COLLIDING, FREE]
    assert found.p_FCa[1][1] == pytest.approx(1.9)
    with pytest.raises(ValueError, match="q must have shape"):
        cspace.classify(np.zeros((1, 3)))
    del diagram


def test_plant_motions():
    """A joint motion that swings through the wall between two free positions."""
    diagram, plant, scene_graph = _gantry()
    cspace = PlantCSpace(plant, scene_graph, [["arm", "world"]])
    q = np.array([[0, 0.3], [0, 2.8], [3, 2.8]])
    ends = cspace.classify(q)
    assert (ends.kind == FREE).all()
    for steps in (1, 4):
        found = cspace.classify_motions(q, steps=steps)
        assert found.kind.tolist() == [COLLIDING, FREE]
        assert found.distance[1] == pytest.approx(ends.distance[1], abs=1e-5)
    with pytest.raises(ValueError, match="steps"):
        cspace.classify_motions(q, steps=0)
    del diagram
