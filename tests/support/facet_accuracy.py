"""Worst errors of the queries on two single facets, judged in rational arithmetic."""

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np
import oracle_triangle as exact
from facet_cases import Pairs
from numpy.typing import NDArray
from poses import pose, random_rotation

from contact_toolkit import (
    CollisionMesh,
    distance,
    signed_distance,
    swept_distance,
    witness_pairs,
)

Array = NDArray[np.float64]


class Answer(NamedTuple):
    """What a query says of two facets in A: their distance and the closest points.

    Beside it the facets that these points belong to, and the exact squared distance.
    """

    distance: float
    p_ACa: Array
    p_ACb: Array
    facet_a: Sequence
    facet_b: Sequence
    exact_squared: Fraction


class Errors(NamedTuple):
    """How wrong an answer is, as shares of the coordinates' size.

    Attributes
    ----------
    distance
        Reported against exact distance.
    off_facet
        Exact distance of a closest point from its own facet.
    gap
        Distance between the closest points against the reported one: where facets cross, how far
        apart the two points are that should coincide.
    """

    distance: float
    off_facet: float
    gap: float


def ask_distance(s: Array, t: Array, X_AB: Array, _reach: float) -> Iterator[Answer]:
    found, t_in_a = distance(_mesh(s), _mesh(t), X_AB), exact.posed(X_AB, t)
    squared = exact.squared_distance(s, t_in_a)
    yield Answer(found.distance, found.p_ACa, found.p_ACb, s, t_in_a, squared)


def ask_witness_pairs(s: Array, t: Array, X_AB: Array, reach: float) -> Iterator[Answer]:
    found, t_in_a = witness_pairs(_mesh(s), _mesh(t), X_AB, reach), exact.posed(X_AB, t)
    (row,) = zip(found.distance, found.p_ACa, found.p_ACb, strict=True)
    yield Answer(*row, s, t_in_a, exact.squared_distance(s, t_in_a))


def ask_signed_distance(s: Array, t: Array, X_AB: Array, _reach: float) -> Iterator[Answer]:
    """A corner and the middle of `t` as points; `s` a facet of a solid as long as itself."""
    solid = _solid_under(s)
    assert solid.solid.has_inside
    facets = solid.vertices[solid.faces]
    points = np.vstack([t[0], t.mean(axis=0)]) @ X_AB[:3, :3].T + X_AB[:3, 3]
    found = signed_distance(solid, points)
    for d, foot, point in zip(found.distance, found.p_ACa, points, strict=True):
        squared = min(exact.squared_distance(facet, [point] * 3) for facet in facets)
        nearest = min(facets, key=lambda facet: exact.squared_distance(facet, [foot] * 3))
        yield Answer(abs(d), foot, point, nearest, [point] * 3, squared)


def ask_swept_distance(s: Array, t: Array, X_AB: Array, _reach: float) -> Iterator[Answer]:
    """`t` moved along its own first edge, and half-way to the middle of `s`."""
    t_in_a = t @ X_AB[:3, :3].T + X_AB[:3, 3]
    for shift in (t_in_a[1] - t_in_a[0], (s.mean(axis=0) - t_in_a.mean(axis=0)) / 2):
        X_end = pose(X_AB[:3, :3], tuple(X_AB[:3, 3] + shift))
        found = swept_distance(_mesh(s), _mesh(t), X_AB, X_end)
        start, end = exact.posed(X_AB, t), exact.posed(X_end, t)
        then = [
            [a + Fraction(found.time) * (b - a) for a, b in zip(*corners, strict=True)]
            for corners in zip(start, end, strict=True)
        ]
        squared = exact.squared_swept_distance(s, start, end)
        yield Answer(found.distance, found.p_ACa, found.p_ACb, s, then, squared)


Query = Callable[[Array, Array, Array, float], Iterator[Answer]]
QUERIES: dict[str, Query] = {
    "distance": ask_distance,
    "witness_pairs": ask_witness_pairs,
    "signed_distance": ask_signed_distance,
    "swept_distance": ask_swept_distance,
}


def worst_errors(query: Query, pairs: Pairs, rng: np.random.Generator) -> Errors:
    """Ask for each pair as given, and with the second facet in a frame of its own."""
    found = [
        error
        for s, t in pairs
        for case in _in_two_frames(s, t, rng)
        for error in errors(query, *case)
    ]
    return Errors(*np.max(found, axis=0).tolist())


def errors(query: Query, s: Array, t: Array, X_AB: Array) -> Iterator[Errors]:
    """The errors of every answer to one case."""
    size = max(np.abs(s).max(), np.abs(t).max(), np.abs(X_AB[:3, 3]).max())
    reach = exact.distance(s, exact.posed(X_AB, t)) + 0.01 * size
    for found in query(s, t, X_AB, reach):
        a, b = [found.p_ACa] * 3, [found.p_ACb] * 3
        yield Errors(
            exact.error(found.distance, found.exact_squared) / size,
            max(exact.distance(a, found.facet_a), exact.distance(b, found.facet_b)) / size,
            exact.error(found.distance, exact.squared_distance(a, b)) / size,
        )


def _mesh(corners: Array) -> CollisionMesh:
    return CollisionMesh(corners, [[0, 1, 2]])


def _solid_under(corners: Array) -> CollisionMesh:
    """Close a facet, were it without area, by two more vertices behind its longest edge c-a."""
    lengths = [np.linalg.norm(corners[k - 1] - corners[k]) for k in range(3)]
    longest = int(np.argmax(lengths))
    a, b, c = np.roll(corners, -longest, axis=0)
    size = lengths[longest]
    u = (c - a) / size
    v = (b - a) / size
    if np.linalg.norm(np.cross(u, v)) < 1e-12:
        v = np.eye(3)[np.argmin(np.abs(u))]  # any way across
    v = np.cross(np.cross(u, v), u)
    v /= np.linalg.norm(v)
    back = (a + c) / 2 - size * np.cross(v, u)
    p, q = back + size * v, back - size * v
    faces = [[0, 1, 2], [1, 0, 3], [2, 1, 3], [0, 2, 4], [2, 3, 4], [3, 0, 4]]
    return CollisionMesh(np.array([a, b, c, p, q]), faces)


def _in_two_frames(s: Array, t: Array, rng: np.random.Generator) -> Iterator[tuple[Array, ...]]:
    """The facets in A and in B, and X_AB."""
    yield s, t, np.eye(4)
    X_AB = pose(random_rotation(rng), tuple(rng.uniform(-1, 1, 3) * np.abs(t).max()))
    yield s, (t - X_AB[:3, 3]) @ X_AB[:3, :3], X_AB
