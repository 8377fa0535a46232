"""Cut polygons into triangles: concave ones, ones not quite flat, ones with corners on a line."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Corners = tuple[int, int, int]

_STRAIGHT = 1e-12  # [-] of the squared size: corners turning less than this are on a line


def triangulate(positions: Floats, polygons: Iterable[Sequence[int]]) -> list[Corners]:
    """Cut polygons, each a sequence of indices into `positions` (nv, 3), into triangles.

    In the polygons' order, winding kept, every side of every polygon a side of one triangle, so
    neighbours stay joined. A convex polygon is fanned from its first corner, any other cut along
    the plane it lies in on average (Newell's normal).
    """
    triangles: list[Corners] = []
    for polygon in polygons:
        if len(polygon) == 3:
            triangles.append((polygon[0], polygon[1], polygon[2]))
            continue
        triangles.extend(
            (polygon[i], polygon[j], polygon[k]) for i, j, k in _cut(positions[list(polygon)])
        )
    return triangles


def _cut(corners: Floats) -> list[Corners]:
    count = len(corners)
    fan = [(0, k, k + 1) for k in range(1, count - 1)]
    flat = _flattened(corners)
    if flat is None or _is_convex(flat):
        return fan
    import mapbox_earcut  # noqa: PLC0415  only concave polygons need it

    found = mapbox_earcut.triangulate_float64(flat, np.array([count], np.uint32))
    cut = [(int(i), int(j), int(k)) for i, j, k in found.reshape(-1, 3)]
    whole = _with_all_sides(cut, count) if cut else None
    # A polygon that crosses itself has no inside to cut; its fan keeps its sides at least.
    return fan if whole is None else whole


def _flattened(corners: Floats) -> Floats | None:
    """Return the corners (n, 2) in their plane, counter-clockwise; None where they span none."""
    if not np.isfinite(corners).all():
        return None  # found and named where the mesh is made
    offsets = corners - corners.mean(axis=0)
    size = np.abs(offsets).max()
    if not size > 0:
        return None
    offsets = offsets / size
    normal = np.cross(offsets, np.roll(offsets, -1, axis=0)).sum(axis=0)
    length = np.linalg.norm(normal)
    if not length > _STRAIGHT:
        return None
    normal /= length
    first = np.eye(3)[np.abs(normal).argmin()]
    u = np.cross(first, normal)
    u /= np.linalg.norm(u)
    v = np.cross(normal, u)
    return np.column_stack([offsets @ u, offsets @ v])


def _is_convex(flat: Floats) -> bool:
    sides = np.roll(flat, -1, axis=0) - flat
    after = np.roll(sides, -1, axis=0)
    turns = sides[:, 0] * after[:, 1] - sides[:, 1] * after[:, 0]
    if (turns < -_STRAIGHT).any():
        return False
    if (turns <= _STRAIGHT).any():
        return False  # fanned from a corner on a line, a convex polygon gets facets without area
    angles = np.arctan2(turns, (sides * after).sum(axis=1))
    return bool(angles.sum() < 3 * np.pi)  # once round, not twice


def _with_all_sides(cut: list[Corners], count: int) -> list[Corners] | None:
    """Bring back the corners on a line that the cut has skipped; None where it is no cut at all."""
    triangles = list(cut)
    while len(triangles) < count - 2:
        directed = {
            (t[k], t[(k + 1) % 3]): (n, k) for n, t in enumerate(triangles) for k in range(3)
        }
        skipped = [
            (edge, place)
            for edge, place in directed.items()
            if edge[::-1] not in directed and (edge[1] - edge[0]) % count > 1
        ]
        if not skipped:
            return None
        (start, end), (n, k) = skipped[0]
        apex = triangles[n][(k + 2) % 3]
        chain = [(start + s) % count for s in range((end - start) % count + 1)]
        if apex in chain:
            return None
        triangles[n : n + 1] = [(a, b, apex) for a, b in pairwise(chain)]
    sides = {(t[k], t[(k + 1) % 3]) for t in triangles for k in range(3)}
    complete = all((i, (i + 1) % count) in sides for i in range(count))
    return triangles if complete and len(triangles) == count - 2 else None
