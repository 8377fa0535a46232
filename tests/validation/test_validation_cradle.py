"""Impacts of several bodies at once, and the rod that rigid dynamics cannot decide, through Drake.

Row numbers are those of the table of closed forms in the README.
"""

import functools
import math

import numpy as np
import pytest
from pydrake.geometry import Mesh
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import PrismaticJoint, SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from validation_scenes import check_first_order

from systems import AddNonlinearDamperContact, ContactConfig, FrictionConfig

STANDOFF = 0.01

# A tip at the origin pointing along −x, and a flat face at x = 1: each ball touches the next by one
# contact, three facets on one, so that the chain is one of equal springs.
BALL = (
    "v 0 0 0\nv .5 .2 0\nv .5 -.1 .2\nv .5 -.1 -.2\nv 1 2 0\nv 1 -1 2\nv 1 -1 -2\n"
    "f 1 3 2\nf 1 4 3\nf 1 2 4\nf 2 3 4\nf 5 6 7\n"
)


def cradle(folder, n: float) -> np.ndarray:
    """Velocities after one ball at 1 m/s has hit two that touch."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    (folder / "ball.obj").write_text(BALL)
    inertia = SpatialInertia(1.0, [0, 0, 0], UnitInertia.SolidSphere(0.5))
    joints = []
    for i in range(3):
        body = plant.AddRigidBody(f"ball{i}", inertia)
        plant.RegisterCollisionGeometry(
            body, RigidTransform(), Mesh(folder / "ball.obj"), "mesh", CoulombFriction(0, 0)
        )
        joints.append(
            plant.AddJoint(
                PrismaticJoint(f"x{i}", plant.world_frame(), body.body_frame(), [1, 0, 0])
            )
        )
    plant.mutable_gravity_field().set_gravity_vector([0, 0, 0])
    plant.Finalize()
    config = ContactConfig(
        web="facet",
        standoff=STANDOFF,
        k=1e6 if n == 1 else 1e8,
        alpha=0.0,
        n=n,
        pairs=[["ball0", "ball1"], ["ball1", "ball2"]],
        max_step=1e-3,
    )
    AddNonlinearDamperContact(builder, plant, scene_graph, config=config)
    simulator = Simulator(builder.Build())
    simulator.get_mutable_integrator().set_target_accuracy(1e-9)
    context = plant.GetMyContextFromRoot(simulator.get_mutable_context())
    pitch = 1 + STANDOFF
    for joint, x, v in zip(joints, (-pitch - 1e-3, 0, pitch), (1.0, 0, 0), strict=True):
        joint.set_translation(context, x)
        joint.set_translation_rate(context, v)
    simulator.AdvanceTo(0.1)
    return np.array([joint.get_translation_rate(context) for joint in joints])


@pytest.mark.parametrize(
    ("n", "expected"), [(1.0, (-0.1303, 0.1502, 0.9800)), (1.5, (-0.0710, 0.0764, 0.9946))]
)
def test_cradle(n, expected, tmp_path, record_property):
    """Row 15: an impulse that does not travel through touching bodies as their springs have it."""
    got = cradle(tmp_path, n)
    error = np.abs(got - expected).max()
    record_property(
        "validation",
        (
            15,
            f"three balls in a row, n = {n:g}",
            str(expected),
            str(tuple(got.round(4).tolist())),
            error,
            5e-3,
        ),
    )
    assert got.sum() == pytest.approx(1.0, abs=1e-7)  # momentum
    assert (got**2).sum() == pytest.approx(1.0, abs=1e-5)  # energy
    assert error < 5e-3


def rod_run(folder, step: float, *, discrete: bool) -> tuple[float, float]:
    """Angle and height of a rod's middle, 0.1 s after its tip slid into the ground at tan θ = 2."""
    length, mass = 1.0, 1.0
    tip = length / 2
    (folder / "rod.obj").write_text(
        f"v {-tip} 0 0\nv {tip} .005 0\nv {tip} -.005 .005\nv {tip} -.005 -.005\n"
        "f 1 3 2\nf 1 4 3\nf 1 2 4\nf 2 3 4\n"
    )
    (folder / "ground.obj").write_text("v 20 0 0\nv -20 20 0\nv -20 -20 0\nf 1 2 3\n")
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, step if discrete else 0.0)
    rod = plant.AddRigidBody(
        "rod", SpatialInertia.SolidCylinderWithMass(mass, 5e-3, length, [1, 0, 0])
    )
    for body in (rod, plant.world_body()):
        name = "rod" if body is rod else "ground"
        plant.RegisterCollisionGeometry(
            body, RigidTransform(), Mesh(folder / f"{name}.obj"), name, CoulombFriction(1, 1)
        )
    plant.Finalize()
    # μ = 2 > 4/3, the least coefficient at which rigid dynamics has no answer or two, at tan θ = 2.
    config = ContactConfig(
        web="facet", standoff=5e-3, k=1e5, alpha=0.2, friction=FrictionConfig(static=2.0)
    )
    AddNonlinearDamperContact(builder, plant, scene_graph, config=config)
    simulator = Simulator(builder.Build())
    if not discrete:
        integrator = simulator.get_mutable_integrator()
        integrator.set_fixed_step_mode(True)
        integrator.set_maximum_step_size(step)
        integrator.request_initial_step_size_target(step)
    context = plant.GetMyContextFromRoot(simulator.get_mutable_context())
    theta = math.atan(2.0)
    # The tip leads the way, like chalk pushed over a board: friction turns it into the ground.
    R = RotationMatrix.MakeYRotation(-theta)
    p = -(R @ np.array([-tip, 0, 0])) + [0, 0, 5.1e-3]
    plant.SetFreeBodyPose(context, rod, RigidTransform(R, p))
    plant.SetVelocities(context, [0, 0, 0, -3.0, 0, -0.1])
    simulator.AdvanceTo(0.1)
    state = plant.GetPositionsAndVelocities(context)
    assert np.isfinite(state).all()
    X = plant.EvalBodyPoseInWorld(context, rod)
    axis = X.rotation() @ np.array([1.0, 0, 0])
    return math.atan2(axis[2], axis[0]), float(X.translation()[2])


def test_painleve_rod(tmp_path, record_property):
    """Row 16: a run that stalls or blows up where rigid dynamics is paradoxical."""
    coarse, middle, fine = (
        np.array(rod_run(tmp_path, step, discrete=False)) for step in (8e-5, 2e-5, 5e-6)
    )
    first, second = np.abs(middle - coarse).max(), np.abs(fine - middle).max()
    record_property(
        "validation",
        (
            16,
            "rod in the Painlevé region",
            "converges",
            f"{first:.1e}, then {second:.1e}",
            second,
            1e-3,
        ),
    )
    assert second < max(0.5 * first, 1e-6)
    assert second < 1e-3
    rod = functools.cache(lambda step: rod_run(tmp_path, step, discrete=True))
    for i, figure in enumerate(("angle [rad]", "height [m]")):
        row = (16, f"rod in the Painlevé region: {figure}")
        check_first_order(record_property, row, fine[i], 4e-5, lambda step, i=i: rod(step)[i], 1e-3)
