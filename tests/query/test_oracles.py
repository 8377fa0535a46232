"""The judges judged: two exact methods against each other, brute force against the exact one."""

from fractions import Fraction
from itertools import combinations, product
from types import SimpleNamespace

import mesh_shapes
import numpy as np
import oracle_brute_force as brute
import oracle_triangle as exact
import pytest


def _squared_distance_by_active_sets(s, t):
    """Least squared distance as a quadratic programme in barycentric coordinates.

    The least is attained inside one face of each simplex (corner, edge, facet), where it is the
    unconstrained least over the two affine hulls. Where that is not unique it is attained at
    a smaller face as well, so singular systems need no look.
    """
    s, t = ([[Fraction(x) for x in corner] for corner in triangle] for triangle in (s, t))
    faces = [f for size in (1, 2, 3) for f in combinations(range(3), size)]
    best = None
    for f, g in product(faces, faces):
        d = [_least_of_hulls([s[i] for i in f], [t[i] for i in g])]
        best = min((x for x in (best, *d) if x is not None), default=None)
    return best


def _least_of_hulls(s, t):
    """Least squared distance of two affine hulls if inside both simplices, otherwise None."""
    directions = [_minus(p, s[0]) for p in s[1:]] + [_minus(t[0], q) for q in t[1:]]
    offset = _minus(s[0], t[0])
    x = _solve(
        [[_dot(u, v) for v in directions] for u in directions],
        [-_dot(u, offset) for u in directions],
    )
    if x is None:
        return None
    split = len(s) - 1
    if min(x, default=0) < 0 or sum(x[:split]) > 1 or sum(x[split:]) > 1:
        return None
    least = [
        offset[k] + sum(a * u[k] for a, u in zip(x, directions, strict=True)) for k in range(3)
    ]
    return _dot(least, least)


def _solve(matrix, right):
    """Gaussian elimination in rationals; None for a singular matrix."""
    rows = [[*row, r] for row, r in zip(matrix, right, strict=True)]
    for k in range(len(rows)):
        pivot = next((i for i in range(k, len(rows)) if rows[i][k]), None)
        if pivot is None:
            return None
        rows[k], rows[pivot] = rows[pivot], rows[k]
        for i in range(len(rows)):
            if i != k:
                factor = rows[i][k] / rows[k][k]
                rows[i] = [a - factor * b for a, b in zip(rows[i], rows[k], strict=True)]
    return [row[-1] / row[i] for i, row in enumerate(rows)]


def _minus(p, q):
    return [a - b for a, b in zip(p, q, strict=True)]


def _dot(p, q):
    return sum(a * b for a, b in zip(p, q, strict=True))


def _lattice_triangles(count, span, seed):
    """Triangles of small integers: parallel, coplanar, crossing, touching and degenerate ones."""
    return np.random.default_rng(seed).integers(0, span, (count, 3, 3)).astype(float)


@pytest.mark.parametrize("span", [2, 3, 5, 1000])
def test_closed_forms_agree_with_the_quadratic_programme(span):
    """A missing feature pair or a wrong sign in the exact oracle."""
    pairs = zip(
        _lattice_triangles(60, span, seed=1), _lattice_triangles(60, span, seed=2), strict=True
    )
    for s, t in pairs:
        assert exact.squared_distance(s, t) == _squared_distance_by_active_sets(s, t)


@pytest.mark.parametrize("span", [2, 3, 5, 1000])
def test_brute_force_agrees_with_exact(span):
    """A missing candidate in the brute force: it is the one that judges whole meshes."""
    S, T = (_lattice_triangles(400, span, seed) for seed in (3, 4))
    distances, p, q = brute.triangle_distances(S, T)
    for s, t, d in zip(S, T, distances, strict=True):
        assert exact.error(d, exact.squared_distance(s, t)) < 1e-15 * span
    np.testing.assert_allclose(brute._norm(p - q), distances, rtol=0, atol=0)


def test_brute_force_points_lie_on_the_facets():
    """Candidates that are not points of both surfaces could be too short."""
    S, T = np.random.default_rng(5).uniform(-1, 1, (2, 100, 3, 3))
    _, p, q = brute.triangle_distances(S, T)
    for triangle, point in [*zip(S, p, strict=True), *zip(T, q, strict=True)]:
        assert exact.squared_distance(triangle, [point] * 3) < 1e-34


def test_exact_root_and_error():
    """An error of the oracle's own that hides the engine's."""
    assert exact.error(5.0, Fraction(25)) == 0
    assert exact.error(1.0, Fraction(10**40 + 1, 10**40)) == pytest.approx(5e-41)
    assert exact.distance([[0, 0, 0]] * 3, [[1e-300, 0, 0]] * 3) == 1e-300


def test_exact_pose_is_not_rounded():
    """Posing in doubles would put the engine's own rounding into the judgement."""
    X_AB = np.eye(4)
    X_AB[:3, 3] = 1e-20
    assert exact.posed(X_AB, np.ones((3, 3)))[0][0] == 1 + Fraction(1e-20)


def test_brute_force_signed_distance_of_a_cube():
    """A winding number with the wrong sign."""
    cube = SimpleNamespace(**dict(zip(("vertices", "faces"), mesh_shapes.cube(), strict=True)))
    points = np.array([[0, 0, 0.25], [0, 0, 1], [1.5, 1.5, 0]])
    expected = [-0.25, 0.5, np.sqrt(np.longdouble(2))]
    np.testing.assert_allclose(brute.signed_distance(cube, points), expected, rtol=1e-15)
