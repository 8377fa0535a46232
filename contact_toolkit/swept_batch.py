"""The swept queries for many motions at once, shared between threads; see `contact_toolkit.swept`.

Row i of every result belongs to motion i and equals the single query's answer, whatever the number
of threads.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contact_toolkit import _core
from contact_toolkit.batch import as_poses, as_threads, as_upper_bounds
from contact_toolkit.convex import Shape
from contact_toolkit.mesh import Floats, Ints

_DEFAULT_TOLERANCE = 1e-6  # [-] of the smaller shape's diagonal


@dataclass(frozen=True)
class SweptDistances:
    """Least distances over n motions; the fields of `SweptDistance` as arrays of n rows."""

    distance: Floats
    error: Floats
    time: Floats
    p_ACa: Floats
    p_ACb: Floats
    index_a: Ints
    index_b: Ints
    converged: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.distance)


@dataclass(frozen=True)
class TimesOfImpact:
    """Times of impact of n motions; the fields of `TimeOfImpact` as arrays of n rows.

    `status` holds values of `ImpactStatus`.
    """

    time: Floats
    distance: Floats
    p_ACa: Floats
    p_ACb: Floats
    normal_A: Floats
    index_a: Ints
    index_b: Ints
    status: Ints

    def __len__(self) -> int:
        return len(self.time)


def swept_distance_batch(
    A: Shape,
    B: Shape,
    X_AB_start: ArrayLike,
    X_AB_end: ArrayLike,
    *,
    tolerance: float | None = None,
    upper_bound: ArrayLike = np.inf,
    threads: int | None = None,
) -> SweptDistances:
    """Find the least distances over n motions between (n, 4, 4) poses; see `swept_distance`.

    `upper_bound`: one for all rows, or (n,). `threads`: None takes as many as the process may use.
    """
    start, end = _as_motions(X_AB_start, X_AB_end)
    found = _core.swept_distances(
        A._core,
        B._core,
        start,
        end,
        as_tolerance(tolerance, A, B),
        as_upper_bounds(upper_bound, len(start)),
        as_threads(threads),
    )
    return SweptDistances(**found)


def swept_intersects_batch(
    A: Shape,
    B: Shape,
    X_AB_start: ArrayLike,
    X_AB_end: ArrayLike,
    *,
    tolerance: float | None = None,
    threads: int | None = None,
) -> NDArray[np.bool_]:
    """Tell for each of n motions whether the shapes touch; see `swept_intersects`.

    `threads`: None takes as many as the process may use.
    """
    start, end = _as_motions(X_AB_start, X_AB_end)
    touches = _core.swept_intersections(
        A._core, B._core, start, end, as_tolerance(tolerance, A, B), as_threads(threads)
    )
    return np.asarray(touches)


def time_of_impact_batch(
    A: Shape,
    B: Shape,
    X_AB_start: ArrayLike,
    X_AB_end: ArrayLike,
    *,
    separation: float = 0.0,
    tolerance: float | None = None,
    threads: int | None = None,
) -> TimesOfImpact:
    """Find the times of impact of n motions between (n, 4, 4) poses; see `time_of_impact`.

    `threads`: None takes as many as the process may use.
    """
    if not (np.isfinite(separation) and separation >= 0):
        raise ValueError(f"separation must be a finite length of at least 0 m, not {separation}")
    start, end = _as_motions(X_AB_start, X_AB_end)
    found = _core.times_of_impact(
        A._core,
        B._core,
        start,
        end,
        separation,
        as_tolerance(tolerance, A, B),
        as_threads(threads),
    )
    return TimesOfImpact(**found)


def _as_motions(X_AB_start: ArrayLike, X_AB_end: ArrayLike) -> tuple[Floats, Floats]:
    start, end = as_poses(X_AB_start, "X_AB_start"), as_poses(X_AB_end, "X_AB_end")
    if len(start) != len(end):
        raise ValueError(f"{len(start)} start poses need as many end poses, not {len(end)}")
    return start, end


def as_tolerance(tolerance: float | None, A: Shape, B: Shape) -> float:
    """Return a tolerance [m], by default a millionth of the smaller shape; it must be positive."""
    if tolerance is None:
        return _DEFAULT_TOLERANCE * min(A.diagonal, B.diagonal)
    if not (np.isfinite(tolerance) and tolerance > 0):
        raise ValueError(f"tolerance must be a positive length, not {tolerance}")
    return float(tolerance)
