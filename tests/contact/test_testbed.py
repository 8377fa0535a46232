"""The Drake-free testbed: rigid-body motion by closed form, and contact through Drake beside it."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from contact_toolkit import CollisionMesh, Friction, NonlinearDamper
from contact_toolkit.testbed import MovingBody, Testbed
from scenarios import parts

K = 2e8  # [Pa/m]
ALPHA = 0.1
FRICTION = 0.4
DAMPING = 1e-4  # [s]
DENSITY = 1000.0


def thrown(part, p, degrees, V) -> MovingBody:
    X = np.eye(4)
    X[:3, :3] = Rotation.from_euler("xyz", degrees, degrees=True).as_matrix()
    X[:3, 3] = p
    return MovingBody.from_density("body", CollisionMesh(*part), DENSITY, X, V)


THROWN = {
    "doughnut": lambda: thrown(
        parts.doughnut(major_sections=32, minor_sections=16),
        (0, 0, 0.06), (25, 10, 0), (2, -1, 3, 0.4, 0.1, -0.5),
    ),
    "l_bracket": lambda: thrown(
        parts.l_bracket(), (0, 0, 0.09), (30, 40, 10), (-3, 2, 1, 0.3, -0.2, -0.4)
    ),
}  # fmt: skip


def plate():
    """Its top is the plane z = 0."""
    vertices, faces = parts.box(1.0, 1.0, 0.1)
    return vertices - [0, 0, 0.05], faces


def test_mass_properties_of_a_box():
    """A wrong inertia: everything else would still look plausible."""
    X = np.eye(4)
    body = MovingBody.from_density("box", CollisionMesh(*parts.box(0.1, 0.2, 0.3)), 500.0, X)
    a, b, c = 0.1, 0.2, 0.3
    assert_allclose(body.mass, 500 * a * b * c, rtol=1e-14)
    expected = body.mass / 12 * np.diag([b * b + c * c, a * a + c * c, a * a + b * b])
    assert_allclose(body.I_BBcm, expected, rtol=1e-12, atol=1e-18)


def test_free_flight():
    """Momentum or energy lost in the air, or a centre of mass off its parabola."""
    body = THROWN["l_bracket"]()
    run = Testbed([body], None, NonlinearDamper(K)).run(0.5, rtol=1e-11, atol=1e-13)
    X, V = run.X_FB[:, 0], run.V_FB[:, 0]
    p_BoBcm = np.einsum("nij,j->ni", X[:, :3, :3], body.p_BoBcm)
    v_cm = V[:, 3:] + np.cross(V[:, :3], p_BoBcm)
    t = run.time[:, None]
    fall = np.array([0, 0, -9.81])
    p_cm = X[:, :3, 3] + p_BoBcm
    assert_allclose(p_cm, p_cm[0] + v_cm[0] * t + fall * t**2 / 2, atol=1e-10)
    I_F = X[:, :3, :3] @ body.I_BBcm @ X[:, :3, :3].transpose(0, 2, 1)
    L = np.einsum("nij,nj->ni", I_F, V[:, :3])
    assert_allclose(L, np.broadcast_to(L[0], L.shape), rtol=1e-8)


def drake_poses(body: MovingBody, times, step: float, tmp_path):
    """Poses of the same body at these times, through the whole Drake diagram."""
    from pydrake.geometry import Mesh, ProximityProperties
    from pydrake.math import RigidTransform
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    from pydrake.multibody.tree import RotationalInertia, SpatialInertia
    from pydrake.systems.analysis import Simulator
    from pydrake.systems.framework import DiagramBuilder

    from systems import AddNonlinearDamperContact, ContactConfig, FrictionConfig

    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    I = np.asarray(body.I_BBcm)  # noqa: E741
    inertia = SpatialInertia.MakeFromCentralInertia(
        body.mass, body.p_BoBcm, RotationalInertia(*np.diag(I), I[0, 1], I[0, 2], I[1, 2])
    )
    moving = plant.AddRigidBody("body", inertia)
    for owner, surface, name in (
        (moving, (body.mesh.vertices, body.mesh.faces), "body"),
        (plant.world_body(), plate(), "plate"),
    ):
        file = tmp_path / f"{name}.obj"
        parts.write_obj(file, surface)
        plant.RegisterCollisionGeometry(
            owner, RigidTransform(), Mesh(str(file)), name, ProximityProperties()
        )
    plant.mutable_gravity_field().set_gravity_vector([0, 0, -9.81])
    plant.Finalize()
    friction = FrictionConfig(static=FRICTION, damping=DAMPING)
    config = ContactConfig(k=K, alpha=ALPHA, settling=0.0, friction=friction)
    AddNonlinearDamperContact(builder, plant, scene_graph, config=config)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    integrator = simulator.get_mutable_integrator()
    integrator.set_fixed_step_mode(True)
    integrator.set_maximum_step_size(step)
    integrator.request_initial_step_size_target(step)
    context = simulator.get_mutable_context()
    plant_context = plant.GetMyMutableContextFromRoot(context)
    plant.SetFreeBodyPose(plant_context, moving, RigidTransform(body.X_FB))
    q_v = np.concatenate([plant.GetPositions(plant_context), body.V_FB])
    plant.SetPositionsAndVelocities(plant_context, q_v)
    poses = []
    for time in times:
        simulator.AdvanceTo(time)
        poses.append(plant.EvalBodyPoseInWorld(plant_context, moving).GetAsMatrix4())
    return np.array(poses)


@pytest.mark.slow
@pytest.mark.parametrize("name", THROWN)
def test_agrees_with_drake_over_three_impacts(name, tmp_path):
    """Anything wrong in the coupling: frames, moments, velocities, order of the anchors' updates.

    Both take the same fixed steps, since anchors form at step ends; only then do two integrators of
    different make converge to the same motion rather than to each other's history.
    """
    step = 4e-5
    body = THROWN[name]()
    testbed = Testbed(
        [body],
        CollisionMesh(*plate()),
        NonlinearDamper(K, ALPHA),
        friction=Friction(FRICTION, damping=DAMPING),
    )
    run = testbed.run(0.4, method="RK23", rtol=1e-3, atol=1e3, max_step=step)
    loaded = run.springs > 0
    parted = np.flatnonzero(loaded[:-1] & ~loaded[1:])[:3] + 1
    assert len(parted) == 3, "too short a run to see three impacts"
    expected = drake_poses(body, step * np.round(run.time[parted] / step), step, tmp_path)
    for X, Y in zip(run.X_FB[parted, 0], expected, strict=True):
        assert np.linalg.norm(X[:3, 3] - Y[:3, 3]) < 1e-6
        assert Rotation.from_matrix(X[:3, :3].T @ Y[:3, :3]).magnitude() < 1e-5


def test_two_bodies_conserve_momentum():
    """Force and counter-force that do not cancel, or act on the wrong body."""
    ball = CollisionMesh(*parts.icosphere(0.05, 2))
    left, right = np.eye(4), np.eye(4)
    left[:3, 3], right[:3, 3] = (-0.08, 0.0, 0.0), (0.08, 0.02, 0.0)
    bodies = [
        MovingBody.from_density("left", ball, 1000.0, left, (0, 1, 0, 1.0, 0, 0)),
        MovingBody.from_density("right", ball, 3000.0, right, (0, 0, 2, -1.0, 0, 0)),
    ]
    testbed = Testbed(
        bodies, None, NonlinearDamper(1e9, 0.1), friction=Friction(0.5), gravity=(0, 0, 0)
    )
    run = testbed.run(0.12, rtol=1e-8, atol=1e-11)
    assert run.springs.max() > 0
    assert run.springs[-1] == 0
    mass = np.array([b.mass for b in bodies])
    p = np.einsum("b,nbi->ni", mass, run.V_FB[:, :, 3:])
    spin = np.stack(
        [run.V_FB[:, i, :3] @ bodies[i].I_BBcm for i in range(2)]
    )  # balls: I is a number
    orbit = np.cross(run.X_FB[:, :, :3, 3], mass[:, None] * run.V_FB[:, :, 3:]).sum(axis=1)
    L = spin.sum(axis=0) + orbit
    assert_allclose(p, np.broadcast_to(p[0], p.shape), atol=1e-9)
    assert_allclose(L, np.broadcast_to(L[0], L.shape), atol=1e-7)
    assert not np.allclose(run.V_FB[-1], run.V_FB[0], atol=0.1)


def test_bad_bodies_are_refused():
    """A body that no equation of motion fits."""
    mesh = CollisionMesh(*parts.box())
    with pytest.raises(ValueError, match="mass must be positive"):
        MovingBody("b", mesh, 0.0, np.zeros(3), np.eye(3))
    with pytest.raises(ValueError, match="positive definite"):
        MovingBody("b", mesh, 1.0, np.zeros(3), np.diag([1.0, 1.0, -1.0]))
    with pytest.raises(ValueError, match="closed mesh"):
        MovingBody.from_density("b", CollisionMesh(mesh.vertices, mesh.faces[:-1]), 1000.0)
    with pytest.raises(ValueError, match="method"):
        Testbed([MovingBody.from_density("b", mesh, 1.0)], None, NonlinearDamper(K)).run(
            1.0, method="Euler"
        )
