"""Merging witness pairs: one row for one contact, with counts known by hand."""

import mesh_shapes
import numpy as np
import oracle_brute_force as brute
import pytest
from mesh_shapes import WITNESS_PAIRS
from poses import pose, random_pose

from contact_toolkit import CollisionMesh, FeatureKind, witness_pairs

pytestmark = pytest.mark.engine

VERTEX, EDGE, FACET, _ = FeatureKind


@pytest.mark.parametrize("shapes", WITNESS_PAIRS.values(), ids=WITNESS_PAIRS)
def test_merging_groups_by_features(shapes):
    """Merging that loses a facet pair, or joins what lies on different features."""
    A, B = (CollisionMesh(*shape) for shape in shapes)
    rng = np.random.default_rng(3)
    for _ in range(20):
        X_AB = random_pose(rng, A.diagonal / 2 + B.diagonal / 2)
        single = witness_pairs(A, B, X_AB, 0.1 * A.diagonal, merge=False)
        merged = witness_pairs(A, B, X_AB, 0.1 * A.diagonal)
        assert (single.multiplicity == 1).all()
        assert merged.multiplicity.sum() == len(single.distance)
        counts = {}
        for row in np.hstack([single.feature_a, single.feature_b]):
            counts[tuple(row.tolist())] = counts.get(tuple(row.tolist()), 0) + 1
        rows = [tuple(row) for row in np.hstack([merged.feature_a, merged.feature_b]).tolist()]
        assert len(set(rows)) == len(rows)
        assert dict(zip(rows, merged.multiplicity.tolist(), strict=True)) == counts


def _upright_cube(size=1.0):
    return CollisionMesh(*mesh_shapes.cube(size))


def _on_corner():
    """The rotation that stands a cube on the corner 0."""
    z = np.ones(3) / np.sqrt(3)
    x = np.array([1, -1, 0]) / np.sqrt(2)
    return np.stack([x, np.cross(z, x), z])


def _on_edge():
    """The rotation that stands a cube on the edge between corners 0 and 4, along x."""
    c = np.sqrt(0.5)
    return np.array([[1, 0, 0], [0, c, -c], [0, c, c]])


def _rows(found):
    return sorted(
        (tuple(a), tuple(b), m)
        for a, b, m in zip(
            found.feature_a.tolist(),
            found.feature_b.tolist(),
            found.multiplicity.tolist(),
            strict=True,
        )
    )


def test_cube_corner_over_a_facet():
    """One contact, behind it the corner's facets each against the facet below."""
    A, B = _upright_cube(10), _upright_cube()
    X_AB = pose(_on_corner(), (1, 2.1, 5 + np.sqrt(3) / 2 + 0.01))
    found = witness_pairs(A, B, X_AB, 0.011)
    at_corner = np.count_nonzero((B.faces == 0).any(axis=1))
    (top,) = _facets_under(A, [1, 2.1, 5])
    assert _rows(found) == [((FACET, top), (VERTEX, 0), at_corner)]
    assert found.distance[0] == pytest.approx(0.01, abs=1e-14)
    np.testing.assert_allclose(found.p_ACa[0], [1, 2.1, 5], atol=1e-14)
    np.testing.assert_allclose(found.normal_A[0], [0, 0, -1], atol=1e-13)


def test_cube_edge_over_a_facet():
    """The two facets of the edge see the same closest points: one row where they agree."""
    A, B = _upright_cube(10), _upright_cube()
    X_AB = pose(_on_edge(), (1, 3, 5 + np.sqrt(0.5) + 0.01))
    single = witness_pairs(A, B, X_AB, 0.011, merge=False)
    at_edge = np.nonzero(np.isin(B.faces, [0, 4]).any(axis=1))[0]
    (top,) = _facets_under(A, [1, 3, 5])
    assert set(single.facet_b.tolist()) == set(at_edge.tolist())
    assert set(single.facet_a.tolist()) == {top}
    merged = witness_pairs(A, B, X_AB, 0.011)
    assert merged.multiplicity.sum() == len(at_edge)
    np.testing.assert_allclose(merged.distance, 0.01, atol=1e-14)
    np.testing.assert_allclose(merged.normal_A, [[0, 0, -1]] * len(merged.distance), atol=1e-13)


def test_corner_over_corner():
    """Every facet at one corner with every facet at the other: one row."""
    A, B = _upright_cube(), _upright_cube(0.5)
    X_AB = pose(p=(0.75 + 0.01,) * 3)
    found = witness_pairs(A, B, X_AB, 0.02)
    at_a = np.count_nonzero((A.faces == 7).any(axis=1))
    at_b = np.count_nonzero((B.faces == 0).any(axis=1))
    assert _rows(found) == [((VERTEX, 7), (VERTEX, 0), at_a * at_b)]
    assert found.distance[0] == pytest.approx(0.01 * np.sqrt(3), abs=1e-15)


def test_edge_over_crossed_edge():
    """Two facets at one edge with two at the other: one row of four."""
    ridge = np.array([[-1.0, 0, 0], [1, 0, 0], [0, 1, -1], [0, -1, -1]])
    roof = CollisionMesh(ridge, [[0, 1, 2], [1, 0, 3]])
    turn = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]])
    X_AB = pose(turn, (0.1, 0.2, 0.05))
    found = witness_pairs(roof, roof, X_AB, 0.06)
    edge = np.nonzero((roof.edges == [0, 1]).all(axis=1))[0][0]
    assert _rows(found) == [((EDGE, edge), (EDGE, edge), 4)]
    np.testing.assert_allclose(found.p_ACa[0], [0.1, 0, 0], atol=1e-15)
    np.testing.assert_allclose(found.p_ACb[0], [0.1, 0, 0.05], atol=1e-15)
    np.testing.assert_allclose(found.normal_A[0], [0, 0, -1], atol=1e-13)


def _facets_under(mesh, point):
    """The facets whose inside holds a point."""
    corners = mesh.vertices[mesh.faces]
    off, _, _ = brute.triangle_distances(
        corners, np.broadcast_to(np.array(point, float), corners.shape)
    )
    return np.nonzero(off < 1e-12)[0].tolist()
