"""How every part is built: rows of points, strips of facets between them.

A surface is `(vertices, faces)`: float64 (n, 3) [m] and int32 (m, 3), closed and wound so that the
normals (right-hand rule) point out of the material.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Vertices: TypeAlias = NDArray[np.float64]
Faces: TypeAlias = NDArray[np.int32]
Surface: TypeAlias = tuple[Vertices, Faces]


def require(condition: bool, complaint: str) -> None:
    """Raise ValueError(complaint) unless the parameters meet the condition."""
    if not condition:
        raise ValueError(complaint)


def strips(ids: NDArray[np.int32]) -> Faces:
    """Split the cells of a (rows, columns) grid of vertex indices into two facets each.

    With rows running up and columns to the right, normals point at the viewer. Repeat the first
    row or column as the last one to close the grid on itself.
    """
    low, right, high, left = ids[:-1, :-1], ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]
    halves = np.stack([low, right, high, low, high, left], axis=-1)
    return halves.reshape(-1, 3).astype(np.int32)


def polygon(corners: int) -> NDArray[np.float64]:
    """Return the directions (corners, 2) of a regular polygon's corners; the first is +x."""
    require(corners >= 3, f"a closed ring needs at least 3 sections, not {corners}")
    angle = 2 * np.pi * np.arange(corners) / corners
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def loft(loops: Sequence[ArrayLike], *, closed: bool = False) -> Surface:
    """Join loops (n, 3) of equally many points, each to the next; counter-clockwise going up.

    The first and last loop are closed by a fan about their mean point, or, with `closed`, joined
    to each other: the shape then has a hole through it (up on the outside, down on the inside).
    """
    rows = np.asarray(loops, dtype=np.float64)
    count, columns = rows.shape[:2]
    ids = np.arange(count * columns, dtype=np.int32).reshape(count, columns)
    wrapped = np.concatenate([ids, ids[:, :1]], axis=1)
    if closed:
        return rows.reshape(-1, 3), strips(np.concatenate([wrapped, wrapped[:1]]))
    bottom, top = np.int32(ids.size), np.int32(ids.size + 1)
    vertices = np.concatenate([rows.reshape(-1, 3), [rows[0].mean(axis=0), rows[-1].mean(axis=0)]])
    low, high = wrapped[0], wrapped[-1]
    fan = [
        np.stack([np.full(columns, bottom), low[1:], low[:-1]], axis=-1),
        np.stack([np.full(columns, top), high[:-1], high[1:]], axis=-1),
    ]
    return vertices, np.concatenate([strips(wrapped), *fan])


def revolve(profile: ArrayLike, sections: int, *, closed: bool = False) -> Surface:
    """Turn a profile (k, 2) of (radius, z) about the z axis; up on the outside.

    Ends are closed by flat fans about the axis, or, with `closed`, the profile is a loop around
    the material of a ring. Radii must be positive, except at an end that is a pole.
    """
    outline = np.asarray(profile, dtype=np.float64)
    poles = [end for end in (0, -1) if not closed and outline[end, 0] == 0.0]
    inner = outline[(0 in poles) : len(outline) - (-1 in poles)]
    require(bool(np.all(inner[:, 0] > 0.0)), "radii must be positive")
    ring = polygon(sections)
    loops = [np.column_stack([radius * ring, np.full(sections, z)]) for radius, z in inner]
    vertices, faces = loft(loops, closed=closed)
    for end in poles:
        vertices[-2 if end == 0 else -1] = [0.0, 0.0, outline[end, 1]]
    return vertices, faces


def prism(outline: ArrayLike, length: float, *, apex: int = 0) -> Surface:
    """Extrude an outline (k, 2) in x, y, counter-clockwise, from z = -length/2 to length/2.

    The end faces are fans about corner `apex`, from which the whole outline must be visible.
    """
    require(length > 0.0, f"length must be positive, not {length}")
    corners = np.asarray(outline, dtype=np.float64)
    count = len(corners)
    low = np.arange(count, dtype=np.int32)
    wrapped = np.stack([np.append(low, 0), np.append(low, 0) + count]).astype(np.int32)
    around = np.roll(low, -apex)
    fan = np.stack([np.full(count - 2, around[0]), around[1:-1], around[2:]], axis=-1)
    vertices = np.concatenate(
        [np.column_stack([corners, np.full(count, z)]) for z in (-length / 2, length / 2)]
    )
    faces = np.concatenate([strips(wrapped), fan[:, ::-1], fan + count])
    return vertices, faces.astype(np.int32)
