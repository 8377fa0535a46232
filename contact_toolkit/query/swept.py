"""Distance and collision of two shapes while one moves.

The motion: B's origin goes straight from its start to its end at constant speed, while B turns the
shorter way about a fixed axis at constant rate (half a turn goes either way). A time is the
fraction of the motion done, 0 to 1. So B's origin is the point that moves straight: put it
accordingly.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from types import SimpleNamespace

import numpy as np
from numpy.typing import ArrayLike

from contact_toolkit import _core
from contact_toolkit.query.arguments import (
    as_pose,
    as_separation,
    as_tolerance,
    as_upper_bound,
    core_of,
)
from contact_toolkit.shapes.convex_pieces import Shape
from contact_toolkit.shapes.mesh import Floats


class ImpactStatus(IntEnum):
    """How a search for the time of impact ended."""

    FREE = 0
    """Never as close as the separation."""
    IMPACT = 1
    """As close at `time`, and not before."""
    INITIAL_CONTACT = 2
    """As close already at the start."""
    ITERATION_LIMIT = 3
    """Not as close before `time`; the search gave up there. Treat it as an impact."""


class SweptDistance:
    """The least distance of two shapes over a motion.

    Arrays are made whenever one is asked for.
    """

    __slots__ = ("_found",)

    def __init__(self, found: _core.SweptDistance) -> None:
        self._found = found

    def __reduce__(self) -> tuple[type[SweptDistance], tuple[SimpleNamespace]]:
        fields = {name: getattr(self, name) for name in _DISTANCE_FIELDS}
        return SweptDistance, (SimpleNamespace(**fields),)

    def __repr__(self) -> str:
        fields = (f"{name}={getattr(self, name)!r}" for name in _DISTANCE_FIELDS)
        return f"SweptDistance({', '.join(fields)})"

    @property
    def distance(self) -> float:
        """[m]; the shapes are certainly never closer, up to rounding.

        Infinite when they stay beyond the upper bound asked for: no other field then means
        anything.
        """
        return self._found.distance

    @property
    def error(self) -> float:
        """[m]; the truth lies between `distance` and `distance + error`.

        Zero in a pure translation, else at most the tolerance if `converged`.
        """
        return self._found.error

    @property
    def time(self) -> float:
        """Fraction of the motion at which the shapes come within `distance + error`."""
        return self._found.time

    @property
    def p_ACa(self) -> Floats:
        """(3,) point of A that far from B's then, in A [m]."""
        return self._found.p_ACa

    @property
    def p_ACb(self) -> Floats:
        """(3,) point of B that far from A's then, in A [m]."""
        return self._found.p_ACb

    @property
    def facet_a(self) -> int:
        """The facet, or the piece, of A."""
        return self._found.facet_a

    @property
    def facet_b(self) -> int:
        """The facet, or the piece, of B."""
        return self._found.facet_b

    @property
    def converged(self) -> bool:
        """False if an iteration limit left `error` above the tolerance."""
        return self._found.converged


_DISTANCE_FIELDS = [
    name for name, value in vars(SweptDistance).items() if isinstance(value, property)
]


@dataclass(frozen=True)
class TimeOfImpact:
    """When two shapes first come as close as a separation.

    Attributes
    ----------
    time
        Fraction of the motion; certainly, up to rounding, they are not as close before. 1 when
        free.
    distance
        [m] of the two points at `time`: at most the separation plus the tolerance. Infinite when
        free.
    p_ACa, p_ACb
        (3,) the points of A and B that meet, in A [m].
    normal_A
        (3,) unit vector from B towards A; zero where they overlap.
    facet_a, facet_b
        The facets, or the pieces, that meet; -1 when free.
    status
        How the search ended.
    """

    time: float
    distance: float
    p_ACa: Floats
    p_ACb: Floats
    normal_A: Floats
    facet_a: int
    facet_b: int
    status: ImpactStatus


def swept_distance(
    A: Shape,
    B: Shape,
    X_AB_start: ArrayLike,
    X_AB_end: ArrayLike,
    *,
    tolerance: float | None = None,
    upper_bound: float = np.inf,
) -> SweptDistance:
    """Find the least distance of two shapes over a motion.

    A pure translation is exact: a convex set sweeps over the hull of its two end positions. With
    rotation the answer is certified from below and refined to the tolerance.

    Parameters
    ----------
    X_AB_start, X_AB_end
        (4, 4) poses of B in A at the start and the end.
    tolerance
        [m] on the answer; by default a millionth of the smaller shape's diagonal.
    upper_bound
        [m]; larger distances are of no interest, and the query may stop early.

    Raises
    ------
    ValueError
        If a pose is not rigid, telling which and what is wrong with it, the tolerance is not
        positive, or `upper_bound` is negative.

    Examples
    --------
    >>> import numpy as np
    >>> from contact_toolkit import CollisionMesh, swept_distance
    >>> from contact_toolkit.shapes.primitives import box
    >>> cube = CollisionMesh(*box([0.1, 0.1, 0.1]))
    >>> X_AB_start, X_AB_end = np.eye(4), np.eye(4)
    >>> X_AB_start[:3, 3] = -1.0, 0.0, 0.12
    >>> X_AB_end[:3, 3] = 1.0, 0.0, 0.12
    >>> closest = swept_distance(cube, cube, X_AB_start, X_AB_end)
    >>> round(closest.distance, 12), closest.error
    (0.02, 0.0)
    """
    start, end = as_pose(X_AB_start, "X_AB_start"), as_pose(X_AB_end, "X_AB_end")
    return SweptDistance(
        _core.swept_distance(
            core_of(A, "A"),
            core_of(B, "B"),
            start,
            end,
            as_tolerance(tolerance, A, B),
            as_upper_bound(upper_bound),
        )
    )


def swept_intersects(
    A: Shape,
    B: Shape,
    X_AB_start: ArrayLike,
    X_AB_end: ArrayLike,
    *,
    tolerance: float | None = None,
) -> bool:
    """Tell whether two shapes touch during a motion; never misses a collision.

    With rotation, shapes that pass each other within the tolerance count as touching; in a pure
    translation, within rounding. Parameters and errors are those of `swept_distance`.

    Examples
    --------
    >>> import numpy as np
    >>> from contact_toolkit import CollisionMesh, swept_intersects
    >>> from contact_toolkit.shapes.primitives import box
    >>> cube = CollisionMesh(*box([0.1, 0.1, 0.1]))
    >>> X_AB_start, X_AB_end = np.eye(4), np.eye(4)
    >>> X_AB_start[0, 3], X_AB_end[0, 3] = -1.0, 1.0  # through and out again
    >>> swept_intersects(cube, cube, X_AB_start, X_AB_end)
    True
    """
    start, end = as_pose(X_AB_start, "X_AB_start"), as_pose(X_AB_end, "X_AB_end")
    return _core.swept_intersects(
        core_of(A, "A"), core_of(B, "B"), start, end, as_tolerance(tolerance, A, B)
    )


def time_of_impact(
    A: Shape,
    B: Shape,
    X_AB_start: ArrayLike,
    X_AB_end: ArrayLike,
    *,
    separation: float = 0.0,
    tolerance: float | None = None,
) -> TimeOfImpact:
    """Find when two shapes first come as close as a separation; never late, never misses.

    Conservative advancement of pairs of facets or pieces: before the time found the shapes are
    farther apart than the separation; at it, no farther than the separation and the tolerance.
    So shapes that pass within the tolerance may be reported, ones that meet always are.

    Parameters
    ----------
    X_AB_start, X_AB_end
        (4, 4) poses of B in A at the start and the end.
    separation
        [m], at least 0; for example a standoff.
    tolerance
        [m]; by default a millionth of the smaller shape's diagonal.

    Raises
    ------
    ValueError
        If a pose is not rigid, telling which and what is wrong with it, `separation` is negative
        or not finite, or the tolerance is not positive.

    Examples
    --------
    >>> import numpy as np
    >>> from contact_toolkit import CollisionMesh, ImpactStatus, time_of_impact
    >>> from contact_toolkit.shapes.primitives import box
    >>> cube = CollisionMesh(*box([0.1, 0.1, 0.1]))
    >>> X_AB_start, X_AB_end = np.eye(4), np.eye(4)
    >>> X_AB_start[0, 3], X_AB_end[0, 3] = 0.6, 0.1
    >>> impact = time_of_impact(cube, cube, X_AB_start, X_AB_end, separation=0.1)
    >>> impact.status is ImpactStatus.IMPACT, round(impact.time, 5)
    (True, 0.8)
    """
    start, end = as_pose(X_AB_start, "X_AB_start"), as_pose(X_AB_end, "X_AB_end")
    found = _core.time_of_impact(
        core_of(A, "A"),
        core_of(B, "B"),
        start,
        end,
        as_separation(separation),
        as_tolerance(tolerance, A, B),
    )
    return TimeOfImpact(**{**found, "status": ImpactStatus(found["status"])})
