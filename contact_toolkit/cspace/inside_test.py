"""Whether one solid lies wholly inside another, which queries between surfaces cannot see."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from contact_toolkit.query.point import signed_distance
from contact_toolkit.shapes.convex_pieces import ConvexPieces, Shape
from contact_toolkit.shapes.mesh import CollisionMesh, Floats


class InsideTest:
    """Looks for a part of B inside a mesh A whose surface does not touch B's.

    One point of each connected part of B decides. A mesh that is not closed, or that is inside out,
    has no inside; pieces are solid in every query already.
    """

    def __init__(self, A: Shape, B: Shape) -> None:
        self._solid: CollisionMesh | None = None
        if isinstance(A, CollisionMesh) and A.solid.has_inside:
            self._solid = A
            self._probes = _points_of_parts(B)

    def find(self, X_AB: Floats, threads: int) -> tuple[NDArray[np.bool_], Floats]:
        """Tell at each of (n, 4, 4) poses whether a part is inside, with a point (n, 3) of it."""
        count = len(X_AB)
        if self._solid is None:
            return np.zeros(count, dtype=bool), np.zeros((count, 3))
        points = self._probes @ X_AB[:, :3, :3].transpose(0, 2, 1) + X_AB[:, None, :3, 3]
        near = (points >= self._solid.lower) & (points <= self._solid.upper)
        inside = np.asarray(near.all(axis=2))
        if inside.any():
            inside[inside] = (
                signed_distance(self._solid, points[inside], threads=threads).distance < 0
            )
        first = inside.argmax(axis=1)
        return np.asarray(inside.any(axis=1)), points[np.arange(count), first]


def _points_of_parts(shape: Shape) -> Floats:
    """Return a point (m, 3) of each connected part."""
    from scipy.sparse import coo_array  # noqa: PLC0415  the package imports with numpy alone
    from scipy.sparse.csgraph import connected_components  # noqa: PLC0415

    if isinstance(shape, ConvexPieces):
        return np.array([piece[0] for piece in shape.pieces])
    n = len(shape.vertices)
    a, b = shape.edges.T
    graph = coo_array((np.ones(len(a), dtype=np.int8), (a, b)), shape=(n, n))
    _, part = connected_components(graph, directed=False)
    used = np.unique(shape.faces)
    _, first = np.unique(part[used], return_index=True)
    return shape.vertices[used[first]]
