"""The same bits from every instruction set: a result must not depend on where it was computed."""

import mesh_shapes
import numpy as np
import pytest
from facet_cases import CASES, apart, crossing, grazing, shared_edge
from poses import random_pose

from contact_toolkit import CollisionMesh, _core, distance, intersects, witness_pairs

pytestmark = pytest.mark.engine

PATHS = ["scalar", "vector", "avx2", "avx512"]


@pytest.fixture(autouse=True)
def _back_to_the_widest():
    widest = _core.simd()
    yield
    _core.select_simd(widest)


def _select(path):
    try:
        _core.select_simd(path)
    except ValueError:
        pytest.skip(f"this processor has no {path}")


def _soup_of(pairs):
    """All first facets in one mesh, all second ones in another."""
    return [
        CollisionMesh(pairs[:, i].reshape(-1, 3), np.arange(3 * len(pairs)).reshape(-1, 3))
        for i in (0, 1)
    ]


def _answers(A, B, X_AB, standoff):
    closest = distance(A, B, X_AB)
    for name in ("distance", "p_ACa", "p_ACb", "normal_A", "facet_a", "facet_b"):
        yield getattr(closest, name)
    yield from (closest.feature_a, closest.feature_b)
    yield intersects(A, B, X_AB)
    for merge in (True, False):
        yield from witness_pairs(A, B, X_AB, standoff, merge=merge).columns().values()


def _assert_same_bits(A, B, X_AB, standoff, path):
    _core.select_simd("scalar")
    expected = list(_answers(A, B, X_AB, standoff))
    _select(path)
    for found, known in zip(_answers(A, B, X_AB, standoff), expected, strict=True):
        np.testing.assert_array_equal(found, known)


@pytest.mark.parametrize("path", PATHS[1:])
@pytest.mark.parametrize("cases", CASES, ids=lambda cases: cases.__name__)
def test_nasty_facets(cases, path):
    """A reordered sum, or a comparison that treats equals otherwise."""
    rng = np.random.default_rng(0)
    A, B = _soup_of(cases(rng)[:40])
    _assert_same_bits(A, B, np.eye(4), A.diagonal / 4, path)
    _assert_same_bits(A, B, random_pose(rng, A.diagonal / 4), A.diagonal / 4, path)


def _near_ties(rng, count=40):
    """Facets, wide to narrow, over a border of others: where one feature takes over from another.

    As near to it as rounding or farther, at any distance, any tilt and any shared direction.
    """
    shift, gap, tilt = 10.0 ** rng.uniform([[-14], [-7], [-10]], [[-1], [0.5], [0]], (3, count))
    pairs = rng.uniform(-1, 1, (count, 2, 3, 3))
    pairs[:, 0, :, 2] = 0
    width = 10.0 ** rng.uniform(-3, 0, (count, 2, 1))
    share = rng.uniform(-1, 2, (count, 2, 1))
    along = share * pairs[:, :, 0] + (1 - share) * pairs[:, :, 1]
    pairs[:, :, 2] = along + width * (pairs[:, :, 2] - along)  # slivers
    pairs[:, 1, :, 2] *= tilt[:, None]
    sides = pairs[::2, 0, 1] - pairs[::2, 0, 0]
    pairs[::2, 1, 1] = pairs[::2, 1, 0] + sides + tilt[::2, None] * rng.normal(size=sides.shape)
    weights = rng.choice([0.0, 0.5, 1.0], (count, 1))
    border = weights * pairs[:, 0, 0] + (1 - weights) * pairs[:, 0, 1]
    over = border + shift[:, None] * rng.normal(size=(count, 3))
    over[:, 2] += gap
    pairs[:, 1] += (over - pairs[:, 1, 0])[:, None]
    pairs[1::4] = pairs[1::4, ::-1]
    return pairs


@pytest.mark.parametrize("path", PATHS[1:])
def test_near_ties(path):
    """A guess of single precision taken for proven where the kernel finds another feature."""
    rng = np.random.default_rng(2)
    for _ in range(40):
        A, B = _soup_of(_near_ties(rng))
        _assert_same_bits(A, B, np.eye(4), 2 * A.diagonal, path)


@pytest.mark.parametrize("path", PATHS[1:])
def test_whole_meshes(path):
    """Batches of every length, and their fill."""
    A = CollisionMesh(*mesh_shapes.doughnut())
    B = CollisionMesh(*mesh_shapes.cone())
    rng = np.random.default_rng(1)
    for _ in range(40):
        X_AB = random_pose(rng, 0.2)
        _assert_same_bits(A, B, X_AB, 10.0 ** rng.uniform(-4, -1.5), path)


def test_unknown_path():
    """A misspelt path must not silently be another."""
    with pytest.raises(ValueError, match=r"sse9.*scalar"):
        _core.select_simd("sse9")


@pytest.mark.parametrize("path", PATHS)
@pytest.mark.parametrize("cases", [apart, crossing, shared_edge, grazing])
def test_alone_or_among_others(cases, path):
    """A pair whose answer depends on which other pairs share its vector."""
    _select(path)
    pairs = cases(np.random.default_rng(0))[:40]
    A, B = _soup_of(pairs)
    together = witness_pairs(A, B, np.eye(4), 2 * A.diagonal, merge=False)
    assert len(together) == len(pairs) ** 2
    singles = [[CollisionMesh(facet, [[0, 1, 2]]) for facet in pairs[:, i]] for i in (0, 1)]
    for row, (a, b) in enumerate(zip(together.facet_a, together.facet_b, strict=True)):
        alone = witness_pairs(singles[0][a], singles[1][b], np.eye(4), 2 * A.diagonal, merge=False)
        assert alone.distance[0] == together.distance[row]
        np.testing.assert_array_equal(alone.p_ACa[0], together.p_ACa[row])
        np.testing.assert_array_equal(alone.p_ACb[0], together.p_ACb[row])
