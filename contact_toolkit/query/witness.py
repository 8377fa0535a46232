"""Distance, interference and witness pairs between two shapes at a relative pose.

Every query takes `X_AB`, the pose of B in A as a (4, 4) homogeneous matrix, and answers in frame A.
"""

from __future__ import annotations

from enum import IntEnum
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contact_toolkit import _core
from contact_toolkit.query.arguments import (
    as_pose,
    as_standoff,
    as_threads,
    as_upper_bound,
    core_of,
)
from contact_toolkit.shapes.convex_pieces import Shape
from contact_toolkit.shapes.mesh import CollisionMesh, Floats, Ints


class FeatureKind(IntEnum):
    """What a feature is; a feature is (kind, index)."""

    VERTEX = 0
    """Index into the mesh's vertices."""
    EDGE = 1
    """Index into its edges."""
    FACET = 2
    """Index into its faces."""
    PIECE = 3
    """Index into the pieces of a `ConvexPieces`."""


class ClosestPair:
    """The closest points of two shapes.

    Arrays are made whenever one is asked for.
    """

    __slots__ = ("_pair",)

    def __init__(self, pair: _core.ClosestPair) -> None:
        self._pair = pair

    def __reduce__(self) -> tuple[type[ClosestPair], tuple[SimpleNamespace]]:
        fields = {name: getattr(self, name) for name in _PAIR_FIELDS}
        return ClosestPair, (SimpleNamespace(**fields),)

    def __repr__(self) -> str:
        fields = (f"{name}={getattr(self, name)!r}" for name in _PAIR_FIELDS)
        return f"ClosestPair({', '.join(fields)})"

    @property
    def distance(self) -> float:
        """Between the two points [m].

        Infinite when nothing lies below the upper bound asked for: no other field then means
        anything.
        """
        return self._pair.distance

    @property
    def p_ACa(self) -> Floats:
        """(3,) witness point on A, in A [m]."""
        return self._pair.p_ACa

    @property
    def p_ACb(self) -> Floats:
        """(3,) witness point on B, in A [m]; that on A where surfaces cross."""
        return self._pair.p_ACb

    @property
    def normal_A(self) -> Floats:
        """(3,) unit vector from B towards A.

        Where the distance is zero, by the facets' windings, or zero if one shape is made of pieces.
        """
        return self._pair.normal_A

    @property
    def facet_a(self) -> int:
        """The facet, or the piece, of A."""
        return self._pair.facet_a

    @property
    def facet_b(self) -> int:
        """The facet, or the piece, of B."""
        return self._pair.facet_b

    @property
    def feature_a(self) -> tuple[FeatureKind, int]:
        """(kind, index) on A, kind a `FeatureKind`.

        If one shape is made of pieces: `PIECE` there, and always `FACET` on a mesh opposite.
        """
        kind, index = self._pair.feature_a
        return FeatureKind(kind), index

    @property
    def feature_b(self) -> tuple[FeatureKind, int]:
        """(kind, index) on B, likewise."""
        kind, index = self._pair.feature_b
        return FeatureKind(kind), index


_PAIR_FIELDS = [name for name, value in vars(ClosestPair).items() if isinstance(value, property)]


class WitnessPairs:
    """Facet pairs closer than a standoff, one row each; see `witness_pairs`.

    The columns are read-only arrays: views of the rows, made whenever one is asked for.
    """

    __slots__ = ("_rows",)

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
        """(n, 2) `FeatureKind` and index of the feature of A the witness point lies on."""
        return self._rows.feature_a

    @property
    def feature_b(self) -> Ints:
        """(n, 2) `FeatureKind` and index of the feature of B the witness point lies on."""
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

    Raises
    ------
    ValueError
        If `X_AB` is no rigid pose, telling what is wrong with it, or `upper_bound` is negative.

    Examples
    --------
    >>> import numpy as np
    >>> from contact_toolkit import CollisionMesh, distance
    >>> from contact_toolkit.shapes.primitives import box
    >>> cube = CollisionMesh(*box([0.1, 0.1, 0.1]))
    >>> X_AB = np.eye(4)
    >>> X_AB[:3, 3] = 0.12, 0.0, 0.03
    >>> closest = distance(cube, cube, X_AB)
    >>> round(closest.distance, 12)
    0.02
    >>> closest.normal_A.round(12) + 0.0  # from B towards A
    array([-1.,  0.,  0.])
    >>> distance(cube, cube, X_AB, upper_bound=0.01).distance
    inf
    """
    return ClosestPair(
        _core.distance(core_of(A, "A"), core_of(B, "B"), as_pose(X_AB), as_upper_bound(upper_bound))
    )


def intersects(A: Shape, B: Shape, X_AB: ArrayLike) -> bool:
    """Tell whether any facet or piece of A touches or crosses one of B.

    Meshes are surfaces, not solids: a body wholly inside another does not intersect it. Pieces are
    solid.

    Parameters
    ----------
    X_AB
        (4, 4) pose of B in A.

    Raises
    ------
    ValueError
        If `X_AB` is no rigid pose, telling what is wrong with it.

    Examples
    --------
    >>> import numpy as np
    >>> from contact_toolkit import CollisionMesh, intersects
    >>> from contact_toolkit.shapes.primitives import box
    >>> cube = CollisionMesh(*box([0.1, 0.1, 0.1]))
    >>> X_AB = np.eye(4)
    >>> X_AB[:3, 3] = 0.09, 0.0, 0.03
    >>> intersects(cube, cube, X_AB)
    True
    """
    return _core.intersects(core_of(A, "A"), core_of(B, "B"), as_pose(X_AB))


def witness_pairs(
    A: CollisionMesh,
    B: CollisionMesh,
    X_AB: ArrayLike,
    standoff: float,
    *,
    merge: bool = True,
    threads: int | None = 1,
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
        How many share the work; None: as many as the process may use.

    Raises
    ------
    ValueError
        If `X_AB` is no rigid pose, telling what is wrong with it, `standoff` is negative or not
        finite, or `threads` is not positive.

    Examples
    --------
    >>> import numpy as np
    >>> from contact_toolkit import CollisionMesh, witness_pairs
    >>> from contact_toolkit.shapes.primitives import box
    >>> cube = CollisionMesh(*box([0.1, 0.1, 0.1]))
    >>> X_AB = np.eye(4)
    >>> X_AB[:3, 3] = 0.105, 0.0, 0.0
    >>> pairs = witness_pairs(cube, cube, X_AB, standoff=0.01)
    >>> bool((pairs.distance.round(12) == 0.005).all())
    True
    >>> len(witness_pairs(cube, cube, X_AB, standoff=0.001))
    0
    """
    return WitnessPairs(
        _core.witness_pairs(
            core_of(A, "A"),
            core_of(B, "B"),
            as_pose(X_AB),
            as_standoff(standoff),
            merge,
            as_threads(threads),
        )
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

    Raises
    ------
    ValueError
        If `slack` is not a positive length.

    Examples
    --------
    >>> import numpy as np
    >>> from contact_toolkit import CollisionMesh, WitnessCache
    >>> from contact_toolkit.shapes.primitives import box
    >>> cube = CollisionMesh(*box([0.1, 0.1, 0.1]))
    >>> X_AB = np.eye(4)
    >>> cache = WitnessCache(cube, cube)
    >>> for X_AB[0, 3] in np.linspace(0.11, 0.105, 100):
    ...     pairs = cache.witness_pairs(X_AB, standoff=0.01)
    >>> cache.gathered < 10
    True
    """

    def __init__(self, A: CollisionMesh, B: CollisionMesh, *, slack: float | None = None) -> None:
        if slack is not None and not (np.isfinite(slack) and slack > 0):
            raise ValueError(f"slack must be a positive length, not {slack}")
        self._core = _core.WitnessCache(core_of(A, "A"), core_of(B, "B"), slack or 0.0)

    def witness_pairs(
        self, X_AB: ArrayLike, standoff: float, *, merge: bool = True
    ) -> WitnessPairs:
        """See the function `witness_pairs`."""
        return WitnessPairs(self._core.witness_pairs(as_pose(X_AB), as_standoff(standoff), merge))

    @property
    def gathered(self) -> int:
        """How often facet pairs had to be gathered anew."""
        return self._core.gathered

    @property
    def measured(self) -> int:
        """How many gathered facet pairs the last query could not settle by features it knew."""
        return self._core.measured
