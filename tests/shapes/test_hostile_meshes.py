"""Queries on meshes that are wrong but accepted: the answer equals brute force, and comes."""

import mesh_shapes
import numpy as np
import oracle_brute_force as brute
import oracle_triangle as exact
import pytest
from poses import pose, random_pose
from scipy.spatial.transform import Rotation

from contact_toolkit import CollisionMesh, MeshError, distance, intersects, witness_pairs

pytestmark = pytest.mark.engine


def _with_zero_area(shape):
    """Repeated corners, one point thrice, three corners on a line."""
    vertices, faces = shape
    a, b = vertices[faces[0, 0]], vertices[faces[0, 1]]
    count = len(vertices)
    extra = [[0, 0, 1], [2, 2, 2], [faces[0, 0], count, faces[0, 1]]]
    return np.vstack([vertices, 0.5 * (a + b)]), np.vstack([faces, extra])


def _with_duplicates(shape):
    vertices, faces = shape
    return vertices, np.vstack([faces, faces[:7], faces[:5, ::-1], faces[:3]])


def _non_manifold(shape):
    """A fin on every edge of the first facets."""
    vertices, faces = shape
    fins = [[f[0], f[1], (f[2] + 5) % len(vertices)] for f in faces[:6]]
    return vertices, np.vstack([faces, fins])


def _inverted(shape):
    vertices, faces = shape
    faces = faces.copy()
    faces[::3] = faces[::3, ::-1]
    return vertices, faces


def _pierced(shape):
    """A mesh that crosses itself."""
    vertices, faces = shape
    return np.vstack([vertices, vertices + 0.3]), np.vstack([faces, faces + len(vertices)])


_HOSTILE = {
    "zero area": _with_zero_area,
    "duplicates": _with_duplicates,
    "non-manifold": _non_manifold,
    "inverted": _inverted,
    "self-crossing": _pierced,
}


def _equal_to_brute_force(A, B, X_AB, standoff, tolerance):
    found = witness_pairs(A, B, X_AB, standoff, merge=False)
    expected = brute.facet_pairs(A, B, X_AB, standoff)
    order = np.lexsort((found.facet_b, found.facet_a))
    np.testing.assert_array_equal(found.facet_a[order], expected.facet_a)
    np.testing.assert_array_equal(found.facet_b[order], expected.facet_b)
    np.testing.assert_allclose(
        found.distance[order], expected.distance.astype(float), rtol=0, atol=tolerance
    )
    merged = witness_pairs(A, B, X_AB, standoff)
    assert merged.multiplicity.sum() == len(found)
    for result in (found, merged):
        for column in result.columns().values():
            assert np.isfinite(column).all()
    closest = distance(A, B, X_AB)
    nearest = brute.closest_facet_pair(A, B, X_AB)
    assert closest.distance == pytest.approx(float(nearest.distance[0]), abs=tolerance)
    assert intersects(A, B, X_AB) == (closest.distance < 1e-13)
    return len(found)


@pytest.mark.parametrize("spoil", _HOSTILE.values(), ids=_HOSTILE)
def test_tolerated_defects(spoil):
    """A defect that hides a facet from the queries, or turns an answer into NaN."""
    A = CollisionMesh(*spoil(mesh_shapes.cube()))
    B = CollisionMesh(*spoil(mesh_shapes.ball(1)))
    rng = np.random.default_rng(0)
    pairs = [
        _equal_to_brute_force(A, B, random_pose(rng, 1.0), 10.0 ** rng.uniform(-2, 0), 1e-12)
        for _ in range(40)
    ]
    assert sum(pairs) > 1000


def test_points_against_points():
    """Facets without extent, each a single point: distances between points."""
    rng = np.random.default_rng(1)
    vertices = rng.uniform(-1, 1, (30, 3))
    A = CollisionMesh(vertices, np.arange(30)[:, None].repeat(3, axis=1))
    _equal_to_brute_force(A, A, pose(p=(0.5, 0, 0)), 0.7, 1e-15)


def test_segments_against_segments():
    """Facets folded flat: a wire frame."""
    rng = np.random.default_rng(2)
    vertices = rng.uniform(-1, 1, (60, 3))
    A = CollisionMesh(vertices, np.arange(60).reshape(-1, 2)[:, [0, 1, 1]])
    _equal_to_brute_force(A, A, random_pose(rng, 0.5), 0.7, 1e-13)


def test_hundreds_of_facets_in_one_place():
    """Every facet pair at once, in every leaf."""
    A = CollisionMesh(np.eye(3), np.tile([0, 1, 2], (70, 1)))
    found = witness_pairs(A, A, pose(p=(1e-3, 0, 0)), 0.1)
    assert found.multiplicity.sum() == 70 * 70


@pytest.mark.parametrize("exponent", [-14, -10, -5, 5, 10, 14])
def test_extreme_sizes_that_are_accepted(exponent):
    """Squares that vanish or overflow in the single-precision tests."""
    scale = 10.0**exponent
    rng = np.random.default_rng(3)
    for _ in range(20):
        s, t = scale * rng.uniform(-1, 1, (2, 3, 3))
        A, B = CollisionMesh(s, [[0, 1, 2]]), CollisionMesh(t, [[0, 1, 2]])
        squared = exact.squared_distance(s, t)
        assert exact.error(distance(A, B, np.eye(4)).distance, squared) <= 1e-12 * scale
        assert intersects(A, B, np.eye(4)) == (squared == 0)


@pytest.mark.parametrize("exponent", [-320, -310, -300, -200, -100, -40, -20, -16])
def test_vanishing_sizes_are_refused(exponent):
    """Distances that come out as 0 or NaN."""
    with pytest.raises(MeshError, match="scale"):
        CollisionMesh(10.0**exponent * np.eye(3), [[0, 1, 2]])


@pytest.mark.parametrize("exponent", [16, 20, 30, 100, 153, 200, 300, 307])
def test_overflowing_sizes_are_refused(exponent):
    """Distances that come out as infinity or NaN."""
    with pytest.raises(MeshError, match="limit"):
        CollisionMesh(10.0**exponent * np.eye(3), [[0, 1, 2]])


def test_tiny_facets_in_a_large_mesh():
    """Facets of denormal size beside a facet of one metre: accepted, so answered."""
    vertices = np.vstack([np.eye(3), 1e-200 * np.eye(3), 5e-324 * np.eye(3)])
    A = CollisionMesh(vertices, np.arange(9).reshape(-1, 3))
    B = CollisionMesh(*mesh_shapes.cube(0.1))
    for p in ((0.2, 0.2, 0.2), (0.0, 0.0, 0.0), (-0.3, 0.1, 0.0)):
        found = witness_pairs(A, B, pose(p=p), 2.0, merge=False)
        expected = brute.facet_pairs(A, B, pose(p=p), 2.0)
        order = np.lexsort((found.facet_b, found.facet_a))
        np.testing.assert_array_equal(found.facet_a[order], expected.facet_a)
        np.testing.assert_allclose(
            found.distance[order], expected.distance.astype(float), rtol=0, atol=1e-12
        )


@pytest.mark.parametrize("reach", [1e7, 1e12, 9e14])
def test_far_pose(reach):
    """A relative pose far outside single precision's range of exact numbers."""
    A, X_AB = CollisionMesh(*mesh_shapes.cube()), pose(p=(reach, 0, 0))
    assert distance(A, A, X_AB).distance == pytest.approx(reach - 1, rel=1e-15)
    assert len(witness_pairs(A, A, X_AB, 1.0)) == 0
    assert not intersects(A, A, X_AB)


@pytest.mark.parametrize("reach", [1e16, 1e30, 1e200])
def test_pose_out_of_reach_is_refused(reach):
    """Squares that overflow, and two bodies that then seem to be nowhere near or everywhere."""
    A = CollisionMesh(*mesh_shapes.cube())
    for query in (distance, intersects):
        with pytest.raises(ValueError, match="X_AB"):
            query(A, A, pose(p=(reach, 0, 0)))


def test_standoff_beyond_everything():
    """All facets against all: nothing culled, nothing twice."""
    A, B = CollisionMesh(*mesh_shapes.ball(1)), CollisionMesh(*mesh_shapes.cube())
    for standoff in (1e3, 1e18, 1e200):
        found = witness_pairs(A, B, pose(p=(2, 0, 0)), standoff, merge=False)
        assert len(found) == len(A.faces) * len(B.faces)


def test_facet_without_area_through_a_facet():
    """Its plane is rounding: facets that cross must not be told apart by it."""
    A = CollisionMesh([[-2.0, 1, 4], [4, 1, 2], [-3, 2, 2]], [[0, 1, 2]])
    B = CollisionMesh([[-3.0, -3, -3], [-2, 0, 2], [-1, 3, 7]], [[0, 1, 2]])
    rng = np.random.default_rng(0)
    for _ in range(50):
        X_AB = np.eye(4)
        X_AB[:3, :3] = Rotation.from_rotvec(1e-9 * rng.normal(size=3)).as_matrix()
        assert distance(A, B, X_AB).distance == 0
