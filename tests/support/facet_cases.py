"""Triangle pairs that break distance code, by class: what the accuracy table is measured on.

Every class is a function of a random generator that returns (n,2,3,3) coordinates. The wilful ones
are built exactly (small integers, powers of two) and then disturbed by a few roundings, since both
the exact contact and its neighbours have to come out right.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from published_cases import PUBLISHED

Pairs = NDArray[np.float64]
Rng = np.random.Generator

WELL_POSED = 1e-12  # worst error allowed, as a share of the coordinates' size
NEAR_DEGENERATE = 1e-9
_COUNT = 120


def apart(rng: Rng) -> Pairs:
    pairs = rng.uniform(-1, 1, (_COUNT, 2, 3, 3))
    pairs[:, 1] += rng.uniform(1, 3, (_COUNT, 1, 3))
    return pairs


def crossing(rng: Rng) -> Pairs:
    """An edge of the second through the inside of the first."""
    pairs = rng.uniform(-1, 1, (_COUNT, 2, 3, 3))
    weights = rng.dirichlet([2, 2, 2], _COUNT)
    inside = np.einsum("nk,nki->ni", weights, pairs[:, 0])
    pairs[:, 1, 1] = pairs[:, 1, 0] + rng.uniform(1.2, 4, (_COUNT, 1)) * (inside - pairs[:, 1, 0])
    return pairs


def near_parallel_edges(rng: Rng) -> Pairs:
    """Two edges side by side, out of parallel by 1e-3 to 1e-17, the facets hanging off outwards."""
    tilt = 10.0 ** rng.uniform(-17, -3, _COUNT) * rng.choice([-1, 1], _COUNT)
    gap = 10.0 ** rng.uniform(-9, 0, _COUNT)
    shift = rng.uniform(-1.5, 1.5, _COUNT)
    pairs = np.zeros((_COUNT, 2, 3, 3))
    pairs[:, 0] = [[-1, 0, 0], [1, 0, 0], [0.2, -1, -0.3]]
    pairs[:, 1, 0] = np.stack([shift - 1, gap - tilt, 0 * tilt], axis=1)
    pairs[:, 1, 1] = np.stack([shift + 1, gap + tilt, tilt], axis=1)
    pairs[:, 1, 2] = np.stack([shift, gap + 1, 0 * tilt + 0.4], axis=1)
    return _turned(pairs, rng)


def parallel_facets(rng: Rng) -> Pairs:
    """One facet over another, their planes parallel: a whole region of closest points."""
    pairs = rng.uniform(-1, 1, (_COUNT, 2, 3, 3))
    pairs[:, 0, :, 2] = 0
    pairs[:, 1, :, 2] = 10.0 ** rng.uniform(-12, 0, (_COUNT, 1))
    return _half_turned(pairs, rng)


def coplanar(rng: Rng) -> Pairs:
    """Both facets in one plane, overlapping or not."""
    pairs = rng.integers(-4, 5, (_COUNT, 2, 3, 3)).astype(float)
    pairs[..., 2] = 0
    return _half_turned(pairs, rng)


def needles(rng: Rng) -> Pairs:
    """Facets a million to a trillion times longer than wide, at any distance or crossing."""
    pairs = rng.uniform(-1, 1, (_COUNT, 2, 3, 3))
    width = 10.0 ** rng.uniform(-12, -6, (_COUNT, 2, 1))
    along = rng.uniform(0, 1, (_COUNT, 2, 1))
    pairs[:, :, 2] = (1 - along) * pairs[:, :, 0] + along * pairs[:, :, 1] + width * pairs[:, :, 2]
    middles = pairs[::2].mean(axis=2)
    pairs[::2, 1] += (middles[:, 0] - middles[:, 1])[:, None]
    return pairs


def slivers(rng: Rng) -> Pairs:
    """Facets of area 1e-13, the long sides pointing at each other or side by side."""
    pairs = rng.uniform(-1, 1, (_COUNT, 2, 3, 3))
    pairs[::2, 1, :2] = pairs[::2, 0, :2] + 10.0 ** rng.uniform(-9, -1, (len(pairs[::2]), 1, 1))
    base = pairs[:, :, 1] - pairs[:, :, 0]
    across = np.cross(base, pairs[:, :, 2])
    across /= np.linalg.norm(across, axis=-1, keepdims=True)
    height = 2e-13 / np.linalg.norm(base, axis=-1, keepdims=True)
    along = rng.uniform(-0.2, 1.2, (_COUNT, 2, 1))
    pairs[:, :, 2] = pairs[:, :, 0] + along * base + height * across
    return pairs


def zero_area(rng: Rng) -> Pairs:
    """Repeated corners and three corners on a line, against each other and whole facets."""
    pairs = rng.integers(-4, 5, (_COUNT, 2, 3, 3)).astype(float)
    pairs[::2, 0, 2] = pairs[::2, 0, 1]
    pairs[1::4, 1, 2] = 2 * pairs[1::4, 1, 1] - pairs[1::4, 1, 0]
    pairs[1::3, 1, 0] = pairs[1::3, 1, 2]
    return pairs[_extent(pairs).min(axis=1) > 0]


def t_contacts(rng: Rng) -> Pairs:
    """Walls that meet in a T at coordinates of 8e3, and miss by a few roundings."""
    pairs = np.empty((_COUNT, 2, 3, 3))
    x, y, z = rng.uniform(-8e3, 8e3, (3, _COUNT))
    length, height = rng.uniform(100, 500, (2, _COUNT))
    pairs[:, 0] = np.stack([x, y, z] * 3, axis=1).reshape(-1, 3, 3)
    pairs[:, 1] = pairs[:, 0]
    pairs[:, 0, 1:, 0] -= length[:, None]
    pairs[:, 0, 2, 1] += height
    pairs[:, 1, 0, 2] -= height
    pairs[:, 1, 1, 2] -= height
    pairs[:, 1, 2, 2] += height
    pairs[:, 1, 1:, 0] -= length[:, None]
    return _disturbed(pairs, rng)


def vertex_on_facet(rng: Rng) -> Pairs:
    """A corner exactly inside the other facet, or a few roundings from it."""
    pairs = rng.integers(-8, 9, (_COUNT, 2, 3, 3)).astype(float)
    weights = rng.multinomial(4, [1 / 3] * 3, _COUNT) / 4
    pairs[:, 1, 0] = np.einsum("nk,nki->ni", weights, pairs[:, 0])
    return _disturbed(pairs, rng)


def edge_on_edge(rng: Rng) -> Pairs:
    """Two edges that meet exactly at their middles, or nearly."""
    pairs = rng.integers(-8, 9, (_COUNT, 2, 3, 3)).astype(float)
    pairs[:, 1, 1] = pairs[:, 0, 0] + pairs[:, 0, 1] - pairs[:, 1, 0]
    return _disturbed(pairs, rng)


def shared_edge(rng: Rng) -> Pairs:
    """Neighbours in a mesh: the same edge, or the same corner."""
    pairs = rng.uniform(-1, 1, (_COUNT, 2, 3, 3))
    pairs[::2, 1, :2] = pairs[::2, 0, :2]
    pairs[1::2, 1, 0] = pairs[1::2, 0, 2]
    return _disturbed(pairs, rng)


def grazing(rng: Rng) -> Pairs:
    """Planes 1e-3 to 1e-15 out of parallel, crossing somewhere along the facets or just not."""
    pairs = rng.uniform(-1, 1, (_COUNT, 2, 3, 3))
    pairs[:, 0, :, 2] = 0
    pairs[:, 1, :, 2] *= 10.0 ** rng.uniform(-15, -3, (_COUNT, 1))
    return _half_turned(pairs, rng)


def tiny_by_huge(rng: Rng) -> Pairs:
    """A facet a million times smaller than its partner, above, inside or beside it."""
    pairs = rng.uniform(-1, 1, (_COUNT, 2, 3, 3))
    weights = rng.dirichlet([1, 1, 1], _COUNT)
    centre = np.einsum("nk,nki->ni", weights, pairs[:, 0])
    pairs[:, 1] = centre[:, None] + 1e-6 * pairs[:, 1] + 1e-6 * rng.normal(size=(_COUNT, 1, 3))
    return pairs


def far_away(rng: Rng) -> Pairs:
    """Small facets a million sizes from the origin, near each other."""
    return rng.uniform(-1, 1, (_COUNT, 2, 3, 3)) + rng.uniform(-1e6, 1e6, (_COUNT, 1, 1, 3))


def published(_rng: Rng) -> Pairs:
    """See `published_cases`."""
    return np.array([*PUBLISHED.values()])


CASES: dict[Callable[[Rng], Pairs], float] = {
    apart: WELL_POSED,
    crossing: WELL_POSED,
    near_parallel_edges: WELL_POSED,
    parallel_facets: WELL_POSED,
    coplanar: WELL_POSED,
    t_contacts: WELL_POSED,
    vertex_on_facet: WELL_POSED,
    edge_on_edge: WELL_POSED,
    shared_edge: WELL_POSED,
    grazing: WELL_POSED,
    tiny_by_huge: WELL_POSED,
    far_away: WELL_POSED,
    needles: NEAR_DEGENERATE,
    slivers: NEAR_DEGENERATE,
    zero_area: NEAR_DEGENERATE,
    published: WELL_POSED,
}


def _extent(pairs: Pairs) -> Pairs:
    return np.ptp(pairs, axis=2).max(axis=-1)


def _turned(pairs: Pairs, rng: Rng) -> Pairs:
    """Each pair turned at random, so that nothing is aligned with the axes."""
    turns, _ = np.linalg.qr(rng.normal(size=(len(pairs), 3, 3)))
    return np.einsum("nij,nabj->nabi", turns, pairs)


def _half_turned(pairs: Pairs, rng: Rng) -> Pairs:
    return np.concatenate([pairs[::2], _turned(pairs[1::2], rng)])


def _disturbed(pairs: Pairs, rng: Rng) -> Pairs:
    """A third as they are, a third moved by single roundings, a third turned and so rounded."""
    pairs = pairs[_extent(pairs).min(axis=1) > 0]
    third = len(pairs) // 3
    steps = rng.integers(-2, 3, pairs[:third].shape)
    rounded = pairs[:third] + steps * np.spacing(np.abs(pairs[:third]))
    return np.concatenate([rounded, _turned(pairs[third : 2 * third], rng), pairs[2 * third :]])
