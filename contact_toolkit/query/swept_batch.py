"""The swept queries for many motions at once, shared between threads.

Row i of every result belongs to motion i and equals the single query's answer, whatever the number
of threads.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contact_toolkit import _core
from contact_toolkit.query.arguments import (
    as_motions,
    as_separation,
    as_threads,
    as_tolerance,
    as_upper_bounds,
    core_of,
)
from contact_toolkit.shapes.convex_pieces import Shape
from contact_toolkit.shapes.mesh import Floats, Ints


@dataclass(frozen=True)
class SweptDistances:
    """Least distances over n motions; the fields of `SweptDistance` as arrays of n rows."""

    distance: Floats
    error: Floats
    time: Floats
    p_ACa: Floats
    p_ACb: Floats
    facet_a: Ints
    facet_b: Ints
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
    facet_a: Ints
    facet_b: Ints
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
    threads: int | None = 1,
) -> SweptDistances:
    """Find the least distances over n motions between (n, 4, 4) poses; see `swept_distance`.

    `upper_bound`: one for all rows, or (n,). `threads`: how many share the work; None: as
    many as the process may use.

    Examples
    --------
    >>> import numpy as np
    >>> from contact_toolkit import CollisionMesh, swept_distance_batch
    >>> from contact_toolkit.shapes.primitives import box
    >>> cube = CollisionMesh(*box([0.1, 0.1, 0.1]))
    >>> start = np.tile(np.eye(4), (2, 1, 1))
    >>> start[:, 0, 3], start[1, 1, 3] = 0.3, 0.15
    >>> end = start.copy()
    >>> end[:, 0, 3] = -0.3
    >>> swept_distance_batch(cube, cube, start, end).distance.round(12)
    array([0.  , 0.05])
    """
    start, end = as_motions(X_AB_start, X_AB_end)
    found = _core.swept_distances(
        core_of(A, "A"),
        core_of(B, "B"),
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
    threads: int | None = 1,
) -> NDArray[np.bool_]:
    """Tell for each of n motions whether the shapes touch; see `swept_intersects`.

    `threads`: how many share the work; None: as many as the process may use.

    Examples
    --------
    >>> import numpy as np
    >>> from contact_toolkit import CollisionMesh, swept_intersects_batch
    >>> from contact_toolkit.shapes.primitives import box
    >>> cube = CollisionMesh(*box([0.1, 0.1, 0.1]))
    >>> start = np.tile(np.eye(4), (2, 1, 1))
    >>> start[:, 0, 3], start[1, 1, 3] = 0.3, 0.15
    >>> end = start.copy()
    >>> end[:, 0, 3] = -0.3
    >>> swept_intersects_batch(cube, cube, start, end)
    array([ True, False])
    """
    start, end = as_motions(X_AB_start, X_AB_end)
    touches = _core.swept_intersections(
        core_of(A, "A"),
        core_of(B, "B"),
        start,
        end,
        as_tolerance(tolerance, A, B),
        as_threads(threads),
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
    threads: int | None = 1,
) -> TimesOfImpact:
    """Find the times of impact of n motions between (n, 4, 4) poses; see `time_of_impact`.

    `threads`: how many share the work; None: as many as the process may use.

    Examples
    --------
    >>> import numpy as np
    >>> from contact_toolkit import CollisionMesh, ImpactStatus, time_of_impact_batch
    >>> from contact_toolkit.shapes.primitives import box
    >>> cube = CollisionMesh(*box([0.1, 0.1, 0.1]))
    >>> start = np.tile(np.eye(4), (2, 1, 1))
    >>> start[:, 0, 3], start[1, 1, 3] = 0.3, 0.15
    >>> end = start.copy()
    >>> end[:, 0, 3] = -0.3
    >>> impacts = time_of_impact_batch(cube, cube, start, end)
    >>> [ImpactStatus(status).name for status in impacts.status]
    ['IMPACT', 'FREE']
    >>> round(float(impacts.time[0]), 6)  # after 0.2 m of 0.6 m
    0.333333
    """
    start, end = as_motions(X_AB_start, X_AB_end)
    found = _core.times_of_impact(
        core_of(A, "A"),
        core_of(B, "B"),
        start,
        end,
        as_separation(separation),
        as_tolerance(tolerance, A, B),
        as_threads(threads),
    )
    return TimesOfImpact(**found)
