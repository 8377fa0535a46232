"""ContactModel: springs and forces between many bodies, evaluated natively."""

from __future__ import annotations

import enum
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contact_toolkit import _core
from contact_toolkit.contact.contact_pair import ContactGeometry, ContactPair
from contact_toolkit.contact.friction import Friction
from contact_toolkit.contact.inside import tell_of_repairs
from contact_toolkit.contact.model_id import model_id
from contact_toolkit.contact.native_webs import NativeWebs
from contact_toolkit.contact.spring_webs import AreaWeb, PointWeb
from contact_toolkit.contact.wrench_slopes import wrench_slopes
from contact_toolkit.query.arguments import as_pose, as_threads

Floats = NDArray[np.float64]

ContactArrays = _core.ContactArrays
Forces = _core.Forces
LoadedSprings = _core.LoadedSprings
ContactState = _core.ContactState
Linearization = _core.Linearization


class ContactStatus(enum.IntFlag):
    """How far a pair's forces can be trusted: `ContactArrays.status`, `LoadedSprings.status`.

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

    The model and all it hands out can be pickled. Models of equal geometries and pairs, in one
    process or in several, take each other's states and springs, and go on with the same bits.

    Parameters
    ----------
    bodies
        Their names, in the order of the pose and velocity arrays.
    geometries
        Meshes fixed to the bodies.
    pairs
        Which geometries may touch; the others ignore each other.
    threads
        How many share the pairs; None: as many as the process may use.

    Raises
    ------
    ValueError
        Naming the geometry, pair or parameter that cannot be, and the mend.

    Examples
    --------
    >>> import numpy as np
    >>> from contact_toolkit import CollisionMesh, ContactGeometry, ContactModel, ContactPair
    >>> from contact_toolkit import NonlinearDamper
    >>> from contact_toolkit.shapes.primitives import box
    >>> cube = CollisionMesh(*box([0.1, 0.1, 0.1]))
    >>> geometries = [ContactGeometry(name, name, cube) for name in ("table", "brick")]
    >>> pair = ContactPair(0, 1, NonlinearDamper(k=1e9))
    >>> model = ContactModel(["table", "brick"], geometries, [pair])
    >>> X_FB = np.tile(np.eye(4), (2, 1, 1))
    >>> X_FB[1, 2, 3] = 0.1 - 1e-5  # on the table, 10 µm deep
    >>> state = model.initial_state()
    >>> forces = model.evaluate(X_FB, np.zeros((2, 6)), state)
    >>> forces.body_wrenches[1, 5].round()  # on the brick, upwards: k A δ [N]
    np.float64(100.0)
    >>> set(forces.contacts.status.tolist()), len(model.find(X_FB)) == len(forces.contacts)
    ({0}, True)
    >>> state = model.advance(state, 0.001, forces)  # the step is accepted: anchors move
    >>> linear = model.linearize(X_FB, np.zeros((2, 6)), state)
    """

    def __init__(
        self,
        bodies: Sequence[str],
        geometries: Sequence[ContactGeometry],
        pairs: Sequence[ContactPair],
        *,
        threads: int | None = 1,
    ) -> None:
        self._bodies = tuple(bodies)
        if len(set(self._bodies)) != len(self._bodies):
            raise ValueError(f"body names must differ from each other: {list(self._bodies)}")
        self._geometries = tuple(geometries)
        self._pairs = tuple(pairs)
        self._geometry_bodies = tuple(_body_index(each, self._bodies) for each in self._geometries)
        webs = NativeWebs(self._geometries)
        native_pairs = []
        for index, pair in enumerate(self._pairs):
            where = _require_pair(index, pair, self._geometries, self._geometry_bodies)
            try:
                native_pairs.append(_native_pair(pair, webs.make(pair)))
            except ValueError as error:
                raise ValueError(f"{where}: {error}") from error
        areas = [pair for pair in self._pairs if isinstance(pair.web, AreaWeb | PointWeb)]
        touched = sorted({side for pair in areas for side in (pair.a, pair.b)})
        tell_of_repairs(tuple(self._geometries[side] for side in touched))
        native_geometries = [
            _native_geometry(geometry, body)
            for geometry, body in zip(self._geometries, self._geometry_bodies, strict=True)
        ]
        self._threads = threads
        self._native = _core.ContactModel(
            len(self._bodies),
            native_geometries,
            native_pairs,
            as_threads(threads),
            model_id(len(self._bodies), self._geometries, self._geometry_bodies, self._pairs),
        )

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle what the model was made of."""
        return _remake, (self._bodies, self._geometries, self._pairs, self._threads)

    def __copy__(self) -> ContactModel:
        """Return itself: immutable."""
        return self

    def __deepcopy__(self, memo: dict[int, object]) -> ContactModel:
        """Return itself: immutable."""
        return self

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

    def initial_state(self) -> ContactState:
        """Return the state before the first step: no anchors, nothing lost."""
        return ContactState()

    def eased_state(self, depths: Floats, start: float, duration: float) -> ContactState:
        """Return a state before the first step in which some pairs do not feel all their depth.

        As much deformation as `depths` says is not felt at first, and less and less of it until
        all is: bodies that overlap are parted at the speed depth / duration, whatever their
        springs, and none is shot away.

        Parameters
        ----------
        depths
            (np,) of each pair [m]; infinite where it shall never be felt.
        start, duration
            When it begins [s], and how long until all is felt, above 0.
        """
        return self._native.eased([float(depth) for depth in depths], start, duration)

    def find(self, X_FB: Floats, state: ContactState | None = None) -> LoadedSprings:
        """Find the loaded springs of all pairs; free at the very poses of the state's step.

        Parameters
        ----------
        X_FB
            (nb, 4, 4) poses of the bodies.
        state
            Of the last accepted step.
        """
        return self._native.find(X_FB, state)

    def forces(
        self, loaded: LoadedSprings, V_FB: Floats, state: ContactState | None = None
    ) -> Forces:
        """Compute the forces of springs already found.

        Parameters
        ----------
        loaded
            From `find`.
        V_FB
            (nb, 6) angular velocity [rad/s], then velocity of the origin [m/s], of each body, in F.
        state
            Of the last accepted step; without it every contact is new.
        """
        return self._native.forces(loaded, V_FB, state)

    def evaluate(self, X_FB: Floats, V_FB: Floats, state: ContactState | None = None) -> Forces:
        """Find the springs and compute their forces in one call; see `find` and `forces`."""
        return self._native.evaluate(X_FB, V_FB, state)

    def linearize(
        self,
        X_FB: Floats,
        V_FB: Floats,
        state: ContactState | None = None,
        *,
        symmetric: bool = False,
    ) -> Linearization:
        """Differentiate the forces by poses and velocities: a stiffness and a damping per pair.

        They are the derivatives of what `evaluate` computes with the same arguments, at the same
        contacts and the state's anchors; see `Linearization` for shapes, units and frames. Where a
        node crosses from one feature to the next, or a spring begins to slip, forces have a kink,
        and this is the derivative on the side where the pose is.

        Parameters
        ----------
        X_FB
            (nb, 4, 4) poses of the bodies.
        V_FB
            (nb, 6) angular velocity [rad/s], then velocity of the origin [m/s], of each body, in F.
        state
            Of the last accepted step; without it every contact is new.
        symmetric
            Leave out that sliding friction follows the normal force, and take the symmetric part of
            the rest, about the origin of the geometry A: for solvers that need it.
        """
        return self._native.linearize(X_FB, V_FB, state, symmetric)

    def differentiate(
        self,
        X_FB: Floats,
        V_FB: Floats,
        dX_FB: Floats,
        dV_FB: Floats,
        state: ContactState | None = None,
    ) -> Floats:
        """Differentiate the wrenches on all bodies along motions, at the state's anchors.

        What `linearize` says of each pair, added up over the bodies as all of them move.

        Parameters
        ----------
        X_FB
            (nb, 4, 4) poses of the bodies.
        V_FB
            (nb, 6) angular velocity [rad/s], then velocity of the origin [m/s], of each body, in F.
        dX_FB
            (nb, 6, n) n motions: how each body turns [rad], then how its origin moves [m], in F.
        dV_FB
            (nb, 6, n) how `V_FB` changes with them.
        state
            Of the last accepted step; without it every contact is new.

        Returns
        -------
        Floats
            (nb, 6, n) changes of `Forces.body_wrenches`.

        Raises
        ------
        ValueError
            For motions of another shape.
        """
        shape = (len(X_FB), 6, dX_FB.shape[-1])
        for name, motions in (("dX_FB", dX_FB), ("dV_FB", dV_FB)):
            if motions.shape != shape:
                raise ValueError(f"{name} must be (nb, 6, n), here {shape}, and is {motions.shape}")
        linear = self.linearize(X_FB, V_FB, state)
        return wrench_slopes(linear, X_FB, V_FB, dX_FB, dV_FB)

    def coast(self, state: ContactState, duration: float) -> Forces | None:
        """Compute the forces were bodies to go on for `duration` [s] from the state's step.

        They keep the velocities they had at its end. None before the first step.
        """
        return self._native.coast(state, duration)

    def advance(self, state: ContactState, time: float, forces: Forces) -> ContactState:
        """Take over an accepted step that ended at `time` [s] with `forces`, computed from `state`.

        Taking over the same step again returns the same state. A time before the state's own starts
        afresh.
        """
        return self._native.advance(state, time, forces)

    def advance_implicitly(self, state: ContactState, time: float, forces: Forces) -> ContactState:
        """Take over a step solved implicitly: `forces`, at its end at `time` [s], acted all along.

        What such a step takes beyond the law goes to `ContactState.numerical_loss`.
        """
        return self._native.advance_implicitly(state, time, forces)


def _remake(
    bodies: tuple[str, ...],
    geometries: tuple[ContactGeometry, ...],
    pairs: tuple[ContactPair, ...],
    threads: int | None,
) -> ContactModel:
    return ContactModel(bodies, geometries, pairs, threads=threads)


def _native_geometry(geometry: ContactGeometry, body: int) -> _core.ContactGeometry:
    X_BG = as_pose(geometry.X_BG, f"X_BG of geometry {geometry.name!r}")
    return _core.ContactGeometry(geometry.name, geometry.mesh._core, body, X_BG)


def _native_pair(pair: ContactPair, web: _core.SpringWeb) -> _core.ContactPair:
    friction, damper = pair.friction or Friction(), pair.damper
    native = _core.Friction(
        friction.static,
        friction.dynamic_coefficient,
        friction.stiffness_ratio,
        friction.damping or 0.0,
        1.5 * damper.alpha if friction.damping is None else 0.0,
    )
    law = damper.alpha, damper.adhesion, damper.settling, damper.smallest
    return _core.ContactPair(pair.a, pair.b, web, *law, native)


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
