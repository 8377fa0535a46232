"""Bodies whose configurations, and motions between them, are classified; see `classify`.

Lozano-Pérez, "Spatial planning: a configuration space approach", IEEE Transactions on Computers
C-32(2), 1983.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from contact_toolkit.cspace.inside_test import InsideTest
from contact_toolkit.query.arguments import as_pose, as_poses
from contact_toolkit.shapes.convex_pieces import ConvexPieces, Shape
from contact_toolkit.shapes.mesh import CollisionMesh, Floats


class CSpaceClass(IntEnum):
    """What a configuration or a motion is."""

    FREE = 0
    """No pair within the standoff."""
    NEAR = 1
    """A pair within the standoff, none touching."""
    COLLIDING = 2
    """A pair touching, or one solid inside another."""


@dataclass(frozen=True)
class CSpaceGeometry:
    """A shape fixed in a body.

    Attributes
    ----------
    name
        For messages; unique in its model.
    body
        The body's name.
    shape
        A `CollisionMesh` or `ConvexPieces`, in its own frame G. A mesh is solid if it is closed and
        wound outwards, else a surface.
    X_BG
        (4, 4) pose of the shape in the body; the identity by default.
    """

    name: str
    body: str
    shape: Shape
    X_BG: ArrayLike = field(default_factory=lambda: np.eye(4))


class CSpaceModel:
    """Bodies with shapes, and which of their shapes must keep apart; immutable.

    Parameters
    ----------
    bodies
        Names, in the order of the poses given to `classify`.
    geometries
        The shapes.
    pairs
        Indices of geometries on two different bodies to be checked against each other; by default
        all.

    Raises
    ------
    ValueError
        Naming the first bad argument.

    Examples
    --------
    >>> import numpy as np
    >>> from contact_toolkit import CSpaceGeometry, CSpaceModel, CollisionMesh
    >>> from contact_toolkit.shapes.primitives import box
    >>> cube = CollisionMesh(*box([0.1, 0.1, 0.1]))
    >>> X_BG = np.eye(4)
    >>> X_BG[0, 3] = 0.1
    >>> parts = [CSpaceGeometry("near", "arm", cube), CSpaceGeometry("far", "arm", cube, X_BG)]
    >>> CSpaceModel(["arm", "wall"], [*parts, CSpaceGeometry("wall", "wall", cube)]).pairs
    ((0, 2), (1, 2))
    """

    def __init__(
        self,
        bodies: Sequence[str],
        geometries: Sequence[CSpaceGeometry],
        pairs: Iterable[tuple[int, int]] | None = None,
    ) -> None:
        self._bodies = tuple(bodies)
        self._geometries = tuple(geometries)
        _require_unique(self._bodies, "body")
        _require_unique([geometry.name for geometry in geometries], "geometry")
        rows = {name: row for row, name in enumerate(self._bodies)}
        for geometry in geometries:
            if geometry.body not in rows:
                raise ValueError(
                    f"geometry {geometry.name!r} is on {geometry.body!r}, no body here"
                )
        self._body_of = tuple(rows[geometry.body] for geometry in geometries)
        self._pairs = self._checked_pairs(pairs)
        # In the bodies' frames, so that a body's origin moves straight, wherever its shapes are.
        self._shapes = tuple(_in_body(geometry) for geometry in geometries)
        self._inside = tuple(
            (
                InsideTest(self._shapes[a], self._shapes[b]),
                InsideTest(self._shapes[b], self._shapes[a]),
            )
            for a, b in self._pairs
        )

    @classmethod
    def from_shapes(
        cls,
        shapes: Mapping[str, Shape | Sequence[Shape]],
        pairs: Iterable[tuple[str, str]] | None = None,
    ) -> CSpaceModel:
        """Build a model of bodies that are each a shape, or several, in the body's own frame.

        `pairs` are names of bodies to be checked against each other; by default all.
        """
        geometries = []
        for body, given in shapes.items():
            parts = [given] if isinstance(given, CollisionMesh | ConvexPieces) else list(given)
            for i, shape in enumerate(parts):
                name = body if len(parts) == 1 else f"{body}[{i}]"
                geometries.append(CSpaceGeometry(name, body, shape))
        if pairs is None:
            return cls(list(shapes), geometries)
        of: dict[str, list[int]] = {body: [] for body in shapes}
        for index, geometry in enumerate(geometries):
            of[geometry.body].append(index)
        chosen = []
        for a, b in pairs:
            for name in (a, b):
                if name not in of:
                    raise ValueError(f"pair ({a!r}, {b!r}): there is no body {name!r}")
            chosen += [(i, k) for i in of[a] for k in of[b]]
        return cls(list(shapes), geometries, chosen)

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies, in the order of the poses given to `classify`."""
        return self._bodies

    @property
    def geometries(self) -> tuple[CSpaceGeometry, ...]:
        """The shapes."""
        return self._geometries

    @property
    def pairs(self) -> tuple[tuple[int, int], ...]:
        """Pairs of indices into `geometries` that are checked."""
        return self._pairs

    def as_configurations(self, X_FB: ArrayLike) -> Floats:
        """Return body poses as a contiguous (n, nb, 4, 4) array; ValueError unless rigid."""
        poses = np.ascontiguousarray(X_FB, dtype=np.float64)
        shape = (len(self._bodies), 4, 4)
        if poses.ndim != 4 or poses.shape[1:] != shape:
            raise ValueError(f"X_FB must have shape (n, {shape[0]}, 4, 4), not {poses.shape}")
        return as_poses(poses.reshape(-1, 4, 4), "X_FB (bodies in sequence)").reshape(poses.shape)

    def _checked_pairs(
        self, pairs: Iterable[tuple[int, int]] | None
    ) -> tuple[tuple[int, int], ...]:
        count = len(self._geometries)
        chosen = list(combinations(range(count), 2)) if pairs is None else list(pairs)
        if pairs is None:
            chosen = [(a, b) for a, b in chosen if self._body_of[a] != self._body_of[b]]
        for a, b in chosen:
            if not (0 <= a < count and 0 <= b < count):
                raise ValueError(f"pair ({a}, {b}): there are {count} geometries")
            if self._body_of[a] == self._body_of[b]:
                raise ValueError(
                    f"pair ({a}, {b}): {self._geometries[a].name!r} and "
                    f"{self._geometries[b].name!r} are both on {self._geometries[a].body!r}"
                )
        if not chosen:
            raise ValueError("no pair to check: give geometries on at least two bodies")
        return tuple(chosen)


def _in_body(geometry: CSpaceGeometry) -> Shape:
    X_BG = as_pose(geometry.X_BG, f"X_BG of {geometry.name!r}")
    if np.array_equal(X_BG, np.eye(4)):
        return geometry.shape

    def move(points: Floats) -> Floats:
        moved: Floats = points @ X_BG[:3, :3].T + X_BG[:3, 3]
        return moved

    if isinstance(geometry.shape, ConvexPieces):
        return ConvexPieces([move(piece) for piece in geometry.shape.pieces])
    return CollisionMesh(move(geometry.shape.vertices), geometry.shape.faces)


def _require_unique(names: Sequence[str], what: str) -> None:
    for i, name in enumerate(names):
        if name in names[:i]:
            raise ValueError(f"two {what} names are {name!r}")
