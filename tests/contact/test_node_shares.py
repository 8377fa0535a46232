"""The stiffness of a node's friction: of the pose and the lattice alone."""

from __future__ import annotations

import area_experiments as experiments
import mesh_shapes
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from contact_toolkit import (
    AreaWeb,
    CollisionMesh,
    ContactGeometry,
    ContactModel,
    ContactPair,
    Friction,
    NonlinearDamper,
)
from contact_toolkit.shapes.primitives import Primitive
from scenarios import parts

pytestmark = pytest.mark.engine

K = 1e8  # [Pa/m]
V_FB = np.array([[0] * 6, [0.3, 0.1, 0.2, 0.05, -0.03, -0.01]])
# Friction that needs the stiffness at once, without a step before.
VISCOUS = Friction(50.0, stiffness_ratio=0, damping=1e-3)


def slab() -> CollisionMesh:
    """Thinner than what lies on it, and so sampled unless that is said otherwise."""
    return CollisionMesh(*parts.box(0.4, 0.3, 0.05))


def plate() -> CollisionMesh:
    """The slab, of which it is known that it is a box: what is round has a lattice on it."""
    return CollisionMesh.from_primitive(Primitive("box", (0.4, 0.3, 0.05)))


def ball() -> CollisionMesh:
    return CollisionMesh(*mesh_shapes.ball(3, radius=0.05))


def box() -> CollisionMesh:
    return CollisionMesh(*parts.box(0.1, 0.08, 0.06))


def cylinder() -> CollisionMesh:
    return CollisionMesh.from_primitive(Primitive("cylinder", (0.03, 0.1)))


TOP = 0.025  # of the slab
LYING = Rotation.from_euler("x", 90, degrees=True)
# Body, web, where it lies and how it is turned.
CASES = {
    "face": (box, AreaWeb(sampled="a"), [0.03, 0.02, TOP + 0.02998], Rotation.identity()),
    "face over a rim": (
        box,
        AreaWeb(sampled="a"),
        [0.19, 0.02, TOP + 0.02998],
        Rotation.from_rotvec([0, 0, 0.3]),
    ),
    "slab sampled below a face": (
        box,
        AreaWeb(sampled="b"),
        [0.19, 0.02, TOP + 0.02998],
        Rotation.from_rotvec([0, 0, 0.3]),
    ),
    "face over a corner": (
        box,
        AreaWeb(0.002),
        [0.17, 0.14, TOP + 0.031],
        Rotation.from_rotvec([0.004, 0.002, 0.5]),
    ),
    "exact face over a rim": (
        box,
        AreaWeb(0.001, field="exact"),
        [0.19, 0.02, TOP + 0.0305],
        Rotation.from_rotvec([0.002, 0, 0.3]),
    ),
    "ball": (ball, AreaWeb(), [0.03, 0.02, TOP + 0.0492], Rotation.from_rotvec([1, 2, 3])),
    "ball on a rim": (ball, AreaWeb(0.002), [0.203, 0.02, TOP + 0.05], Rotation.identity()),
    "slab sampled": (ball, AreaWeb(0.002, sampled="b"), [0.198, 0.02, TOP + 0.05], LYING),
    "cylinder": (cylinder, AreaWeb(), [0.03, 0.02, TOP + 0.0295], LYING),
    "cylinder over a rim": (cylinder, AreaWeb(0.001), [0.03, 0.12, TOP + 0.0302], LYING),
    "cylinder sampled": (
        cylinder,
        AreaWeb(0.001, sampled="a", resolution=0.02),
        [0.195, 0.12, TOP + 0.0302],
        LYING,
    ),
}


# Nodes of the slab nested so deeply that parts of it are cut up apart from the rest.
CASES["deep"] = (cylinder, AreaWeb(resolution=0.003), [0.03, 0.02, TOP + 0.02995], LYING)
CASES["deep below a face"] = (
    lambda: CollisionMesh(*parts.box(0.02, 0.015, 0.06)),
    AreaWeb(sampled="b", resolution=0.006),
    [0.03, 0.02, TOP + 0.02998],
    Rotation.from_rotvec([0, 0, 0.3]),
)
ON_PLATE = {
    "lattice": (cylinder, AreaWeb(), [0.03, 0.02, TOP + 0.0295], LYING),
    "lattice over a rim": (
        cylinder,
        AreaWeb(),
        [0.195, 0.12, TOP + 0.0295],
        Rotation.from_rotvec([0.02, 0.01, 0.4]) * LYING,
    ),
    "lattice over a corner": (
        cylinder,
        AreaWeb(),
        [0.197, 0.145, TOP + 0.0285],
        Rotation.from_rotvec([0.1, 0.05, 0.4]) * LYING,
    ),
    "lattice of a capsule": (
        lambda: CollisionMesh.from_primitive(Primitive("capsule", (0.03, 0.1))),
        AreaWeb(nominal_force=20.0),
        [0.03, 0.02, TOP + 0.0299],
        Rotation.from_rotvec([3e-3, 0, 0]) * LYING,
    ),
}
CASES |= ON_PLATE


class Scene:
    """A body above a slab, anew: nothing of either surface is computed yet."""

    def __init__(self, case: str, friction: Friction = VISCOUS) -> None:
        make, web, self.p, self.q = CASES[case]
        ground = plate() if case in ON_PLATE else slab()
        geometries = [ContactGeometry("slab", 0, ground), ContactGeometry("body", 1, make())]
        pair = ContactPair(1, 0, NonlinearDamper(K, alpha=0.5), web, friction)
        self.model = ContactModel(["slab", "body"], geometries, [pair])

    def poses(self, shift: object = (0, 0, 0), turn: object = (0, 0, 0)) -> np.ndarray:
        R = (Rotation.from_rotvec(turn) * self.q).as_matrix()
        return np.array([np.eye(4), experiments.pose(np.add(self.p, shift), R)])

    def bits(self, X_FB: np.ndarray, state: object = None) -> list[bytes]:
        forces = self.model.evaluate(X_FB, V_FB, state)
        contacts = forces.contacts
        return [
            array.tobytes()
            for array in (
                contacts.key,
                contacts.stiffness,
                contacts.normal_force,
                contacts.friction_force_F,
                forces.body_wrenches,
            )
        ]


@pytest.mark.parametrize("case", CASES)
def test_an_evaluation_leaves_no_trace(case):
    """Friction that depends on what was computed before (broken: areas of what was gathered)."""
    scene = Scene(case)
    first = scene.bits(scene.poses())
    assert len(scene.model.evaluate(scene.poses(), V_FB).contacts.key) > 3
    assert scene.bits(scene.poses()) == first
    elsewhere = Scene(case)
    rng = np.random.default_rng(0)
    for _ in range(20):
        shift, turn = 2e-3 * rng.normal(size=3) - [0, 0, 1e-3], 1e-2 * rng.normal(size=3)
        elsewhere.model.evaluate(elsewhere.poses(shift, turn), V_FB)
    assert elsewhere.bits(elsewhere.poses()) == first


@pytest.mark.parametrize("case", CASES)
def test_memory_changes_no_friction(case):
    """Friction that depends on the step before (broken: areas of what memory holds)."""
    scene = Scene(case)
    rng = np.random.default_rng(1)
    state = scene.model.initial_state()
    for i in range(8):
        shift, turn = 1e-6 * i * rng.normal(size=3), 1e-6 * i * rng.normal(size=3)
        forces = scene.model.evaluate(scene.poses(shift, turn), V_FB, state)
        state = scene.model.advance(state, 1e-3 * i, forces)
        for reach in (1e-6, 1e-5, 1e-4):
            off = reach * rng.normal(size=(2, 3))
            near = scene.poses(shift + off[0], turn + off[1])
            warm = scene.bits(near, state)
            assert warm == scene.bits(near)
            if i == 4:
                assert warm == Scene(case).bits(near)


@pytest.mark.parametrize(
    "case", ["face", "ball", "ball on a rim", "cylinder", "slab sampled", "lattice"]
)
def test_a_node_is_as_stiff_under_any_load(case):
    """Held bodies that creep as their load pulsates (broken: only what is loaded counts)."""
    scene = Scene(case)
    stiffness: dict[int, float] = {}
    compared = 0
    for depth in np.linspace(0, 1e-4, 5):
        contacts = scene.model.evaluate(scene.poses((0, 0, -depth)), V_FB).contacts
        for key, k in zip(contacts.key.tolist(), contacts.stiffness, strict=True):
            compared += key in stiffness
            assert stiffness.setdefault(key, k) == k
    assert compared > 20


@pytest.mark.parametrize("over", [0.0, 0.03])
def test_a_sheet_is_as_stiff_as_what_lies_on_the_slab(over):
    """Friction too soft or too hard (broken: nodes between large and small triangles)."""
    corners = [[-0.05, -0.04, 0], [0.05, -0.04, 0], [0.05, 0.04, 0], [-0.05, 0.04, 0]]
    sheet = CollisionMesh(np.array(corners), np.array([[0, 1, 2], [0, 2, 3]]))
    geometries = [ContactGeometry("slab", 0, slab()), ContactGeometry("sheet", 1, sheet)]
    pair = ContactPair(1, 0, NonlinearDamper(K), AreaWeb(0.001), VISCOUS)
    model = ContactModel(["slab", "sheet"], geometries, [pair])
    x = 0.1 if over == 0 else 0.15 + over
    X_FB = np.array([np.eye(4), experiments.pose([x, 0.02, TOP + 1e-5])])
    stiffness = model.evaluate(X_FB, V_FB).contacts.stiffness.sum()
    # Whole: all of its area. Over the rim: what lies on the slab or within the standoff of it, and
    # half the triangles that the end of that crosses.
    on_slab = 0.1 - over
    tolerance = 1e-6 if over == 0 else 0.08
    assert stiffness == pytest.approx(K * on_slab * 0.08, rel=tolerance)
