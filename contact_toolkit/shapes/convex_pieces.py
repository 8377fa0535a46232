"""ConvexPieces: a solid given as a union of convex hulls, for queries far cheaper than a mesh's."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from contact_toolkit import _core
from contact_toolkit.shapes.mesh import CollisionMesh, Floats, Ints


class ConvexPieces:
    """A union of convex hulls under a bounding volume hierarchy; immutable.

    Unlike a `CollisionMesh`, which is a surface, the pieces are solid: whatever enters one touches
    it. Make one from a mesh with `decompose`, or give the pieces.

    Parameters
    ----------
    pieces
        For each piece the (n, 3) points [m] it is the hull of. Points inside the hull are dropped;
        a piece may be flat, a segment or a single point.

    Raises
    ------
    ValueError
        Naming the first bad piece: no piece, no point, wrong shape, or a coordinate that is NaN,
        infinite or beyond 1e15 m.

    Examples
    --------
    >>> import numpy as np
    >>> from contact_toolkit import ConvexPieces, distance
    >>> corner = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> shape = ConvexPieces([corner, [[2.0, 0, 0]]])  # a tetrahedron and a point
    >>> X_AB = np.eye(4)
    >>> X_AB[0, 3] = 2.5
    >>> distance(shape, shape, X_AB).distance
    0.5
    """

    def __init__(self, pieces: Sequence[ArrayLike]) -> None:
        points = [_as_points(piece, i) for i, piece in enumerate(pieces)]
        if not points:
            raise ValueError("ConvexPieces needs at least one piece")
        self._pieces = tuple(_hull_vertices(piece) for piece in points)
        first = np.cumsum([0, *map(len, self._pieces)], dtype=np.int32)
        self._core = _core.Pieces(np.concatenate(self._pieces), first)

    @property
    def pieces(self) -> tuple[Floats, ...]:
        """The hull vertices of each piece, (n, 3) [m], read-only."""
        return self._pieces

    @property
    def lower(self) -> Floats:
        """(3,) lower corner of the bounding box [m]."""
        return np.asarray(self._core.lower)

    @property
    def upper(self) -> Floats:
        """(3,) upper corner of the bounding box [m]."""
        return np.asarray(self._core.upper)

    @property
    def diagonal(self) -> float:
        """Length of the bounding box's diagonal [m]."""
        return float(np.linalg.norm(self.upper - self.lower))

    def hull(self, i: int) -> tuple[Floats, Ints]:
        """Vertices (n, 3) [m] and outward facets (m, 3) of piece i, to draw or to export it.

        Raises ValueError if the piece is flat.
        """
        from scipy.spatial import ConvexHull, QhullError  # noqa: PLC0415  numpy alone to import

        try:
            hull = ConvexHull(self._pieces[i])
        except QhullError as error:
            raise ValueError(f"piece {i} is flat and has no facets") from error
        a, b, c = (hull.points[hull.simplices[:, k]] for k in range(3))
        inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0
        faces = np.where(inward[:, None], hull.simplices[:, ::-1], hull.simplices)
        return self._pieces[i], np.ascontiguousarray(faces, dtype=np.int32)

    def __reduce__(self) -> tuple[type[ConvexPieces], tuple[tuple[Floats, ...]]]:
        return ConvexPieces, (self._pieces,)

    def __len__(self) -> int:
        return len(self._pieces)

    def __repr__(self) -> str:
        return f"ConvexPieces({len(self)} pieces, {sum(map(len, self._pieces))} vertices)"


Shape = CollisionMesh | ConvexPieces


def _as_points(piece: ArrayLike, index: int) -> Floats:
    points = np.array(piece, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or len(points) == 0:
        raise ValueError(f"piece {index} must be (n, 3) points with n > 0, not {points.shape}")
    return points


def _hull_vertices(points: Floats) -> Floats:
    from scipy.spatial import ConvexHull, QhullError  # noqa: PLC0415  numpy alone to import

    # Without volume, or too small for qhull, the points themselves serve as well.
    if len(points) > 4 and np.isfinite(points).all():
        try:
            points = points[np.sort(ConvexHull(points).vertices)]
        except QhullError:
            points = np.unique(points, axis=0)
    points.flags.writeable = False
    return points
