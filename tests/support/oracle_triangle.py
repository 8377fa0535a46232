"""The exact distance between two triangles, in integer arithmetic: the judge of the facet kernels.

Doubles are integers over a power of two, so nothing here rounds. Trusted everywhere, degenerate
triangles included: a segment is a triangle with a repeated corner, a point one with three equal
ones. Half a millisecond a pair.
"""

from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from itertools import product
from math import isqrt, lcm

import numpy as np
from numpy.typing import ArrayLike

Point = tuple[int, int, int]
Triangle = Sequence[Point]


def squared_distance(s: Iterable, t: Iterable) -> Fraction:
    """Least squared distance between triangles `s` and `t`: three points of any real numbers."""
    (s, t), unit = _on_a_grid(s, t)
    return min(_candidates(s, t)) * unit * unit


def squared_swept_distance(s: Sequence, start: Sequence, end: Sequence) -> Fraction:
    """Least squared distance from triangle `s` to one shifted straight from `start` to `end`.

    The shifted triangle fills a prism. Either `s` lies wholly inside, and so does its first corner,
    or the least distance is to the prism's surface.
    """
    start, end = ([[_fraction(x) for x in corner] for corner in t] for t in (start, end))
    (p, *_), (a, b, c), (d, e, f) = s, start, end
    swept_back = [_fraction(x) + y - z for x, y, z in zip(p, a, d, strict=True)]
    if squared_distance([p, swept_back, swept_back], start) == 0:
        return Fraction(0)
    sides = [(a, b, e), (a, e, d), (b, c, f), (b, f, e), (c, a, d), (c, d, f)]
    return min(squared_distance(s, side) for side in (start, end, *sides))


def distance(s: Iterable, t: Iterable) -> float:
    """Least distance between triangles `s` and `t`, correctly rounded but for the last bit."""
    return float(_root(squared_distance(s, t)))


def error(value: float, squared: Fraction) -> float:
    """How far `value` is from the square root of `squared`, whatever the cancellation."""
    return float(abs(_fraction(value) - _root(squared)))


def posed(X_AB: ArrayLike, triangle: ArrayLike) -> list[list[Fraction]]:
    """Corners of a triangle given in B, in A, without rounding."""
    X = [[_fraction(x) for x in row] for row in np.asarray(X_AB)]
    corners = [[_fraction(x) for x in corner] for corner in np.asarray(triangle)]
    return [
        [sum(X[i][k] * corner[k] for k in range(3)) + X[i][3] for i in range(3)]
        for corner in corners
    ]


def _fraction(x: float | np.floating | Fraction) -> Fraction:
    return Fraction(*x.as_integer_ratio())


def _on_a_grid(*triangles: Iterable) -> tuple[list[Triangle], Fraction]:
    """The triangles in integers, and the unit these count."""
    exact = [[[_fraction(x) for x in corner] for corner in triangle] for triangle in triangles]
    scale = lcm(*(x.denominator for triangle in exact for corner in triangle for x in corner))
    grid = [[tuple(int(x * scale) for x in corner) for corner in triangle] for triangle in exact]
    return grid, Fraction(1, scale)


def _root(square: Fraction) -> Fraction:
    """The square root to 100 bits."""
    shift = max(0, 200 - square.numerator.bit_length() + square.denominator.bit_length())
    shift += shift % 2
    return Fraction(isqrt((square.numerator << shift) // square.denominator), 1 << (shift // 2))


def _candidates(s: Triangle, t: Triangle) -> Iterator[Fraction]:
    """Squared distances between points of `s` and `t`, the least among them.

    The closest points lie inside one feature of each triangle, and there the vector between them
    is perpendicular to both features; or the triangles cross, and an edge of one meets the other.
    """
    yield from (Fraction(_dot(d, d)) for d in (_minus(p, q) for p, q in product(set(s), set(t))))
    for points, triangle in ((s, t), (t, s)):
        for p in set(points):
            yield from (r for edge in _edges(triangle) for r in _point_edge(p, *edge))
            yield from _point_facet(p, *triangle)
        for edge in _edges(points):
            yield from _edge_through_facet(*edge, *triangle)
    for edge_s, edge_t in product(_edges(s), _edges(t)):
        yield from _edge_edge(*edge_s, *edge_t)


def _edges(triangle: Triangle) -> list[tuple[Point, Point]]:
    ends = ((triangle[i], triangle[(i + 1) % 3]) for i in range(3))
    return [(a, b) for a, b in ends if a != b]


def _point_edge(p: Point, a: Point, b: Point) -> Iterator[Fraction]:
    u, w = _minus(b, a), _minus(p, a)
    along, length = _dot(w, u), _dot(u, u)
    if 0 < along < length:
        yield Fraction(_dot(w, w) * length - along * along, length)


def _point_facet(p: Point, a: Point, b: Point, c: Point) -> Iterator[Fraction]:
    u, v, w = _minus(b, a), _minus(c, a), _minus(p, a)
    n = _cross(u, v)
    beta, gamma, whole = _dot(_cross(w, v), n), _dot(_cross(u, w), n), _dot(n, n)
    if whole and beta >= 0 and gamma >= 0 and beta + gamma <= whole:
        yield Fraction(_dot(w, n) ** 2, whole)


def _edge_edge(a: Point, b: Point, c: Point, d: Point) -> Iterator[Fraction]:
    u, v, w = _minus(b, a), _minus(d, c), _minus(c, a)
    n = _cross(u, v)
    whole = _dot(n, n)
    if whole and 0 <= _dot(_cross(w, v), n) <= whole and 0 <= _dot(_cross(w, u), n) <= whole:
        yield Fraction(_dot(w, n) ** 2, whole)


def _edge_through_facet(p: Point, q: Point, a: Point, b: Point, c: Point) -> Iterator[Fraction]:
    n = _cross(_minus(b, a), _minus(c, a))
    above, below = _dot(_minus(p, a), n), _dot(_minus(q, a), n)
    if above == below or above * below > 0:
        return
    # Volumes spanned by the line pq and each edge: all of one sign when it passes inside.
    u = _minus(q, p)
    corners = [_minus(x, p) for x in (a, b, c)]
    turns = [_dot(u, _cross(corners[i], corners[(i + 1) % 3])) for i in range(3)]
    if all(turn >= 0 for turn in turns) or all(turn <= 0 for turn in turns):
        yield Fraction(0)


def _minus(a: Point, b: Point) -> Point:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _dot(a: Point, b: Point) -> int:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Point, b: Point) -> Point:
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )
