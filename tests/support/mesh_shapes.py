"""Small meshes of every kind the engine must serve, as (vertices (nv,3) [m], faces (nf,3)).

Deterministic, and independent of the part generators that the scenarios use.
"""

import numpy as np
from numpy.typing import NDArray

Shape = tuple[NDArray[np.float64], NDArray[np.int32]]


def doughnut(
    rings: int = 16, sections: int = 12, *, major: float = 0.05, minor: float = 0.02
) -> Shape:
    """A closed, non-convex surface about z."""
    u, v = _angles(rings), _angles(sections)
    u, v = np.meshgrid(u, v, indexing="ij")
    radius = major + minor * np.cos(v)
    vertices = np.stack([radius * np.cos(u), radius * np.sin(u), minor * np.sin(v)], axis=-1)
    return vertices.reshape(-1, 3), _quads(rings, sections, closed=(True, True))


def cone(
    sections: int = 16,
    rings: int = 3,
    *,
    bottom: float = 0.05,
    top: float = 0.02,
    height: float = 0.25,
) -> Shape:
    """A closed frustum on the xy plane, about z."""
    z = np.linspace(0, 1, rings + 1)
    u = _angles(sections)
    radius = bottom + (top - bottom) * z
    side = np.stack(
        [
            radius[:, None] * np.cos(u),
            radius[:, None] * np.sin(u),
            np.broadcast_to(height * z[:, None], (rings + 1, sections)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    around = np.arange(sections)
    last = rings * sections
    next_around = np.roll(around, -1)
    centre = len(side)
    floor = np.stack([np.full(sections, centre), next_around, around], axis=1)
    roof = np.stack([np.full(sections, centre + 1), last + around, last + next_around], axis=1)
    walls = _quads(rings + 1, sections, closed=(False, True))[:, ::-1]
    vertices = np.vstack([side, [[0, 0, 0], [0, 0, height]]])
    return vertices, np.vstack([walls, floor, roof]).astype(np.int32)


def cube(size: float = 1.0) -> Shape:
    """A closed cube about the origin; corner index 4 x + 2 y + z."""
    corners = np.stack(np.meshgrid([-1, 1], [-1, 1], [-1, 1], indexing="ij"), axis=-1)
    faces = [
        [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
        [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
    ]  # fmt: skip
    return size / 2 * corners.reshape(-1, 3).astype(float), np.array(faces, np.int32)


def sheet(cells: int = 8, *, size: float = 1.0, wave: float = 0.1) -> Shape:
    """An open, wavy surface over a square of the xy plane."""
    x = np.linspace(-0.5, 0.5, cells + 1)
    x, y = np.meshgrid(x, x, indexing="ij")
    z = wave * np.sin(7 * x) * np.cos(5 * y)
    vertices = size * np.stack([x, y, z], axis=-1).reshape(-1, 3)
    return vertices, _quads(cells + 1, cells + 1, closed=(False, False))


def soup(count: int = 150, *, facet: float = 0.3, seed: int = 0) -> Shape:
    """Triangles that know nothing of each other, in a cube of side 1."""
    rng = np.random.default_rng(seed)
    centres = rng.uniform(-0.5, 0.5, (count, 1, 3))
    vertices = centres + rng.uniform(-facet / 2, facet / 2, (count, 3, 3))
    return vertices.reshape(-1, 3), np.arange(3 * count, dtype=np.int32).reshape(-1, 3)


def sliver(*, length: float = 1.0, width: float = 1e-4) -> Shape:
    """One facet, long and thin, along x."""
    vertices = np.array([[-length / 2, 0, 0], [length / 2, 0, 0], [0.1 * length, width, 0]])
    return vertices, np.array([[0, 1, 2]], np.int32)


def ball(subdivisions: int = 2, *, radius: float = 0.5, bumps: float = 0.0) -> Shape:
    """A closed sphere made from an octahedron, with bumps if asked for."""
    vertices = np.vstack([np.eye(3), -np.eye(3)])
    faces = np.array(
        [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
    )
    for _ in range(subdivisions):
        vertices, faces = subdivided(vertices, faces)
    vertices = vertices / np.linalg.norm(vertices, axis=1, keepdims=True)
    height = 1 + bumps * np.prod(np.sin(9 * vertices), axis=1, keepdims=True)
    return radius * height * vertices, faces.astype(np.int32)


def subdivided(vertices: NDArray[np.float64], faces: NDArray[np.int32]) -> Shape:
    """The same surface with every facet cut into four at the middles of its edges."""
    edges = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1), axis=-1)
    unique, inverse = np.unique(edges.reshape(-1, 2), axis=0, return_inverse=True)
    middle = (inverse + len(vertices)).reshape(-1, 3)
    (a, b, c), (ab, bc, ca) = faces.T, middle.T
    corners = [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
    cut = np.vstack([np.stack(corner, axis=1) for corner in corners])
    return np.vstack([vertices, vertices[unique].mean(axis=1)]), cut.astype(np.int32)


def _angles(count: int) -> NDArray[np.float64]:
    return 2 * np.pi * np.arange(count) / count


def _quads(rows: int, columns: int, *, closed: tuple[bool, bool]) -> NDArray[np.int32]:
    """Two facets for each cell of a grid of vertices, outwards for a doughnut's (u, v)."""
    i = np.arange(rows if closed[0] else rows - 1)
    j = np.arange(columns if closed[1] else columns - 1)
    i, j = (grid.ravel() for grid in np.meshgrid(i, j, indexing="ij"))
    corner = [
        (i + di) % rows * columns + (j + dj) % columns
        for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1))
    ]
    a, b, c, d = corner
    return np.vstack([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).astype(np.int32)


# What every query of two meshes is tried on.
WITNESS_PAIRS = {
    "doughnut-cone": (doughnut(10, 6), cone(10, 3)),
    "cube-cube": (cube(), cube(0.7)),
    "sheet-ball": (sheet(6), ball(1, bumps=0.3)),
    "soup-soup": (soup(60, seed=1), soup(60, seed=2)),
    "sliver-sliver": (sliver(), sliver(width=1e-6)),
    "ball-ball": (ball(2), ball(1, radius=0.2)),
}
