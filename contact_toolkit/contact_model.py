"""ContactModel: springs and forces between many bodies, evaluated natively."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contact_toolkit import _core
from contact_toolkit.contact_law import NonlinearDamper
from contact_toolkit.mesh import CollisionMesh

Floats = NDArray[np.float64]

ContactArrays = _core.ContactArrays
Forces = _core.Forces
Found = _core.Found
StepTable = _core.StepTable

# [-] How far a pose's rotation may be from orthonormal.
_ROTATION_TOLERANCE = 1e-9


@dataclass(frozen=True)
class ContactGeometry:
    """A mesh fixed to a body.

    Parameters
    ----------
    name
        For messages.
    body
        Name of the body, or its index.
    mesh
        The surface, in the geometry's own frame G.
    X_BG
        (4, 4) pose of G in the body frame B.
    """

    name: str
    body: str | int
    mesh: CollisionMesh
    X_BG: Floats = field(default_factory=lambda: np.eye(4))


@dataclass(frozen=True)
class ContactPair:
    """Two geometries that may touch, and by what law.

    Parameters
    ----------
    a, b
        Indices of the geometries, on different bodies.
    damper
        The law of the springs; its `k` in the unit the web asks for.
    web
        "facet": a spring for every witness pair; "area": an elastic foundation.
    standoff
        Distance [m] at which contact begins: positive for the facet web.
    weighting
        Of the facet web's springs: "multiplicity" (each merged witness pair counts as often as the
        facet pairs behind it: continuous and conservative) or "unit" (once, as published).
    """

    a: int
    b: int
    damper: NonlinearDamper
    web: Literal["area", "facet"] = "area"
    standoff: float = 0.0
    weighting: Literal["multiplicity", "unit"] = "multiplicity"


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
        self._body_of = [self._body_index(geometry) for geometry in self._geometries]
        self._native = _core.ContactModel(
            len(self._bodies),
            [
                _core.ContactGeometry(geometry.mesh._core, body, _rigid(geometry))
                for geometry, body in zip(self._geometries, self._body_of, strict=True)
            ],
            [self._native_pair(i) for i in range(len(self._pairs))],
            threads,
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

    def initial_table(self) -> StepTable:
        """Return the table before the first step: no anchors, nothing lost."""
        return StepTable()

    def find(self, X_FB: ArrayLike, table: StepTable | None = None) -> Found:
        """Find the loaded springs of all pairs; free at the very poses of the table's step.

        Parameters
        ----------
        X_FB
            (nb, 4, 4) poses of the bodies.
        table
            Of the last accepted step.
        """
        return self._native.find(X_FB, table)

    def forces(self, found: Found, V_FB: ArrayLike, table: StepTable | None = None) -> Forces:
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

    def evaluate(self, X_FB: ArrayLike, V_FB: ArrayLike, table: StepTable | None = None) -> Forces:
        """Find the springs and compute their forces in one call; see `find` and `forces`."""
        return self._native.evaluate(X_FB, V_FB, table)

    def advance(self, table: StepTable, time: float, forces: Forces) -> StepTable:
        """Take over an accepted step that ended at `time` [s] with `forces`, computed from `table`.

        Taking over the same step again returns the same table. A time before the table's own starts
        afresh.
        """
        return self._native.advance(table, time, forces)

    def _body_index(self, geometry: ContactGeometry) -> int:
        if isinstance(geometry.body, str):
            if geometry.body not in self._bodies:
                raise ValueError(
                    f"geometry {geometry.name!r} is fixed to {geometry.body!r}, which is none of "
                    f"the bodies {list(self._bodies)}"
                )
            return self._bodies.index(geometry.body)
        if not 0 <= geometry.body < len(self._bodies):
            raise ValueError(
                f"geometry {geometry.name!r} is fixed to body {geometry.body}; there are "
                f"{len(self._bodies)}"
            )
        return geometry.body

    def _native_pair(self, index: int) -> _core.ContactPair:
        pair = self._pairs[index]
        for geometry in (pair.a, pair.b):
            if not 0 <= geometry < len(self._geometries):
                raise ValueError(
                    f"pair {index} names geometry {geometry}; there are {len(self._geometries)}"
                )
        a, b = self._geometries[pair.a], self._geometries[pair.b]
        where = f"pair {index} ({a.name!r}, {b.name!r})"
        if self._body_of[pair.a] == self._body_of[pair.b]:
            raise ValueError(
                f"{where}: both are fixed to body {a.body!r}; a body cannot touch itself"
            )
        damper = pair.damper
        if not (np.isfinite(pair.standoff) and pair.standoff >= 0):
            raise ValueError(
                f"{where}: standoff must be finite and not negative, not {pair.standoff}"
            )
        if pair.web != "facet":
            raise ValueError(f"{where}: web must be 'facet', not {pair.web!r}")
        if pair.standoff == 0:
            raise ValueError(
                f"{where}: the facet web needs a positive standoff, its distances have no sign"
            )
        weightings = _core.Weighting.__members__
        if pair.weighting not in weightings:
            raise ValueError(
                f"{where}: weighting must be one of {list(weightings)}, not {pair.weighting!r}"
            )
        web = _core.FacetWeb(
            a.mesh._core,
            b.mesh._core,
            damper.k,
            damper.n,
            pair.standoff,
            weightings[pair.weighting],
        )
        return _core.ContactPair(pair.a, pair.b, web, damper.alpha, damper.adhesion)


def _rigid(geometry: ContactGeometry) -> Floats:
    """X_BG as a contiguous array, or an error that says why it is no pose."""
    X = np.ascontiguousarray(geometry.X_BG, dtype=np.float64)
    if X.shape != (4, 4) or not np.isfinite(X).all():
        raise ValueError(f"geometry {geometry.name!r}: X_BG must be a finite (4, 4) array")
    R = X[:3, :3]
    error = np.abs(R @ R.T - np.eye(3)).max()
    if error > _ROTATION_TOLERANCE or np.linalg.det(R) < 0 or (X[3] != [0, 0, 0, 1]).any():
        raise ValueError(
            f"geometry {geometry.name!r}: X_BG must be a rotation and a translation; scale the "
            f"mesh instead"
        )
    return X
