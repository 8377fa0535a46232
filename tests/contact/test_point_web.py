"""PointWeb: one spring at a ball's centre, against closed forms and differences."""

import contact_scenes as scenes
import mesh_shapes
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from contact_toolkit import CollisionMesh, ContactModel, Friction, NonlinearDamper, PointWeb
from contact_toolkit.shapes.primitives import Primitive, box

pytestmark = pytest.mark.engine

K, RADIUS = 2e4, 1e-7
POINT = CollisionMesh.from_primitive(Primitive("sphere", (RADIUS,)), 0.02)
GROUNDS = {
    "box": (CollisionMesh(*box([0.2, 0.2, 0.2])), 0.1),
    "ball": (CollisionMesh.from_primitive(Primitive("sphere", (0.1,)), 0.02), 0.1),
    "half space": (CollisionMesh.from_primitive(Primitive("half_space", (1.0,)), 0.02), 0.0),
}


def model(ground: CollisionMesh, *, swapped: bool = False, friction: float = 0.0) -> ContactModel:
    """The point is the moving body, or the fixed one."""
    pair = (ground, POINT) if swapped else (POINT, ground)
    damper = NonlinearDamper(k=K, alpha=0.3)
    return scenes.model(*pair, damper, web=PointWeb(), friction=Friction(friction))


@pytest.mark.parametrize("ground", GROUNDS)
@pytest.mark.parametrize("depth", [-1e-9, 1e-9, 1e-6, 1e-3])
def test_a_point_presses_by_its_depth(ground, depth):
    """A point that falls through, or is taken for thousands of springs of its surface."""
    mesh, top = GROUNDS[ground]
    X_FB = scenes.poses((0.01 if ground != "ball" else 0.0, 0.0, top + RADIUS - depth))
    forces = model(mesh).evaluate(X_FB, scenes.velocities())
    assert len(forces.loaded) == (depth > 0)
    expected = K * max(depth, 0.0)
    assert_allclose(forces.body_wrenches[1, 3:], [0, 0, expected], atol=1e-9 * K * abs(depth))
    assert_allclose(forces.body_wrenches[0, 3:], [0, 0, -expected], atol=1e-9 * K * abs(depth))
    assert forces.stored == pytest.approx(expected**2 / (2 * K), rel=1e-7)


@pytest.mark.parametrize("ground", ["box", "ball"])
@pytest.mark.parametrize("swapped", [False, True])
def test_its_derivatives_are_those_of_its_force(ground, swapped):
    """Newton's method that crawls where points touch."""
    mesh, top = GROUNDS[ground]
    turn = Rotation.from_rotvec([0.3, -0.2, 0.5]).as_matrix()
    p = np.array([0.02, -0.01, np.sqrt(top**2 - 0.0005) if ground == "ball" else top]) - 1e-5
    X_FB = scenes.poses(p, turn)
    if swapped:
        X_FB = np.stack([X_FB[1], X_FB[0]])
        p = np.zeros(3)
    made = model(mesh, swapped=swapped)
    V_FB = scenes.velocities()
    found = made.linearize(X_FB, V_FB)
    for k in range(6):
        change = []
        for sign in (1, -1):
            moved = X_FB.copy()
            xi = np.zeros(6)
            xi[k] = sign * 1e-7
            moved[1, :3, :3] = Rotation.from_rotvec(xi[:3]).as_matrix() @ moved[1, :3, :3]
            moved[1, :3, 3] += xi[3:]
            change.append(made.evaluate(moved, V_FB).body_wrenches[1])
        slope = (change[1] - change[0]) / 2e-7
        assert_allclose(found.stiffness[0][:, k], slope, atol=1e-5 * K)


def test_remembering_changes_no_bit():
    """A point known to be apart that would pass through."""
    made = model(GROUNDS["box"][0])
    state = made.initial_state()
    V_FB = scenes.velocities()
    for step in range(2):
        X_FB = scenes.poses((0.0, 0.0, 0.1 + 1e-4))
        state = made.advance(state, 1e-3 * step, made.evaluate(X_FB, V_FB, state))
    for z in (0.1 + 5e-5, 0.1 + 2e-7, 0.1 + 5e-8, 0.1 - 1e-6):
        X_FB = scenes.poses((0.0, 0.0, z))
        warm, cold = made.evaluate(X_FB, V_FB, state), made.evaluate(X_FB, V_FB)
        assert warm.body_wrenches.tobytes() == cold.body_wrenches.tobytes()


@pytest.mark.parametrize(
    ("pair", "damper", "complaint"),
    [
        ((GROUNDS["box"][0],) * 2, NonlinearDamper(1.0), "a PointWeb needs a sphere"),
        ((POINT, GROUNDS["box"][0]), NonlinearDamper(1.0, n=1.5), "a PointWeb is linear, n = 1"),
        (
            (POINT, CollisionMesh(*mesh_shapes.sheet(2))),
            NonlinearDamper(1.0),
            "'ground' has no inside; mend it, or use AreaWeb",
        ),
    ],
)
def test_what_is_no_point_is_refused(pair, damper, complaint):
    with pytest.raises(ValueError, match=complaint):
        scenes.model(*pair, damper, web=PointWeb())
    with pytest.raises(ValueError, match="standoff must be finite and not negative, not -1"):
        PointWeb(-1.0)
