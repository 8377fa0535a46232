"""Distance, interference and witness pairs between two shapes at a relative pose.

Every query takes `X_AB`, the pose of B in A as a (4, 4) homogeneous matrix, and answers in frame A.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contact_toolkit import _core
from contact_toolkit.convex import Shape
from contact_toolkit.mesh import CollisionMesh, Floats, Ints

VERTEX, EDGE, FACET, PIECE = 0, 1, 2, 3
"""Kinds of feature; a feature is (kind, index) into the mesh's vertices, edges or faces, or into
the pieces of a `ConvexPieces`."""


@dataclass(frozen=True)
class ClosestPair:
    """The closest points of two shapes.

    Attributes
    ----------
    distance
        [m]; infinite when nothing lies below the upper bound asked for, and then no other field
        means anything.
    p_ACa, p_ACb
        (3,) witness points on A and B, in A [m]; the same point where surfaces cross.
    normal_A
        (3,) unit vector from B towards A; where the distance is zero, by the facets' windings, or
        zero if one shape is made of pieces.
    facet_a, facet_b
        The facets, or the pieces, they lie on.
    feature_a, feature_b
        (kind, index), kind being `VERTEX`, `EDGE` or `FACET`; if one shape is made of pieces,
        `PIECE` there and always `FACET` on a mesh opposite.
    """

    distance: float
    p_ACa: Floats
    p_ACb: Floats
    normal_A: Floats
    facet_a: int
    facet_b: int
    feature_a: tuple[int, int]
    feature_b: tuple[int, int]


class WitnessPairs:
    """Facet pairs closer than a standoff, one row each; see `witness_pairs`.

    The columns are read-only arrays: views of the rows, made whenever one is asked for.
    """

    def __init__(self, rows: _core.WitnessPairs) -> None:
        self._rows = rows

    def __reduce__(self) -> tuple[type[WitnessPairs], tuple[SimpleNamespace]]:
        return WitnessPairs, (SimpleNamespace(**self.columns()),)

    def __len__(self) -> int:
        return len(self._rows.distance)

    def __repr__(self) -> str:
        return f"WitnessPairs({len(self)} rows: {', '.join(_COLUMNS)})"

    @property
    def distance(self) -> Floats:
        """(n,) [m]; 0 where facets cross."""
        return self._rows.distance

    @property
    def p_ACa(self) -> Floats:
        """(n, 3) witness points on A, in A [m]."""
        return self._rows.p_ACa

    @property
    def p_ACb(self) -> Floats:
        """(n, 3) witness points on B, in A [m]; those on A where facets cross."""
        return self._rows.p_ACb

    @property
    def normal_A(self) -> Floats:
        """(n, 3) unit vectors from B towards A; by the facets' windings at distance zero."""
        return self._rows.normal_A

    @property
    def facet_a(self) -> Ints:
        """(n,) facets of A; of a merged row, that of the first pair found."""
        return self._rows.facet_a

    @property
    def facet_b(self) -> Ints:
        """(n,) facets of B; of a merged row, that of the first pair found."""
        return self._rows.facet_b

    @property
    def feature_a(self) -> Ints:
        """(n, 2) kind and index of the feature of A the witness point lies on."""
        return self._rows.feature_a

    @property
    def feature_b(self) -> Ints:
        """(n, 2) kind and index of the feature of B the witness point lies on."""
        return self._rows.feature_b

    @property
    def multiplicity(self) -> Ints:
        """(n,) how many facet pairs the row stands for; 1 everywhere when not merged."""
        return self._rows.multiplicity

    def columns(self) -> dict[str, NDArray[Any]]:
        """Return all columns by their names."""
        return {name: getattr(self, name) for name in _COLUMNS}


_COLUMNS = [name for name, value in vars(WitnessPairs).items() if isinstance(value, property)]


def distance(A: Shape, B: Shape, X_AB: ArrayLike, *, upper_bound: float = np.inf) -> ClosestPair:
    """Find the closest points of two shapes.

    Meshes are surfaces: the distance is zero where they cross, positive where one body lies wholly
    inside the other. Pieces are solid. Where several pairs are equally close, one of them is
    returned, always the same.

    Parameters
    ----------
    X_AB
        (4, 4) pose of B in A.
    upper_bound
        [m]; pairs farther apart are of no interest, and the query may stop early. The answer is the
        same as without it when the distance is below, and infinite otherwise.
    """
    if not upper_bound >= 0:
        raise ValueError(f"upper_bound must be at least 0, not {upper_bound}")
    return ClosestPair(**_core.distance(A._core, B._core, as_pose(X_AB), upper_bound))


def intersects(A: Shape, B: Shape, X_AB: ArrayLike) -> bool:
    """Tell whether any facet or piece of A touches or crosses one of B.

    Meshes are surfaces, not solids: a body wholly inside another does not intersect it. Pieces are
    solid.

    Parameters
    ----------
    X_AB
        (4, 4) pose of B in A.
    """
    return _core.intersects(A._core, B._core, as_pose(X_AB))


def witness_pairs(
    A: CollisionMesh,
    B: CollisionMesh,
    X_AB: ArrayLike,
    standoff: float,
    *,
    merge: bool = True,
    threads: int = 1,
) -> WitnessPairs:
    """Find every pair of facets at most `standoff` apart, with their closest points.

    None is missed: the rows are those of a test of all facets of A against all of B. Their order is
    fixed by the meshes and the pose alone, and the same on any number of threads.

    Parameters
    ----------
    X_AB
        (4, 4) pose of B in A.
    standoff
        [m], at least 0.
    merge
        Give one row, with its count as `multiplicity`, for all facet pairs whose closest points
        lie on the same two features: two neighbouring facets whose closest point is their common
        vertex are one contact, not two.
    threads
        Number of threads to work on.
    """
    _require_standoff(standoff)
    if threads < 1:
        raise ValueError(f"threads must be at least 1, not {threads}")
    return WitnessPairs(
        _core.witness_pairs(A._core, B._core, as_pose(X_AB), standoff, merge, threads)
    )


class WitnessCache:
    """`witness_pairs` along a motion, several times faster while the pose changes little.

    Facet pairs are gathered once within a slack beyond the standoff; as long as no point of B has
    moved through the slack, only they are tested. The first query, and those where the pose moves
    so fast that gathering would not pay, are answered from scratch. The rows are those of
    `witness_pairs` bit for bit. After some queries the next ones allocate nothing, but for the
    array objects of the columns that are read; gathering does. Not to be shared between threads.

    Parameters
    ----------
    slack
        [m], positive; by default the wider the faster the motion is, up to a quarter of the
        standoff.
    """

    def __init__(self, A: CollisionMesh, B: CollisionMesh, *, slack: float | None = None) -> None:
        if slack is not None and not (np.isfinite(slack) and slack > 0):
            raise ValueError(f"slack must be a positive length, not {slack}")
        self._core = _core.WitnessCache(A._core, B._core, slack or 0.0)

    def witness_pairs(
        self, X_AB: ArrayLike, standoff: float, *, merge: bool = True
    ) -> WitnessPairs:
        """See the function `witness_pairs`."""
        _require_standoff(standoff)
        return WitnessPairs(self._core.witness_pairs(as_pose(X_AB), standoff, merge))

    @property
    def gathered(self) -> int:
        """How often facet pairs had to be gathered anew."""
        return self._core.gathered

    @property
    def measured(self) -> int:
        """How many gathered facet pairs the last query could not settle by features it knew."""
        return self._core.measured


def _require_standoff(standoff: float) -> None:
    if not (math.isfinite(standoff) and standoff >= 0):
        raise ValueError(f"standoff must be a finite length of at least 0 m, not {standoff}")


def as_pose(X: ArrayLike, name: str = "X_AB") -> NDArray[np.float64]:
    """Return a pose as a contiguous (4, 4) array; raise ValueError unless it is rigid."""
    pose = np.ascontiguousarray(X, dtype=np.float64)
    if pose.shape != (4, 4):
        raise ValueError(f"{name} must be a (4, 4) homogeneous matrix, not of shape {pose.shape}")
    _core.check_pose(pose, name)
    return pose
