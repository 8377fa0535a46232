"""Triangle meshes of the analytic shapes, with their vertices on the true surface.

Every curved mesh is inscribed: no facet lies further inside the true surface than `tolerance` times
the shape's radius (largest semi-axis of an ellipsoid). Facets are wound counter-clockwise seen from
outside. Each function returns vertices (nv, 3) float64 [m], in the geometry's frame, and faces
(nf, 3) int32.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Triangles: TypeAlias = tuple[NDArray[np.float64], NDArray[np.int32]]


def box(size: Sequence[float]) -> Triangles:
    """Return the 12 facets of an axis-aligned box of edge lengths `size` [m], centred."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [facet for a, b, c, d in quads for facet in ((a, b, c), (a, c, d))]
    return corners * np.asarray(size, dtype=float) / 2, np.array(faces, dtype=np.int32)


def half_space(reach: float) -> Triangles:
    """Stand in for the half space z < 0: a tetrahedron, its top one single facet in z = 0.

    One facet, so that no edge of the mesh ever shows in a contact. Its top holds the circle of
    radius `reach` [m] about the origin; its apex lies `reach` below.
    """
    angle = np.radians([90, 210, 330])
    top = 2 * reach * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(3)])
    faces = [(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)]
    return np.vstack([top, [0, 0, -reach]]), np.array(faces, dtype=np.int32)


def ellipsoid(semi_axes: Sequence[float], tolerance: float) -> Triangles:
    """Project a subdivided icosahedron onto the unit sphere and stretch it to the ellipsoid [m]."""
    vertices, faces = _icosahedron()
    # The facets amid a projected face are the largest: circumscribed by an angle of 0.764 / n.
    subdivisions = math.ceil(math.sqrt(0.292 / tolerance))
    vertices, faces = _subdivide(vertices, faces, subdivisions)
    vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    return vertices * np.asarray(semi_axes, dtype=float), faces


def cylinder(radius: float, length: float, tolerance: float) -> Triangles:
    """Return a cylinder about z [m], centred: one ring of quads, caps fanned about their centre."""
    half = length / 2
    return _revolve([0, radius, radius, 0], [-half, -half, half, half], _segments(tolerance))


def capsule(radius: float, length: float, tolerance: float) -> Triangles:
    """Return a cylinder about z of `length` [m] between half spheres of `radius` [m], centred."""
    segments = _segments(tolerance)
    polar = np.linspace(0, np.pi / 2, math.ceil(segments / 4) + 1)
    rise, reach = radius * np.sin(polar), radius * np.cos(polar)
    reach[-1] = 0
    z = np.concatenate([-length / 2 - rise[::-1], length / 2 + rise])
    return _revolve(np.concatenate([reach[::-1], reach]), z, segments)


def _segments(tolerance: float) -> int:
    """Count the chords of a circle whose sagitta is at most `tolerance` radii, a multiple of 4."""
    return 4 * math.ceil(math.pi / math.acos(1 - min(tolerance, 0.5)) / 4)


def _revolve(r: ArrayLike, z: ArrayLike, segments: int) -> Triangles:
    """Revolve a profile about z; it starts and ends on the axis and runs upwards."""
    angle = 2 * np.pi * np.arange(segments) / segments
    circle = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(segments)])
    r, z = np.asarray(r, dtype=float), np.asarray(z, dtype=float)
    rings = [radius * circle + [0, 0, height] for radius, height in zip(r, z, strict=True)][1:-1]
    vertices = np.vstack([[0, 0, z[0]], *rings, [0, 0, z[-1]]])
    this = np.arange(segments)
    following = (this + 1) % segments
    first, top = 1, len(vertices) - 1
    faces = [np.column_stack([0 * this, first + following, first + this])]
    for ring in range(len(rings) - 1):
        low, high = first + ring * segments, first + (ring + 1) * segments
        faces.append(np.column_stack([low + this, low + following, high + following]))
        faces.append(np.column_stack([low + this, high + following, high + this]))
    last = top - segments
    faces.append(np.column_stack([0 * this + top, last + this, last + following]))
    return vertices, np.vstack(faces).astype(np.int32)


def _icosahedron() -> Triangles:
    golden = (1 + math.sqrt(5)) / 2
    corners = [(0.0, a, b) for a in (-1, 1) for b in (-golden, golden)]
    vertices = np.array([np.roll(corner, turn) for corner in corners for turn in range(3)])
    vertices /= math.hypot(1, golden)
    edge = np.min(np.linalg.norm(vertices[1:] - vertices[0], axis=1)) * 1.01
    near = np.linalg.norm(vertices[:, None] - vertices, axis=2) < edge
    faces = []
    for a in range(12):
        for b in range(a + 1, 12):
            for c in range(b + 1, 12):
                if near[a, b] and near[b, c] and near[a, c]:
                    outward = np.linalg.det(vertices[[a, b, c]]) > 0
                    faces.append((a, b, c) if outward else (a, c, b))
    return vertices, np.array(faces, dtype=np.int32)


def _subdivide(vertices: NDArray[np.float64], faces: NDArray[np.int32], n: int) -> Triangles:
    """Cut each facet into n² by a barycentric lattice; facets share the points on their edges."""
    points: dict[tuple[tuple[int, int], ...], int] = {}
    positions: list[NDArray[np.float64]] = []

    def point(corners: Sequence[int], weights: tuple[int, int, int]) -> int:
        # The corners with their weights name a lattice point the same way from either side.
        key = tuple(sorted((c, w) for c, w in zip(corners, weights, strict=True) if w))
        if key not in points:
            points[key] = len(positions)
            positions.append(sum((vertices[c] * w for c, w in key), np.zeros(3)) / n)
        return points[key]

    cut = []
    for corners in faces.tolist():
        rows = [[point(corners, (n - i - j, i, j)) for j in range(n + 1 - i)] for i in range(n + 1)]
        for low, high in pairwise(rows):
            cut += list(zip(low, high, low[1:], strict=False))
            cut += list(zip(high, high[1:], low[1:], strict=False))
    return np.array(positions), np.array(cut, dtype=np.int32)
