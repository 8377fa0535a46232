"""ContactModel: springs and forces between many bodies, evaluated natively."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contact_toolkit import _core
from contact_toolkit.contact_pair import ContactGeometry, ContactPair
from contact_toolkit.friction import Friction
from contact_toolkit.queries import as_pose

Floats = NDArray[np.float64]

ContactArrays = _core.ContactArrays
Forces = _core.Forces
Found = _core.Found
StepTable = _core.StepTable


class ContactStatus(enum.IntFlag):
    """Of a pair, in `ContactArrays.status` and `Found.status`: how far its forces can be trusted.

    Attributes
    ----------
    BEYOND_CAPTURE
        Area web: one is in deeper than half the other's thickness; the force may point the wrong
        way.
    CROSSED
        Area web: an open surface has been passed through, and nothing pushes back. Facet web: the
        surfaces meet, the standoff is used up; its distances have no sign, so the force may point
        the wrong way. (A body wholly inside another meets no facet: the facet web cannot tell.)
    """

    BEYOND_CAPTURE = 1
    CROSSED = 2


class ContactModel:
    """All contact between bodies whose poses are given in a common frame F; immutable.

    Every method is one native call without the interpreter's lock; results are immutable, and the
    same bits on any number of threads. Contact far from F's origin loses no accuracy.

    Parameters
    ----------
    bodies
        Their names, in the order of the pose and velocity arrays.
    geometries
        Meshes fixed to the bodies.
    pairs
        Which geometries may touch; the others ignore each other.
    threads
        How many share the pairs.

    Raises
    ------
    ValueError
        Naming the geometry, pair or parameter that cannot be, and the mend.
    """

    def __init__(
        self,
        bodies: Sequence[str],
        geometries: Sequence[ContactGeometry],
        pairs: Sequence[ContactPair],
        *,
        threads: int = 1,
    ) -> None:
        if threads < 1:
            raise ValueError(f"threads must be at least 1, not {threads}")
        self._bodies = tuple(bodies)
        if len(set(self._bodies)) != len(self._bodies):
            raise ValueError(f"body names must differ from each other: {list(self._bodies)}")
        self._geometries = tuple(geometries)
        self._pairs = tuple(pairs)
        self._geometry_bodies = tuple(_body_index(each, self._bodies) for each in self._geometries)
        webs = _Webs(self._geometries)
        native_pairs = []
        for index, pair in enumerate(self._pairs):
            where = _require_pair(index, pair, self._geometries, self._geometry_bodies)
            try:
                native_pairs.append(_native_pair(pair, webs.make(pair)))
            except ValueError as error:
                raise ValueError(f"{where}: {error}") from error
        native_geometries = [
            _native_geometry(geometry, body)
            for geometry, body in zip(self._geometries, self._geometry_bodies, strict=True)
        ]
        self._native = _core.ContactModel(
            len(self._bodies), native_geometries, native_pairs, threads
        )

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies."""
        return self._bodies

    @property
    def geometries(self) -> tuple[ContactGeometry, ...]:
        """The geometries, as given."""
        return self._geometries

    @property
    def pairs(self) -> tuple[ContactPair, ...]:
        """The pairs, as given."""
        return self._pairs

    @property
    def geometry_bodies(self) -> tuple[int, ...]:
        """Index into `bodies` of the body that each geometry is fixed to."""
        return self._geometry_bodies

    def pair_names(self, pair: int) -> tuple[str, str]:
        """Return the names of the geometries A and B of a pair, such as one of `contacts.pair`."""
        touching = self._pairs[pair]
        return self._geometries[touching.a].name, self._geometries[touching.b].name

    def initial_table(self) -> StepTable:
        """Return the table before the first step: no anchors, nothing lost."""
        return StepTable()

    def find(self, X_FB: Floats, table: StepTable | None = None) -> Found:
        """Find the loaded springs of all pairs; free at the very poses of the table's step.

        Parameters
        ----------
        X_FB
            (nb, 4, 4) poses of the bodies.
        table
            Of the last accepted step.
        """
        return self._native.find(X_FB, table)

    def forces(self, found: Found, V_FB: Floats, table: StepTable | None = None) -> Forces:
        """Compute the forces of springs already found.

        Parameters
        ----------
        found
            From `find`.
        V_FB
            (nb, 6) angular velocity [rad/s], then velocity of the origin [m/s], of each body, in F.
        table
            Of the last accepted step; without it every contact is new.
        """
        return self._native.forces(found, V_FB, table)

    def evaluate(self, X_FB: Floats, V_FB: Floats, table: StepTable | None = None) -> Forces:
        """Find the springs and compute their forces in one call; see `find` and `forces`."""
        return self._native.evaluate(X_FB, V_FB, table)

    def coast(self, table: StepTable, duration: float) -> Forces | None:
        """Compute the forces were bodies to go on for `duration` [s] from the table's step.

        They keep the velocities they had at its end. None before the first step.
        """
        return self._native.coast(table, duration)

    def advance(self, table: StepTable, time: float, forces: Forces) -> StepTable:
        """Take over an accepted step that ended at `time` [s] with `forces`, computed from `table`.

        Taking over the same step again returns the same table. A time before the table's own starts
        afresh.
        """
        return self._native.advance(table, time, forces)


class _Webs:
    """Makes the pairs' webs; what a web prepares for a mesh is shared between its pairs."""

    def __init__(self, geometries: Sequence[ContactGeometry]) -> None:
        self._geometries = geometries
        self._area_bodies: dict[int, _core.AreaBody] = {}

    def make(self, pair: ContactPair) -> _core.SpringWeb:
        if not (np.isfinite(pair.standoff) and pair.standoff >= 0):
            raise ValueError(f"standoff must be finite and not negative, not {pair.standoff}")
        match pair.web:
            case "area":
                return self._area_web(pair)
            case "facet":
                return self._facet_web(pair)
        raise ValueError(f"web must be 'area' or 'facet', not {pair.web!r}")

    def _facet_web(self, pair: ContactPair) -> _core.FacetWeb:
        if pair.standoff == 0:
            raise ValueError("the facet web needs a positive standoff: its distances have no sign")
        return _core.FacetWeb(
            self._mesh(pair.a),
            self._mesh(pair.b),
            pair.damper.k,
            pair.damper.n,
            pair.standoff,
            _choice("weighting", pair.weighting, _core.Weighting),
        )

    def _area_web(self, pair: ContactPair) -> _core.AreaWeb:
        return _core.AreaWeb(
            self._area_body(pair.a),
            self._area_body(pair.b),
            pair.damper.k,
            pair.damper.n,
            pair.standoff,
            _choice("field", pair.field, _core.AreaField),
            pair.resolution,
            _choice("sampled", pair.sampled, _core.AreaSide),
            pair.fillet,
        )

    def _mesh(self, geometry: int) -> _core.Mesh:
        return self._geometries[geometry].mesh._core

    def _area_body(self, geometry: int) -> _core.AreaBody:
        mesh = self._mesh(geometry)
        if id(mesh) not in self._area_bodies:
            self._area_bodies[id(mesh)] = _core.AreaBody(mesh)
        return self._area_bodies[id(mesh)]


def _choice(name: str, value: str, options: Any) -> Any:  # an enumeration and one of its members
    members = options.__members__
    if value not in members:
        raise ValueError(f"{name} must be one of {list(members)}, not {value!r}")
    return members[value]


def _native_geometry(geometry: ContactGeometry, body: int) -> _core.ContactGeometry:
    X_BG = as_pose(geometry.X_BG, f"X_BG of geometry {geometry.name!r}")
    return _core.ContactGeometry(geometry.mesh._core, body, X_BG)


def _native_pair(pair: ContactPair, web: _core.SpringWeb) -> _core.ContactPair:
    friction = pair.friction or Friction()
    native = _core.Friction(
        friction.static,
        friction.dynamic_coefficient,
        friction.stiffness_ratio,
        friction.damping or 0.0,
        1.5 * pair.damper.alpha if friction.damping is None else 0.0,
    )
    return _core.ContactPair(pair.a, pair.b, web, pair.damper.alpha, pair.damper.adhesion, native)


def _body_index(geometry: ContactGeometry, bodies: tuple[str, ...]) -> int:
    if isinstance(geometry.body, str):
        if geometry.body not in bodies:
            raise ValueError(
                f"geometry {geometry.name!r} is fixed to {geometry.body!r}, which is none of the "
                f"bodies {list(bodies)}"
            )
        return bodies.index(geometry.body)
    if not 0 <= geometry.body < len(bodies):
        raise ValueError(
            f"geometry {geometry.name!r} is fixed to body {geometry.body}; there are {len(bodies)}"
        )
    return geometry.body


def _require_pair(
    index: int, pair: ContactPair, geometries: tuple[ContactGeometry, ...], body_of: tuple[int, ...]
) -> str:
    """Check which geometries a pair joins; return how to call it in messages."""
    for geometry in (pair.a, pair.b):
        if not 0 <= geometry < len(geometries):
            raise ValueError(f"pair {index} names geometry {geometry}; there are {len(geometries)}")
    a, b = geometries[pair.a], geometries[pair.b]
    where = f"pair {index} ({a.name!r}, {b.name!r})"
    if body_of[pair.a] == body_of[pair.b]:
        raise ValueError(f"{where}: both are fixed to body {a.body!r}; a body cannot touch itself")
    return where
