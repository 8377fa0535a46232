"""Distances between meshes by trying every pair of facets: the judge of the mesh queries.

Vectorised over the pairs, in extended precision (64 bits of mantissa on x86, doubles elsewhere), by
another route than the engine's: points are projected and clamped, so that every candidate is a
distance between two points of the surfaces and the least of them cannot be too small. Facet pairs
whose bounding spheres are further apart than asked for are not tried.

Trusted to 1e-15 of the size of the facets. Not the judge of near-degenerate facets: those belong to
`oracle_triangle`.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.longdouble]
_CHUNK = 20_000  # facet pairs held in memory at once


class Mesh(Protocol):
    """What is asked of a mesh: the tables, nothing derived from them."""

    vertices: NDArray[np.float64]
    faces: NDArray[np.int32]


@dataclass(frozen=True)
class FacetPairs:
    """Facet pairs in ascending order of (facet_a, facet_b), with their closest points in A."""

    facet_a: NDArray[np.intp]
    facet_b: NDArray[np.intp]
    distance: Array
    p_ACa: Array
    p_ACb: Array

    def __len__(self) -> int:
        return len(self.distance)


def facet_pairs(A: Mesh, B: Mesh, X_AB: NDArray[np.float64], standoff: float) -> FacetPairs:
    """Every pair of facets no further apart than `standoff`."""
    S, T = A.vertices[A.faces], _in_a(X_AB, B)
    lower, _ = _bounds(S, T.astype(float))
    near = _closest(S, T, *np.nonzero(lower <= standoff))
    return _rows(near, near.distance <= standoff)


def closest_facet_pair(A: Mesh, B: Mesh, X_AB: NDArray[np.float64]) -> FacetPairs:
    """The closest pair of facets, alone."""
    S, T = A.vertices[A.faces], _in_a(X_AB, B)
    lower, upper = _bounds(S, T.astype(float))
    near = _closest(S, T, *np.nonzero(lower <= upper))
    best = np.argmin(near.distance)
    return _rows(near, slice(best, best + 1))


def signed_distance(A: Mesh, points: NDArray[np.float64]) -> Array:
    """Distance of points (n,3) from a closed surface, negative where it winds around them."""
    S = A.vertices[A.faces].astype(np.longdouble)
    distances = []
    for point in points.astype(np.longdouble):
        d, _, _ = triangle_distances(S, np.broadcast_to(point, S.shape))
        inside = _winding_number(S, point) > 0.5
        distances.append(-d.min() if inside else d.min())
    return np.array(distances)


def triangle_distances(S: Array, T: Array) -> tuple[Array, Array, Array]:
    """Distances (n,) of triangles S and T (n,3,3), with the closest points (n,3) on each."""
    S, T = S.astype(np.longdouble), T.astype(np.longdouble)
    candidates = [
        _edges_edges(S, T),
        _points_facets(S, T),
        _points_facets(T, S)[::-1],
        _edges_facets(S, T),
        _edges_facets(T, S)[::-1],
    ]
    p = np.concatenate([c[0] for c in candidates], axis=1)
    q = np.concatenate([c[1] for c in candidates], axis=1)
    d = _norm(p - q)
    best = np.argmin(d, axis=1)
    row = np.arange(len(S))
    return d[row, best], p[row, best], q[row, best]


def _in_a(X_AB: NDArray[np.float64], B: Mesh) -> Array:
    X = X_AB.astype(np.longdouble)
    return (B.vertices @ X[:3, :3].T + X[:3, 3])[B.faces]


def _bounds(S: NDArray[np.float64], T: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """A lower bound of each pair's distance, and an upper bound of the least."""
    (c, r), (d, q) = (_spheres(S), _spheres(T))
    between = _norm(c[:, None] - d[None, :])
    slack = 1e-9 * (np.abs(S).max() + np.abs(T).max())
    return between - r[:, None] - q[None, :] - slack, float(between.min()) + slack


def _spheres(S: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    centroid = S.mean(axis=1)
    return centroid, _norm(S - centroid[:, None]).max(axis=1)


def _closest(S: Array, T: Array, a: NDArray[np.intp], b: NDArray[np.intp]) -> FacetPairs:
    parts = [
        triangle_distances(S[a[i : i + _CHUNK]], T[b[i : i + _CHUNK]])
        for i in range(0, max(len(a), 1), _CHUNK)
    ]
    d, p, q = (np.concatenate(column) for column in zip(*parts, strict=True))
    return FacetPairs(a, b, d, p, q)


def _rows(pairs: FacetPairs, rows: NDArray[np.bool_] | slice) -> FacetPairs:
    return FacetPairs(*(column[rows] for column in vars(pairs).values()))


def _norm(a: Array) -> Array:
    return np.sqrt((a * a).sum(axis=-1))


def _dot(a: Array, b: Array) -> Array:
    return (a * b).sum(axis=-1)


def _ratio(a: Array, b: Array) -> Array:
    """The ratio a / b held between 0 and 1; 0 where b is."""
    return np.clip(np.divide(a, b, out=np.zeros_like(a), where=b > 0), 0, 1)


def _edges_edges(S: Array, T: Array) -> tuple[Array, Array]:
    """Closest points of the nine pairs of edges, each reached from five starts.

    The starts are both ends of both edges and the foot of the common perpendicular; the point of
    the other edge closest to a start, and the point of the first closest to that, end the pair.
    """
    a, u = S[:, :, None], (np.roll(S, -1, axis=1) - S)[:, :, None]
    c, v = T[:, None, :], (np.roll(T, -1, axis=1) - T)[:, None, :]
    w = c - a
    uu, vv, uv, uw, vw = _dot(u, u), _dot(v, v), _dot(u, v), _dot(u, w), _dot(v, w)
    uu, vv = np.broadcast_arrays(uu, vv)
    points, others = [], []
    for start in (np.zeros_like(uv), np.ones_like(uv), _ratio(uw * vv - vw * uv, uu * vv - uv**2)):
        y = _ratio(start * uv - vw, vv)
        x = _ratio(y * uv + uw, uu)
        points.append(a + x[..., None] * u)
        others.append(c + y[..., None] * v)
    for start in (np.zeros_like(uv), np.ones_like(uv)):
        x = _ratio(start * uv + uw, uu)
        points.append(a + x[..., None] * u)
        others.append(c + start[..., None] * v)
    shape = (len(S), 9 * len(points), 3)
    return np.stack(points, axis=1).reshape(shape), np.stack(others, axis=1).reshape(shape)


def _points_facets(P: Array, T: Array) -> tuple[Array, Array]:
    """The corners of P and the points of facets T below them, drawn into the facets."""
    return P, _drawn_in(P, T)


def _edges_facets(S: Array, T: Array) -> tuple[Array, Array]:
    """Where the edges of S pass the planes of T, and the points of T below."""
    n = np.cross(T[:, 1] - T[:, 0], T[:, 2] - T[:, 0])[:, None]
    u = np.roll(S, -1, axis=1) - S
    above = _dot(S - T[:, :1], n)
    below = np.roll(above, -1, axis=1)
    t = _ratio(np.abs(above), np.abs(above) + np.abs(below))
    p = S + t[..., None] * u
    return p, _drawn_in(p, T)


def _drawn_in(P: Array, T: Array) -> Array:
    """The feet of points P (n,k,3) on the planes of T, those outside drawn to a point inside."""
    a = T[:, :1]
    u, v, w = T[:, 1:2] - a, T[:, 2:] - a, P - a
    n = np.cross(u, v)
    whole = np.broadcast_to(_dot(n, n), P.shape[:2])
    beta = _ratio(_dot(np.cross(w, v), n), whole)
    gamma = _ratio(_dot(np.cross(u, w), n), whole)
    excess = np.maximum(beta + gamma, 1)
    return a + (beta / excess)[..., None] * u + (gamma / excess)[..., None] * v


def _winding_number(S: Array, point: Array) -> float:
    """How often the surface winds around the point (Van Oosterom and Strackee, 1983)."""
    a, b, c = (S[:, i] - point for i in range(3))
    la, lb, lc = _norm(a), _norm(b), _norm(c)
    volume = _dot(a, np.cross(b, c))
    cosine = la * lb * lc + _dot(a, b) * lc + _dot(b, c) * la + _dot(c, a) * lb
    return float(np.arctan2(volume, cosine).sum() / (2 * np.pi))
