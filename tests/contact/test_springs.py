"""How many springs a contact takes by default, and that they are enough; primitives as such."""

from __future__ import annotations

import math
from itertools import pairwise

import area_experiments as experiments
import numpy as np
import pytest
from area_experiments import Web, pose
from scipy.optimize import brentq
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
from scenarios.parts.surface import revolve

pytestmark = pytest.mark.engine


def primitive(kind: str, *size: float) -> CollisionMesh:
    return CollisionMesh.from_primitive(Primitive(kind, size))


def on_floor(
    mesh: CollisionMesh, K: float, floor: CollisionMesh, **options: object
) -> ContactModel:
    """Bodies: a floor, and one with `mesh`."""
    geometries = [ContactGeometry("floor", 0, floor), ContactGeometry("body", 1, mesh)]
    pair = ContactPair(0, 1, NonlinearDamper(k=K, alpha=0.0, n=1.0), **options)
    return ContactModel(["floor", "body"], geometries, [pair])


def at(p: object, R: object = None) -> np.ndarray:
    return np.array([np.eye(4), pose(p, np.eye(3) if R is None else R)])


@pytest.mark.parametrize("resolution", [None, 0.1])
def test_a_face_takes_few_springs(resolution):
    """Flat faces would cost thousands of springs (broken: no triangle counted as flat)."""
    depth, slab = 5e-5, parts.box(4, 2, 0.2)
    model = on_floor(
        CollisionMesh(*parts.box(0.2, 0.2, 0.1)),
        1e9,
        CollisionMesh(*slab),
        web=AreaWeb(resolution=resolution),
    )
    X = at([0.0123, 0.0077, 0.15 - depth])
    assert model.find(X).num_springs.sum() < 250
    force = model.evaluate(X, np.zeros((2, 6))).body_wrenches[1][5]
    walls = 4 * 0.2 * depth / 2  # [m²] pressed by half the depth
    assert force == pytest.approx(1e9 * depth * (0.2 * 0.2 + walls), rel=1e-9)


def test_a_face_tips_where_it_should():
    """A tilted face would bear its load elsewhere (broken: corners of triangles weighed alike)."""
    # A face of side L about its edge, tilted by t: linear pressure, moment K t L⁴/3 about the edge.
    L, t, K = 0.2, 1e-4, 1e9
    web = Web(parts.box(L, L, 0.1), parts.box(4, 2, 0.2), K)
    R = np.array([[math.cos(t), 0, math.sin(t)], [0, 1, 0], [-math.sin(t), 0, math.cos(t)]])
    X_SB = pose(R=R)  # of the box in the slab; its edge x = -L/2 in the slab's top
    X_SB[:3, 3] = [0, 0, 0.1 - (R @ [-L / 2, 0, -0.05])[2]]
    wrench = web.wrench(np.linalg.inv(X_SB))
    edge = np.array([-L / 2, 0, -0.05])
    about = wrench.moment - np.cross(edge, wrench.force)
    assert abs(about[1]) == pytest.approx(K * t * L**4 / 3, rel=0.01)


def test_friction_turns_a_face_as_hard_as_it_should():
    """Friction against spinning would be off (broken: triangles twice as large)."""
    L, mu, depth = 0.2, 0.5, 1e-5
    model = on_floor(
        primitive("box", L, L, 0.1), 1e9, primitive("box", 4, 2, 0.2), friction=Friction(mu)
    )
    V = np.zeros((2, 6))
    V[1, 2] = 1.0
    state = model.initial_state()
    for step in range(4):  # far enough for all but the middle to slip
        c, s = math.cos(step * 1e-2), math.sin(step * 1e-2)
        X = at([0, 0, 0.15 - depth], np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]))
        forces = model.evaluate(X, V, state)
        state = model.advance(state, step * 1e-2, forces)
    contacts = forces.contacts
    moment = forces.body_wrenches[1][2]
    mean_radius = L * (math.sqrt(2) + math.asinh(1)) / 6
    load = contacts.normal_force.sum()
    assert abs(moment) == pytest.approx(mu * load * mean_radius, rel=0.02)


@pytest.mark.parametrize("floor", ["slab", "half_space"])
@pytest.mark.parametrize("R", [0.05, 0.005, 5e-4])
def test_balls_need_no_settings(R, floor):
    """A ball would sink too deep by default, or rattle as it rolls (broken: facets sampled)."""
    K = 1e7 / (0.01 * 2 * R * math.sqrt(3))
    load = 9.8e3 * 4 / 3 * math.pi * R**3
    depth = math.sqrt(load / (math.pi * K * R))
    base = primitive("box", 4, 2, 0.2) if floor == "slab" else primitive("half_space", 100.0)
    model = on_floor(primitive("sphere", R), K, base)
    top = 0.1 if floor == "slab" else 0.0
    rng = np.random.default_rng(0)
    forces = np.array(
        [
            model.evaluate(
                at([*(R * rng.uniform(-3, 3, 2)), top + R - depth]), np.zeros((2, 6))
            ).body_wrenches[1]
            for _ in range(12)
        ]
    )[:, 3:]
    assert forces[:, 2] == pytest.approx([load] * 12, rel=0.02)
    assert np.ptp(forces[:, 2]) < 1e-3 * load
    assert np.abs(forces[:, :2]).max() < 1e-3 * load


def test_a_cylinder_on_its_side_is_round():
    """It would rest on a facet and not roll (broken: its mesh probed)."""
    R, L = 0.1, 0.2
    cylinder = primitive("cylinder", R, L)
    K = 1e7 / (0.01 * cylinder.diagonal)
    load = 9.8e3 * math.pi * R**2 * L
    depth = (0.75 * load / (K * L * math.sqrt(2 * R))) ** (2 / 3)
    model = on_floor(cylinder, K, primitive("box", 4, 2, 0.2))
    forces = []
    for turn in np.linspace(0, 0.4, 9):
        c, s = math.cos(turn), math.sin(turn)
        R_FB = np.array([[c, -s, 0], [0, 0, -1], [s, c, 0]])  # its axis along y, turned about it
        X = at([0.3 + R * turn, 0.11, 0.1 + R - depth], R_FB)
        forces.append(model.evaluate(X, np.zeros((2, 6))).body_wrenches[1][3:])
    forces = np.array(forces)
    assert forces[:, 2] == pytest.approx([load] * 9, rel=0.02)
    assert np.abs(forces[:, 0]).max() < 1e-3 * load


@pytest.mark.parametrize("offset", [0.0, 1e-3, 0.0305])
@pytest.mark.parametrize("known", ["mesh", "primitive"])
def test_flush_boxes_rest_where_they_touch(offset, known):
    """Equal boxes would stand on bulges of the field (broken: spline alone along the edges)."""
    K, load, side = 1e9, 10.0, 0.1
    cube = CollisionMesh(*parts.box()) if known == "mesh" else primitive("box", side, side, side)
    model = on_floor(cube, K, cube)

    def excess(z: float) -> float:
        X = at([offset, offset, side + z])
        return model.evaluate(X, np.zeros((2, 6))).body_wrenches[1][5] - load

    z = brentq(excess, -1e-4, 1e-4, xtol=1e-13)
    # Where an edge of one lies amid the other's face, half a node spacing goes astray along it.
    tolerance = 0.02 if offset < 0.01 else 0.02 * cube.diagonal / (side - offset)
    assert z == pytest.approx(-load / (K * (side - offset) ** 2), rel=tolerance)


@pytest.mark.parametrize("resolution", [0.02, 0.1])
def test_a_box_slides_level_over_flush_boxes(resolution):
    """It would hop over the seams (broken: the field's cell grows with the node spacing)."""
    K, depth = 1e9, 1e-5
    web = Web(parts.box(0.1, 0.1, 0.1), parts.box(0.4, 0.4, 0.1), K, resolution=resolution)
    for x in np.linspace(-0.26, -0.14, 25):  # over the edge at x = -0.2
        force = web.wrench(pose([-x, 0, -0.1 + depth])).force[2]
        share = min(1.0, max(0.0, (x + 0.05 + 0.2) / 0.1))
        assert force <= K * depth * 0.1 * (0.1 * share + 2 * depth) * 1.001
        assert force >= K * depth * 0.1 * (0.1 * share - resolution * 0.18)


@pytest.mark.parametrize(
    "shape",
    [("sphere", 0.05), ("capsule", 0.03, 0.1), ("cylinder", 0.05, 0.1), ("box", 0.1, 0.08, 0.06)],
    ids=str,
)
def test_primitives_are_conservative(shape):
    """A primitive's gradient would not be that of its distance (broken: a sign of the rim's)."""
    slab, body = primitive("box", 0.2, 0.2, 0.05), primitive(*shape)
    web = Web(slab, body, 1e8)
    for seed in range(4):
        R = Rotation.random(random_state=seed).as_matrix()
        z = brentq(lambda z, R=R: web.wrench(pose([0.01, 0.02, z], R)).energy - 1e-3, -0.05, 0.2)
        assert experiments.gradient_error(web, pose([0.01, 0.02, z], R)) < 1e-6


def test_long_thin_facets_take_no_more_springs_than_short_ones():
    """A tube's wall of tall facets (broken: such facets halved again and again, 395 springs)."""
    tall, R, depth = 0.095, 0.02, 2.7e-4
    ball = pose([(0.04 + R - depth) * math.cos(0.3), (0.04 + R - depth) * math.sin(0.3), -0.04])
    K, springs = 1e9, []
    # The pressure of the ball upon the polygon that the wall is, summed up on a fine grid.
    corner = 2 * math.pi / 64 * np.arange(-8, 16)
    t, z = np.meshgrid((np.arange(100) + 0.5) / 100, np.arange(-6e-3, 6e-3, 2e-5))
    truth = np.zeros(2)
    for first, last in pairwise(corner):
        ends = 0.04 * np.array([[math.cos(a), math.sin(a)] for a in (first, last)])
        p = ends[0] + t[..., None] * (ends[1] - ends[0])
        away = np.dstack([p - ball[:2, 3], z])
        distance = np.linalg.norm(away, axis=2)
        load = K * np.maximum(0, R - distance) * np.linalg.norm(ends[1] - ends[0]) / 100 * 2e-5
        truth -= np.einsum("ij,ijk->k", load / distance, away[..., :2])
    for rings in (1, 24):
        heights = np.linspace(0, -tall, rings + 1)
        outside = np.column_stack([np.full(rings + 1, 0.04), heights[::-1]])
        inside = np.column_stack([np.full(rings + 1, 0.036), heights])
        tube = CollisionMesh(*revolve(np.vstack([outside, inside]), 64, closed=True))
        model = on_floor(primitive("sphere", R), K, tube, web=AreaWeb(resolution=0.02, sampled="a"))
        X = np.array([np.eye(4), ball])
        springs.append(int(model.find(X).num_springs.sum()))
        force = model.evaluate(X, np.zeros((2, 6))).body_wrenches[1][3:5]
        np.testing.assert_allclose(force, truth, atol=0.02 * np.linalg.norm(truth))
    assert springs[0] < 2 * springs[1]
