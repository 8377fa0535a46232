"""What queries ask of their arguments: each is checked here, and returned as the core takes it.

One rule for `threads` in every function: how many share the work, 1 unless given, None for as many
as the process may use; the answer does not depend on it.
"""

from __future__ import annotations

import math
import os
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contact_toolkit import _core
from contact_toolkit.shapes.convex_pieces import Shape
from contact_toolkit.shapes.mesh import Floats

_DEFAULT_TOLERANCE = 1e-6  # [-] of the smaller shape's diagonal
_MAX_COORDINATE = 1e15  # [m], as for meshes


def core_of(shape: Shape, name: str) -> Any:
    """Return the native object behind a mesh or pieces; raise TypeError for anything else."""
    try:
        return shape._core
    except AttributeError:
        mend = (
            f"CollisionMesh.from_file({str(shape)!r})"
            if isinstance(shape, str | os.PathLike)
            else "CollisionMesh(vertices, faces)"
        )
        raise TypeError(
            f"{name} must be a CollisionMesh or ConvexPieces, not {type(shape).__name__}; "
            f"try {mend}"
        ) from None


def as_pose(X: ArrayLike, name: str = "X_AB") -> NDArray[np.float64]:
    """Return a pose as a contiguous (4, 4) array; raise ValueError unless it is rigid.

    Drake's `RigidTransform` is a pose too.
    """
    # Nearly every pose comes as it is needed, and a query may take less time than a conversion.
    if type(X) is np.ndarray:
        try:
            _core.check_pose(X, name)
        except TypeError:  # of another type, shape or order
            pass
        else:
            return X
    pose = np.ascontiguousarray(_matrix(X), dtype=np.float64)
    if pose.shape != (4, 4):
        raise ValueError(f"{name} must be a (4, 4) homogeneous matrix, not of shape {pose.shape}")
    _core.check_pose(pose, name)
    return pose


def as_poses(X: ArrayLike, name: str = "X_AB") -> Floats:
    """Return poses as a contiguous (n, 4, 4) array; raise ValueError unless each is rigid."""
    poses = np.ascontiguousarray(_matrices(X), dtype=np.float64)
    if poses.ndim != 3 or poses.shape[1:] != (4, 4):
        raise ValueError(f"{name} must be homogeneous matrices (n, 4, 4), not {poses.shape}")
    _core.check_poses(poses, name)
    return poses


def as_motions(X_AB_start: ArrayLike, X_AB_end: ArrayLike) -> tuple[Floats, Floats]:
    """Return the ends of motions as (n, 4, 4) arrays; ValueError unless rigid and as many."""
    start, end = as_poses(X_AB_start, "X_AB_start"), as_poses(X_AB_end, "X_AB_end")
    if len(start) != len(end):
        raise ValueError(f"{len(start)} start poses need as many end poses, not {len(end)}")
    return start, end


def as_points(points: ArrayLike) -> Floats:
    """Return points as a contiguous (n, 3) array; raise ValueError unless finite."""
    p = np.ascontiguousarray(points, dtype=np.float64)
    if p.ndim != 2 or p.shape[1] != 3:
        raise ValueError(f"points must have shape (n, 3), not {p.shape}")
    bad = ~(np.abs(p) <= _MAX_COORDINATE).all(axis=1)
    if bad.any():
        first = int(np.argmax(bad))
        raise ValueError(
            f"point {first} is {p[first].tolist()}; coordinates must be finite and below 1e15 m"
        )
    return p


def as_standoff(standoff: float, name: str = "standoff") -> float:
    """Return a length [m]; raise ValueError unless it is finite and at least 0."""
    if not 0 <= standoff < math.inf:
        raise ValueError(f"{name} must be a finite length of at least 0 m, not {standoff}")
    return float(standoff)


def as_separation(separation: float) -> float:
    """Return a separation [m]; raise ValueError unless it is finite and at least 0."""
    return as_standoff(separation, "separation")


def as_upper_bound(upper_bound: float) -> float:
    """Return an upper bound [m]; raise ValueError unless it is at least 0."""
    if not upper_bound >= 0:
        raise ValueError(f"upper_bound must be at least 0, not {upper_bound}")
    return float(upper_bound)


def as_upper_bounds(upper_bound: ArrayLike, rows: int) -> Floats:
    """Return an upper bound (n,) for each row; raise ValueError if any is negative or no number."""
    try:
        bounds = np.broadcast_to(np.asarray(upper_bound, dtype=np.float64), (rows,))
    except ValueError as error:
        raise ValueError(f"upper_bound must be a number or ({rows},) numbers: {error}") from error
    if not (bounds >= 0).all():
        raise ValueError(f"upper_bound must be at least 0, not {bounds[~(bounds >= 0)][0]}")
    return np.array(bounds)  # its own: broadcasting gives a view that cannot be written to


def as_tolerance(tolerance: float | None, A: Shape, B: Shape) -> float:
    """Return a tolerance [m], by default a millionth of the smaller shape; it must be positive."""
    if tolerance is None:
        return _DEFAULT_TOLERANCE * min(A.diagonal, B.diagonal)
    if not (np.isfinite(tolerance) and tolerance > 0):
        raise ValueError(f"tolerance must be a positive length, not {tolerance}")
    return float(tolerance)


def as_threads(threads: int | None) -> int:
    """Return a number of threads to use; raise ValueError unless it is positive."""
    if threads is None:
        return len(os.sched_getaffinity(0))
    if threads < 1:
        raise ValueError(f"threads must be at least 1, not {threads}")
    return threads


def _matrix(X: object) -> ArrayLike:
    """Return a pose as a matrix: Drake's `RigidTransform` by its own, without importing Drake."""
    return X.GetAsMatrix4() if hasattr(X, "GetAsMatrix4") else X  # type: ignore[return-value]


def _matrices(X: object) -> ArrayLike:
    """Return poses as they are, or a list of Drake's as matrices."""
    return [_matrix(each) for each in X] if isinstance(X, list | tuple) else X  # type: ignore[return-value]
