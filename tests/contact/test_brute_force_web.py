"""The brute-force web, judge of the reproduction: right on cases with closed forms."""

import numpy as np
import pytest

from contact_toolkit import CollisionMesh, witness_pairs
from scenarios.judge.brute_force_web import closest_points, equilibrium_height, facet_web
from scenarios.parts import doughnut, truncated_cone

FLAT = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])


def apart(a, b):
    p_a, p_b = closest_points(np.array([a], dtype=float), np.array([b], dtype=float))
    return np.linalg.norm(p_a - p_b)


@pytest.mark.parametrize(
    ("other", "distance"),
    [
        (FLAT + np.array([0.0, 0, 0.3]), 0.3),  # parallel, overlapping
        ([[0.2, 0.2, 0.1], [0, 0, 1], [1, 1, 1]], 0.1),  # vertex over facet
        ([[-0.1, -1, 0.2], [-0.1, 1, 0.2], [-2, 0, 0.2]], np.hypot(0.1, 0.2)),  # edge by vertex
        ([[0.5, -0.3, -1], [0.5, -0.3, 1], [0.5, -2, 0]], 0.3),  # edge by edge, crosswise
        (FLAT + np.array([3.0, 0, 0]), 2.0),  # vertex by vertex
        (FLAT * [1, -1, 1] - [0.0, 0.4, 0], 0.4),  # parallel edges
    ],
)
def test_triangle_distances_are_exact(other, distance):
    assert apart(FLAT, other) == pytest.approx(distance, rel=1e-14)
    assert apart(other, FLAT) == pytest.approx(distance, rel=1e-14)


def test_brute_force_and_engine_find_the_same_web():
    # Two programs that share no code: same pairs, same springs after merging, same distances.
    a, b, X_AB = truncated_cone(), doughnut(), np.eye(4)
    X_AB[:3, 3] = [0.0004, 0.0002, 0.1765]
    standoff = 0.0015
    web = facet_web((b[0] + X_AB[:3, 3])[b[1]], a[0][a[1]], standoff)
    found = witness_pairs(CollisionMesh(*a), CollisionMesh(*b), X_AB, standoff)
    assert len(web.distance) == found.multiplicity.sum() > 3000
    each = np.repeat(found.distance, found.multiplicity)
    np.testing.assert_allclose(np.sort(web.distance), np.sort(each), rtol=0, atol=1e-15)
    assert len(web.merged().distance) == len(found)


def test_equilibrium_of_one_spring_is_where_it_carries_the_weight():
    # A facet over a parallel one: deformation = weight / k below the standoff.
    def web_at(z):
        return facet_web(FLAT[None] + [0, 0, z], FLAT[None] * 2.0 - [0.5, 0.5, 0], 0.01)

    for start in (0.001, 0.02):
        height = equilibrium_height(web_at, weight=0.3, k=100.0, standoff=0.01, start=start)
        assert height == pytest.approx(0.01 - 0.003, abs=2e-9)
    with pytest.raises(ValueError, match="no equilibrium"):
        equilibrium_height(web_at, weight=-1.0, k=100.0, standoff=0.01, start=0.005)
