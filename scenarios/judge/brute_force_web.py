"""The facet web without the engine: every pair of facets, in plain numpy.

The outside judge of the reproduction: it shares no code with the hierarchy, the kernels, the
merging or the force law in C++. Surfaces must not cross.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FacetWeb:
    """All facet pairs of A and B closer than the standoff, one row each, in the common frame.

    Closest points `p_a`, `p_b` (n, 3) [m] and their distance (n,) [m].
    """

    p_a: Array
    p_b: Array
    distance: Array

    @property
    def direction(self) -> Array:
        """Unit vectors (n, 3) from B towards A."""
        return (self.p_a - self.p_b) / self.distance[:, None]

    def energy(self, k: float, standoff: float, n: float = 1.0) -> float:
        """Return the energy [J] stored in springs of force k δⁿ [N], one a row."""
        return float(k / (n + 1) * ((standoff - self.distance) ** (n + 1)).sum())

    def lift(self, k: float, standoff: float, n: float = 1.0) -> float:
        """Return the upward force [N] on A of springs of force k δⁿ [N], one a row."""
        return float(k * ((standoff - self.distance) ** n * self.direction[:, 2]).sum())

    def merged(self) -> FacetWeb:
        """Return the web without the rows whose two points repeat, to a nanometre, another's."""
        points = np.round(np.hstack([self.p_a, self.p_b]), 9)
        first = np.unique(points, axis=0, return_index=True)[1]
        return FacetWeb(self.p_a[first], self.p_b[first], self.distance[first])


def facet_web(triangles_a: Array, triangles_b: Array, standoff: float) -> FacetWeb:
    """Return the web between triangles (na, 3, 3) and (nb, 3, 3) [m], in a common frame.

    Pairs whose bounding boxes are farther apart than the standoff are passed over, no others.
    """
    index_a, index_b = _near(triangles_a, triangles_b, standoff)
    p_a, p_b = closest_points(triangles_a[index_a], triangles_b[index_b])
    distance = np.linalg.norm(p_a - p_b, axis=1)
    keep = distance < standoff
    return FacetWeb(p_a[keep], p_b[keep], distance[keep])


def closest_points(a: Array, b: Array) -> tuple[Array, Array]:
    """Return the closest points (n, 3) of triangles a and b (n, 3, 3), row by row."""
    candidates = [_edge_edge(a, b, i, j) for i in range(3) for j in range(3)]
    candidates += [_vertex_face(a[:, i], b) for i in range(3)]
    candidates += [_vertex_face(b[:, i], a)[::-1] for i in range(3)]
    p_a = np.stack([pair[0] for pair in candidates])
    p_b = np.stack([pair[1] for pair in candidates])
    squared = np.square(p_a - p_b).sum(axis=-1)
    best = np.nanargmin(squared, axis=0)
    rows = np.arange(len(a))
    return p_a[best, rows], p_b[best, rows]


def equilibrium_height(
    web_at: Callable[[float], FacetWeb],
    weight: float,
    k: float,
    standoff: float,
    start: float,
    n: float = 1.0,
) -> float:
    """Return the height z [m] at which the springs carry the weight [N], to a nanometre.

    `web_at(z)` is the web of the body A at height z; a spring of force k δⁿ stands for each row.
    From `start` the search follows the net force, so what it finds is the stable rest nearest that
    way.
    """

    def surplus(z: float) -> float:
        return web_at(z).lift(k, standoff, n) - weight

    step = standoff / 8
    up = surplus(start) > 0.0
    for i in range(1, 1024):
        z = start + (i if up else -i) * step
        if (surplus(z) > 0.0) != up:
            return float(brentq(surplus, z, z + (-step if up else step), xtol=1e-9))
    raise ValueError(f"no equilibrium within {1023 * step} m of z = {start} m")


def _near(a: Array, b: Array, standoff: float) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the index pairs whose bounding boxes are within the standoff."""
    low_a, high_a = a.min(axis=1) - standoff, a.max(axis=1) + standoff
    low_b, high_b = b.min(axis=1), b.max(axis=1)
    in_b = np.all((low_b <= high_a.max(axis=0)) & (high_b >= low_a.min(axis=0)), axis=1)
    chosen = np.flatnonzero(in_b)
    low_b, high_b = low_b[chosen], high_b[chosen]
    rows = []
    for block in np.array_split(np.arange(len(a)), max(1, len(a) // 256)):
        overlap = np.ones((len(block), len(chosen)), dtype=bool)
        for axis in range(3):
            overlap &= low_a[block, axis, None] <= high_b[None, :, axis]
            overlap &= high_a[block, axis, None] >= low_b[None, :, axis]
        first, second = np.nonzero(overlap)
        rows.append((block[first], chosen[second]))
    return np.concatenate([r[0] for r in rows]), np.concatenate([r[1] for r in rows])


def _edge_edge(a: Array, b: Array, i: int, j: int) -> tuple[Array, Array]:
    """Closest points of edge i of a and edge j of b, ends included."""
    p, u = a[:, i], a[:, (i + 1) % 3] - a[:, i]
    q, v = b[:, j], b[:, (j + 1) % 3] - b[:, j]
    w = p - q
    uu, uv, vv = _dot(u, u), _dot(u, v), _dot(v, v)
    uw, vw = _dot(u, w), _dot(v, w)
    determinant = uu * vv - uv * uv
    crossing = determinant > 1e-12 * uu * vv  # parallel edges: any point will do to start from
    s = np.divide(uv * vw - vv * uw, determinant, out=np.zeros_like(uu), where=crossing)
    t = np.clip((uv * np.clip(s, 0.0, 1.0) + vw) / vv, 0.0, 1.0)
    s = np.clip((uv * t - uw) / uu, 0.0, 1.0)
    return p + s[:, None] * u, q + t[:, None] * v


def _vertex_face(p: Array, triangle: Array) -> tuple[Array, Array]:
    """Points p and their projections inside the triangles; NaN where they fall outside."""
    origin = triangle[:, 0]
    u, v, w = triangle[:, 1] - origin, triangle[:, 2] - origin, p - origin
    uu, uv, vv = _dot(u, u), _dot(u, v), _dot(v, v)
    uw, vw = _dot(u, w), _dot(v, w)
    determinant = uu * vv - uv * uv
    s, t = (vv * uw - uv * vw) / determinant, (uu * vw - uv * uw) / determinant
    inside = (s >= 0.0) & (t >= 0.0) & (s + t <= 1.0)
    foot = origin + s[:, None] * u + t[:, None] * v
    return p, np.where(inside[:, None], foot, np.nan)


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("ij,ij->i", a, b))
