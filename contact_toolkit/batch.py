"""Distance and interference at many poses at once, shared between threads.

Row i of every result belongs to pose i and equals the single query's answer, whatever the number of
threads.
"""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contact_toolkit import _core
from contact_toolkit.convex import Shape
from contact_toolkit.mesh import Floats, Ints


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
    index_a, index_b
        (n,) the facets, or the pieces, they lie on.
    """

    distance: Floats
    p_ACa: Floats
    p_ACb: Floats
    index_a: Ints
    index_b: Ints

    def __len__(self) -> int:
        return len(self.distance)


def distance_batch(
    A: Shape,
    B: Shape,
    X_AB: ArrayLike,
    *,
    upper_bound: ArrayLike = np.inf,
    threads: int | None = None,
) -> Distances:
    """Find the closest points of two shapes at (n, 4, 4) poses of B in A; see `distance`.

    `upper_bound`: one for all rows, or (n,). `threads`: None takes as many as the process may use.
    """
    poses = as_poses(X_AB)
    bounds = as_upper_bounds(upper_bound, len(poses))
    found = _core.distances(A._core, B._core, poses, bounds, as_threads(threads))
    return Distances(**found)


def intersects_batch(
    A: Shape, B: Shape, X_AB: ArrayLike, *, threads: int | None = None
) -> NDArray[np.bool_]:
    """Tell at each of (n, 4, 4) poses of B in A whether the shapes touch; see `intersects`.

    `threads`: None takes as many as the process may use.
    """
    poses = as_poses(X_AB)
    return np.asarray(_core.intersections(A._core, B._core, poses, as_threads(threads)))


def as_poses(X: ArrayLike, name: str = "X_AB") -> Floats:
    """Return poses as a contiguous (n, 4, 4) array; raise ValueError unless each is rigid."""
    poses = np.ascontiguousarray(X, dtype=np.float64)
    if poses.ndim != 3 or poses.shape[1:] != (4, 4):
        raise ValueError(f"{name} must be homogeneous matrices (n, 4, 4), not {poses.shape}")
    _core.check_poses(poses, name)
    return poses


def as_upper_bounds(upper_bound: ArrayLike, rows: int) -> Floats:
    """Return an upper bound (n,) for each row; raise ValueError if any is negative or no number."""
    try:
        bounds = np.broadcast_to(np.asarray(upper_bound, dtype=np.float64), (rows,))
    except ValueError as error:
        raise ValueError(f"upper_bound must be a number or ({rows},) numbers: {error}") from error
    if not (bounds >= 0).all():
        raise ValueError(f"upper_bound must be at least 0, not {bounds[~(bounds >= 0)][0]}")
    return np.ascontiguousarray(bounds)


def as_threads(threads: int | None) -> int:
    """Return a number of threads to use; raise ValueError unless it is positive."""
    if threads is None:
        return len(os.sched_getaffinity(0))
    if threads < 1:
        raise ValueError(f"threads must be at least 1, not {threads}")
    return threads
