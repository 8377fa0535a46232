"""Distance and interference at many poses at once, shared between threads.

Row i of every result belongs to pose i and equals the single query's answer, whatever the number of
threads.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contact_toolkit import _core
from contact_toolkit.query.arguments import (
    as_poses,
    as_threads,
    as_upper_bounds,
    core_of,
)
from contact_toolkit.shapes.convex_pieces import Shape
from contact_toolkit.shapes.mesh import Floats, Ints


@dataclass(frozen=True)
class Distances:
    """The closest points of two shapes at n poses.

    Attributes
    ----------
    distance
        (n,) [m]; infinite in rows where nothing lies below the upper bound asked for, whose other
        fields mean nothing.
    p_ACa, p_ACb
        (n, 3) witness points on A and B, in A [m].
    facet_a, facet_b
        (n,) the facets, or the pieces, they lie on.
    """

    distance: Floats
    p_ACa: Floats
    p_ACb: Floats
    facet_a: Ints
    facet_b: Ints

    def __len__(self) -> int:
        return len(self.distance)


def distance_batch(
    A: Shape,
    B: Shape,
    X_AB: ArrayLike,
    *,
    upper_bound: ArrayLike = np.inf,
    threads: int | None = 1,
) -> Distances:
    """Find the closest points of two shapes at (n, 4, 4) poses of B in A; see `distance`.

    `upper_bound`: one for all rows, or (n,). `threads`: how many share the work; None: as
    many as the process may use.

    Examples
    --------
    >>> import numpy as np
    >>> from contact_toolkit import CollisionMesh, distance_batch
    >>> from contact_toolkit.shapes.primitives import box
    >>> cube = CollisionMesh(*box([0.1, 0.1, 0.1]))
    >>> X_AB = np.tile(np.eye(4), (2, 1, 1))
    >>> X_AB[:, 0, 3] = 0.09, 0.15
    >>> distance_batch(cube, cube, X_AB).distance.round(12)
    array([0.  , 0.05])
    """
    poses = as_poses(X_AB)
    bounds = as_upper_bounds(upper_bound, len(poses))
    found = _core.distances(core_of(A, "A"), core_of(B, "B"), poses, bounds, as_threads(threads))
    return Distances(**found)


def intersects_batch(
    A: Shape, B: Shape, X_AB: ArrayLike, *, threads: int | None = 1
) -> NDArray[np.bool_]:
    """Tell at each of (n, 4, 4) poses of B in A whether the shapes touch; see `intersects`.

    `threads`: how many share the work; None: as many as the process may use.

    Examples
    --------
    >>> import numpy as np
    >>> from contact_toolkit import CollisionMesh, intersects_batch
    >>> from contact_toolkit.shapes.primitives import box
    >>> cube = CollisionMesh(*box([0.1, 0.1, 0.1]))
    >>> X_AB = np.tile(np.eye(4), (2, 1, 1))
    >>> X_AB[:, 0, 3] = 0.09, 0.15
    >>> intersects_batch(cube, cube, X_AB)
    array([ True, False])
    """
    poses = as_poses(X_AB)
    return np.asarray(
        _core.intersections(core_of(A, "A"), core_of(B, "B"), poses, as_threads(threads))
    )
