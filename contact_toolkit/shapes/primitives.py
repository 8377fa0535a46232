"""Triangle meshes of the analytic shapes, with their vertices on the true surface.

Every curved mesh is inscribed: no facet lies further inside the true surface than `tolerance` times
the shape's radius (largest semi-axis of an ellipsoid). Facets are wound counter-clockwise seen from
outside. Each function returns vertices (nv, 3) float64 [m], in the geometry's frame, and faces
(nf, 3) int32.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Triangles: TypeAlias = tuple[NDArray[np.float64], NDArray[np.int32]]

_GOLDEN = (1 + np.sqrt(5)) / 2
_CORNERS = np.array(
    [(-1, _GOLDEN), (1, _GOLDEN), (-1, -_GOLDEN), (1, -_GOLDEN)], dtype=np.float64
) / np.hypot(1, _GOLDEN)
_ICOSAHEDRON = np.concatenate(
    [np.roll(np.column_stack([_CORNERS, np.zeros(4)]), axis, axis=1) for axis in range(3)]
)
_TRIANGLES = np.array(
    [
        (0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11),
        (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8),
        (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9),
        (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1),
    ]
)  # fmt: skip


@dataclass(frozen=True)
class Primitive:
    """A shape whose signed distance has a closed form, in its own frame.

    Attributes
    ----------
    kind, size
        "sphere": radius [m]; "capsule", "cylinder": radius and length [m] about z; "box": its three
        edge lengths [m]; "half_space" z < 0: the radius [m] about the origin within which a mesh
        stands for it.
    """

    kind: Literal["sphere", "capsule", "cylinder", "box", "half_space"]
    size: tuple[float, ...]

    def __post_init__(self) -> None:
        count = {"sphere": 1, "capsule": 2, "cylinder": 2, "box": 3, "half_space": 1}
        if self.kind not in count:
            raise ValueError(f"kind must be one of {list(count)}, not {self.kind!r}")
        size = tuple(float(x) for x in self.size)
        if len(size) != count[self.kind] or not all(0 < x < math.inf for x in size):
            raise ValueError(
                f"a {self.kind} has {count[self.kind]} positive lengths [m], not {self.size}"
            )
        object.__setattr__(self, "size", size)

    def triangles(self, tolerance: float) -> Triangles:
        """Tessellate it; see the functions of this module."""
        match self.kind:
            case "sphere":
                return ellipsoid(self.size * 3, tolerance)
            case "capsule":
                radius, length = self.size
                return capsule(radius, length, tolerance)
            case "cylinder":
                radius, length = self.size
                return cylinder(radius, length, tolerance)
            case "box":
                return box(self.size)
            case "half_space":
                return half_space(*self.size)


def box(size: Sequence[float], divisions: int = 1) -> Triangles:
    """Return an axis-aligned box of edge lengths `size` [m], centred.

    Each side is cut in `divisions` × `divisions` cells of two facets.
    """
    n = divisions
    v, u = np.mgrid[: n + 1, : n + 1]
    sides = [  # lattice points of the +z and -z side; the other axes follow by cyclic exchange
        np.roll(np.stack(side, axis=-1), axis, axis=-1)
        for axis in range(3)
        for side in ((u, v, 0 * u + n), (n - u, v, 0 * u))
    ]
    lattice, index = np.unique(np.reshape(sides, (-1, 3)), axis=0, return_inverse=True)
    ids = index.reshape(6, n + 1, n + 1)
    low, right, high, left = ids[:, :-1, :-1], ids[:, :-1, 1:], ids[:, 1:, 1:], ids[:, 1:, :-1]
    faces = np.stack([low, right, high, low, high, left], axis=-1).reshape(-1, 3)
    return (lattice / n - 0.5) * np.asarray(size, dtype=float), faces.astype(np.int32)


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
    """Stretch an icosphere to the ellipsoid of these semi-axes [m]."""
    # The facets amid a side of the icosahedron are the largest: within an angle of 0.764 / n.
    vertices, faces = icosphere(math.ceil(math.sqrt(0.292 / tolerance)))
    return vertices * np.asarray(semi_axes, dtype=float), faces


def icosphere(frequency: int, radius: float = 1.0) -> Triangles:
    """Cut each edge of an icosahedron in `frequency` parts and put all on the sphere.

    20 frequency² facets of nearly equal size, 10 frequency² + 2 vertices.
    """
    row, column = np.tril_indices(frequency + 1)
    weights = np.column_stack([frequency - row, row - column, column])  # barycentric, × frequency
    # A point shared by two triangles has the same corner weights in both: their sum, each times
    # the corner's own random 64-bit number, identifies it without comparing coordinates.
    tag = np.random.default_rng(0).integers(2**63, size=12, dtype=np.uint64)
    with np.errstate(over="ignore"):
        keys = tag[_TRIANGLES] @ weights.T.astype(np.uint64)
    _, first, index = np.unique(keys.reshape(-1), return_index=True, return_inverse=True)
    assert len(first) == 10 * frequency**2 + 2
    # Numbered as the triangles meet them: neighbours stay together, as in meshes from elsewhere.
    order = np.argsort(first)
    first, index = first[order], np.argsort(order)[index]
    points = np.einsum("wc,tcx->twx", weights / frequency, _ICOSAHEDRON[_TRIANGLES])
    points = points.reshape(-1, 3)[first]
    vertices = radius * points / np.linalg.norm(points, axis=1, keepdims=True)

    def at(row: NDArray[np.int64], column: NDArray[np.int64]) -> NDArray[np.int64]:
        return row * (row + 1) // 2 + column

    row, column = np.tril_indices(frequency)
    up = np.column_stack([at(row, column), at(row + 1, column), at(row + 1, column + 1)])
    row, column = row[row > column], column[row > column]
    down = np.column_stack([at(row, column), at(row + 1, column + 1), at(row, column + 1)])
    faces = index.reshape(20, -1)[:, np.concatenate([up, down])].reshape(-1, 3)
    return vertices, faces.astype(np.int32)


def cylinder(radius: float, length: float, tolerance: float) -> Triangles:
    """Return a cylinder about z [m], centred: one ring of quads, caps fanned about their centre."""
    half = length / 2
    return _revolve([0, radius, radius, 0], [-half, -half, half, half], _segments(tolerance))


def capsule(radius: float, length: float, tolerance: float) -> Triangles:
    """Return a cylinder about z of `length` [m] between half spheres of `radius` [m], centred."""
    segments = _segments(tolerance)
    return capsule_of_rings(radius, length, segments, segments // 4)


def capsule_of_rings(radius: float, length: float, segments: int, rings: int) -> Triangles:
    """Return the same with `segments` facets around, and `rings` along each half sphere."""
    polar = np.linspace(0, np.pi / 2, rings + 1)
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
