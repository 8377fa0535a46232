"""Surfaces as CAD kernels tessellate them: fans about one corner, slivers, very uneven facets.

Every query must find what a test of all facets against all finds, whatever its culling makes of
planes that are thin, of slabs and of boxes.
"""

from itertools import islice

import mesh_shapes
import numpy as np
import pytest
from oracle_prisms import swept_by_prisms
from scipy.spatial.transform import Rotation

from contact_toolkit import (
    CollisionMesh,
    _core,
    distance,
    intersects,
    swept_distance,
    witness_pairs,
)

pytestmark = pytest.mark.engine

POSES = 12


def fan_cylinder(sections, radius, height, chamfer):
    """A closed cylinder whose ends are fans about their first corner, with a narrow chamfer."""
    angles = 2 * np.pi * np.arange(sections) / sections
    around = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    rings = [(radius - chamfer, 0.0), (radius, chamfer), (radius, height - chamfer)]
    rings.append((radius - chamfer, height))
    vertices = np.concatenate([np.c_[r * around, np.full(sections, z)] for r, z in rings])
    k = np.arange(sections)
    after = (k + 1) % sections
    faces = []
    for ring in range(len(rings) - 1):
        low, high = ring * sections, (ring + 1) * sections
        faces += [np.stack([low + k, low + after, high + after], 1)]
        faces += [np.stack([low + k, high + after, high + k], 1)]
    fan = np.stack([0 * k, k, after], 1)[1:-1]
    faces += [fan[:, ::-1], fan + (len(rings) - 1) * sections]
    return vertices, np.concatenate(faces).astype(np.int32)


SHAPES = {
    "coin": fan_cylinder(60, 1.0, 0.1, 1e-4),
    "rod": fan_cylinder(40, 0.1, 2.0, 1e-3),
    "disc": fan_cylinder(14, 1.0, 0.1, 1e-2),
    "stick": fan_cylinder(10, 0.1, 2.0, 1e-2),
    "doughnut": mesh_shapes.doughnut(24, 16),
}


def all_distances(A, B, X_AB):
    """Distances of every facet of A (rows) to every facet of B."""
    facets = np.meshgrid(
        *(np.arange(len(mesh.faces), dtype=np.int32) for mesh in (A, B)), indexing="ij"
    )
    a, b = (np.ascontiguousarray(indices.reshape(-1)) for indices in facets)
    return _core.facet_distances(A._core, B._core, X_AB, a, b).reshape(len(A.faces), -1)


def meetings(name_a, name_b, offset):
    """A pair and poses at which it is near or crosses; A's file has it askew and off its origin."""
    rng = np.random.default_rng(sum(map(ord, name_a + name_b)))
    (points_a, faces_a), (points_b, faces_b) = SHAPES[name_a], SHAPES[name_b]
    turn = Rotation.random(rng=rng).as_matrix()
    A, B = CollisionMesh(points_a @ turn.T + offset, faces_a), CollisionMesh(points_b, faces_b)
    for pose in range(POSES):
        X_AB = np.eye(4)
        X_AB[:3, :3] = Rotation.random(rng=rng).as_matrix()
        way = rng.standard_normal(3)
        way /= np.linalg.norm(way)
        X_AB[:3, 3] = offset + 4.0 * way
        for _ in range(30):
            X_AB[:3, 3] -= (distance(A, B, X_AB).distance - 0.01) * way
        X_AB[:3, 3] -= way * [0.0, 0.02, 0.3][pose % 3]
        yield A, B, X_AB


@pytest.mark.parametrize("offset", [0.0, 1e3])
@pytest.mark.parametrize(("a", "b"), [("coin", "rod"), ("coin", "coin"), ("rod", "doughnut")])
def test_queries_find_what_brute_force_finds(a, b, offset):
    for A, B, X_AB in meetings(a, b, offset):
        expected = all_distances(A, B, X_AB)
        assert distance(A, B, X_AB).distance == expected.min()
        assert intersects(A, B, X_AB) == (expected.min() == 0.0)
        rows = witness_pairs(A, B, X_AB, 0.05, merge=False)
        found = np.full_like(expected, np.inf)
        found[rows.facet_a, rows.facet_b] = rows.distance
        np.testing.assert_array_equal(found, np.where(expected <= 0.05, expected, np.inf))


@pytest.mark.parametrize("way", [1e-3, 0.3])
def test_translations_of_fans(way):
    # Many facets share the closest vertex or edge: of these ties none is the answer by itself.
    rng = np.random.default_rng(3)
    for A, B, X_AB in islice(meetings("disc", "stick", 0.0), 6):
        X_end = X_AB.copy()
        X_end[:3, 3] += way * rng.standard_normal(3)
        swept = swept_distance(A, B, X_AB, X_end)
        assert swept.converged
        assert abs(swept.distance - swept_by_prisms(A, B, X_AB, X_end)) < 1e-13


def test_a_turn_is_no_closer_than_its_poses():
    # A turn's search begins at static distances: they must be an upper bound, never the answer.
    for A, B, X_AB in meetings("coin", "rod", 0.0):
        X_end = X_AB.copy()
        X_end[:3, :3] = Rotation.from_rotvec([0.0, 0.3, 0.2]).as_matrix() @ X_AB[:3, :3]
        swept = swept_distance(A, B, X_AB, X_end, tolerance=1e-4)
        turn = Rotation.from_matrix(X_end[:3, :3] @ X_AB[:3, :3].T).as_rotvec()
        for s in np.linspace(0.0, 1.0, 9):
            X = X_AB.copy()
            X[:3, :3] = Rotation.from_rotvec(s * turn).as_matrix() @ X_AB[:3, :3]
            assert swept.distance <= distance(A, B, X).distance + 1e-12
        assert swept.converged
        assert swept.error <= 1e-4 * (1 + 1e-9)
