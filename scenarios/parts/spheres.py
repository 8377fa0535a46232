"""Spheres of any number of facets, smooth and bumpy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.parts.surface import Surface, require

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


def icosphere(radius: float = 0.05, frequency: int = 8) -> Surface:
    """Return a sphere about the origin: an icosahedron, each edge cut in `frequency` parts.

    20 frequency² facets of nearly equal size (7 gives 980, 224 gives 1 003 520); vertices lie on
    the exact sphere. Radius in [m].
    """
    require(radius > 0.0, f"radius must be positive, not {radius}")
    require(frequency >= 1, f"frequency must be at least 1, not {frequency}")
    return _subdivided(radius, frequency)


def bumpy_sphere(
    radius: float = 0.05, frequency: int = 32, amplitude: float = 0.1, bumps: float = 6.0
) -> Surface:
    """Return a sphere whose radius varies by ± `amplitude` (relative), not convex.

    `bumps` is the number of waves across the diameter. 20 frequency² facets.
    """
    require(0.0 <= amplitude < 1.0, f"amplitude must be in [0, 1), not {amplitude}")
    vertices, faces = icosphere(radius, frequency)
    phase = np.pi * bumps * vertices / radius + [0.3, 0.7, 1.1]  # off every symmetry plane
    return vertices * (1.0 + amplitude * np.sin(phase).prod(axis=1, keepdims=True)), faces


def _subdivided(radius: float, n: int) -> Surface:
    row, column = np.tril_indices(n + 1)
    weights = np.column_stack([n - row, row - column, column])  # barycentric, in units of 1/n
    # A point shared by two triangles has the same corner weights in both: their sum, each times
    # the corner's own random 64-bit number, identifies it without comparing coordinates.
    tag = np.random.default_rng(0).integers(2**63, size=12, dtype=np.uint64)
    with np.errstate(over="ignore"):
        keys = tag[_TRIANGLES] @ weights.T.astype(np.uint64)
    _, first, index = np.unique(keys.reshape(-1), return_index=True, return_inverse=True)
    assert len(first) == 10 * n * n + 2
    # Numbered as the triangles meet them: neighbours stay together, as in meshes from elsewhere.
    order = np.argsort(first)
    first, index = first[order], np.argsort(order)[index]
    points = np.einsum("wc,tcx->twx", weights / n, _ICOSAHEDRON[_TRIANGLES]).reshape(-1, 3)[first]
    vertices = radius * points / np.linalg.norm(points, axis=1, keepdims=True)

    def at(row: NDArray[np.int64], column: NDArray[np.int64]) -> NDArray[np.int64]:
        return row * (row + 1) // 2 + column

    row, column = np.tril_indices(n)
    up = np.column_stack([at(row, column), at(row + 1, column), at(row + 1, column + 1)])
    row, column = row[row > column], column[row > column]
    down = np.column_stack([at(row, column), at(row + 1, column + 1), at(row, column + 1)])
    cells = np.concatenate([up, down])
    faces = index.reshape(20, -1)[:, cells].reshape(-1, 3)
    return vertices, faces.astype(np.int32)
