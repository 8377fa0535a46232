"""The convex distance of the core, against exact arithmetic and an independent construction."""

import numpy as np
import pytest
from facet_cases import CASES
from oracle_brute_force import triangle_distances
from oracle_triangle import error, squared_distance
from scipy.spatial import ConvexHull

from contact_toolkit import _core

pytestmark = pytest.mark.engine

SEPARATED, OVERLAPPING, BEYOND_BOUND, ITERATION_LIMIT = range(4)


def _gjk(a, b, bound=np.inf):
    return _core.gjk(
        np.ascontiguousarray(a, dtype=np.float64), np.ascontiguousarray(b, dtype=np.float64), bound
    )


def _distance_by_difference(a, b):
    """Distance of the origin from the hull of all differences: another route than GJK's."""
    differences = (a[:, None] - b[None]).reshape(-1, 3)
    hull = ConvexHull(differences)
    if (hull.equations[:, 3] <= 0).all():
        return 0.0
    facets = differences[hull.simplices]
    return float(triangle_distances(facets, np.zeros_like(facets))[0].min())


@pytest.mark.parametrize("cases", CASES, ids=lambda cases: cases.__name__)
def test_triangles_in_exact_arithmetic(cases):
    """A distance off, or a lower bound above the truth, on pairs chosen to break such code."""
    for s, t in cases(np.random.default_rng(0)):
        found = _gjk(s, t)
        truth = squared_distance(s, t)
        size = max(abs(s).max(), abs(t).max())
        assert found["status"] in (SEPARATED, OVERLAPPING)
        assert error(found["distance"], truth) <= 1e-12 * size
        assert found["lower_bound"] <= float(truth) ** 0.5 * (1 + 1e-12) + 1e-15 * size
        np.testing.assert_allclose(
            np.linalg.norm(found["p_A"] - found["p_B"]), found["distance"], atol=1e-15 * size
        )


@pytest.mark.parametrize("seed", range(8))
def test_hulls_of_many_points(seed):
    """Wrong or uncertified distances between polytopes."""
    rng = np.random.default_rng(seed)
    for _ in range(25):
        a = rng.normal(size=(rng.integers(4, 30), 3))
        b = rng.normal(size=(rng.integers(4, 30), 3)) * rng.choice([0.1, 1, 3])
        b += rng.normal(size=3) * rng.choice([0, 1, 5])
        found = _gjk(a, b)
        truth = _distance_by_difference(a, b)
        assert abs(found["distance"] - truth) < 1e-13
        assert truth - 1e-12 < found["lower_bound"] < truth + 1e-13
        if found["status"] == SEPARATED:
            n = found["normal"]
            assert (a @ n).min() - (b @ n).max() == pytest.approx(truth, abs=1e-12)
        else:
            _assert_inside(found["p_A"], a)
            _assert_inside(found["p_A"], b)
            assert (found["p_A"] == found["p_B"]).all()


def _assert_inside(point, points):
    equations = ConvexHull(points).equations
    assert (equations[:, :3] @ point + equations[:, 3]).max() < 1e-12


@pytest.mark.parametrize(
    ("a", "b", "truth"),
    [
        ([[0, 0, 0]], [[3, 4, 0]], 5.0),
        ([[1, 2, 3]], [[1, 2, 3]], 0.0),
        ([[0, 0, 0]] * 5, [[0, 0, 2]] * 4, 2.0),
        ([[-1, 0, 0], [1, 0, 0]], [[0, -1, 1], [0, 1, 1]], 1.0),
        ([[-1, 0, 0], [1, 0, 0]], [[0, -1, 0], [0, 1, 0]], 0.0),
        ([[-1, 0, 0], [1, 0, 0]], [[3, 0, 0], [2, 0, 0]], 1.0),
        ([[-1, -1, 0], [1, -1, 0], [0, 1, 0]], [[0, 0, 0.25]], 0.25),
    ],
    ids=["points", "same", "repeated", "skew", "cross", "collinear", "point over facet"],
)
@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
def test_degenerate_sets(a, b, truth, scale):
    """Points, segments and repeated points trip a simplex solver that expects volume."""
    found = _gjk(scale * np.array(a, float), scale * np.array(b, float))
    assert found["distance"] == pytest.approx(scale * truth, rel=1e-15, abs=1e-15 * scale)


def test_bound():
    """Work wasted on pairs already known to be too far apart; or an answer cut short below it."""
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(20, 3)), rng.normal(loc=(6, 0, 0), size=(20, 3))
    truth = _gjk(a, b)["distance"]
    assert _gjk(a, b, 0.9 * truth)["status"] == BEYOND_BOUND
    assert _gjk(a, b, 1.1 * truth)["distance"] == truth


def test_no_endless_loop():
    """Round shapes of many nearly equal points are where GJK may cycle."""
    rng = np.random.default_rng(0)
    ball = rng.normal(size=(2000, 3))
    ball /= np.linalg.norm(ball, axis=1, keepdims=True)
    for gap in (1e-15, 1e-9, 1e-3, 1.0):
        found = _gjk(ball, ball + np.array([2 + gap, 0, 0]))
        assert found["status"] == SEPARATED
        assert found["iterations"] < 100
