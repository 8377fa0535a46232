"""Classify batches of configurations, and the motions between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contact_toolkit.cspace.model import CSpaceClass, CSpaceModel
from contact_toolkit.query.arguments import as_standoff, as_threads, as_upper_bounds
from contact_toolkit.query.batch import distance_batch
from contact_toolkit.query.swept_batch import swept_distance_batch
from contact_toolkit.shapes.mesh import Floats, Ints


@dataclass(frozen=True)
class Classification:
    """What n configurations are, and why.

    Attributes
    ----------
    kind
        (n,) values of `CSpaceClass`.
    distance
        (n,) least distance of any pair [m]; 0 when colliding, infinite beyond the upper bound.
    pair
        (n,) index into the model's pairs of the closest pair; -1 beyond the upper bound.
    p_FCa, p_FCb
        (n, 3) closest points of the pair's geometries, in F [m]; one point when colliding.
    """

    kind: NDArray[np.int8]
    distance: Floats
    pair: Ints
    p_FCa: Floats
    p_FCb: Floats

    def __len__(self) -> int:
        return len(self.kind)


@dataclass(frozen=True)
class MotionClassification:
    """What n motions are, and why; row i is the motion from configuration i to i + 1.

    Attributes
    ----------
    kind
        (n,) values of `CSpaceClass`.
    distance
        (n,) least distance of any pair [m], certified from below; 0 when colliding, infinite beyond
        the upper bound.
    pair
        (n,) index into the model's pairs of the closest pair; -1 beyond the upper bound.
    time
        (n,) fraction of the motion done when that pair is closest.
    """

    kind: NDArray[np.int8]
    distance: Floats
    pair: Ints
    time: Floats

    def __len__(self) -> int:
        return len(self.kind)


def classify(
    model: CSpaceModel,
    X_FB: ArrayLike,
    *,
    standoff: float = 0.0,
    upper_bound: float = np.inf,
    threads: int | None = 1,
) -> Classification:
    """Tell of each configuration whether it is free, within the standoff, or colliding.

    Solids count as solid: one inside another collides with it, though their surfaces do not meet.

    Parameters
    ----------
    X_FB
        (n, nb, 4, 4) poses of the model's bodies in a common frame F, one row a configuration.
    standoff
        [m], at least 0; pairs no farther apart are near.
    upper_bound
        [m], at least the standoff; distances beyond are of no interest, which saves time.
    threads
        How many share the work; None: as many as the process may use.

    Examples
    --------
    >>> import numpy as np
    >>> from contact_toolkit import CollisionMesh, CSpaceClass, CSpaceModel, classify
    >>> from contact_toolkit.shapes.primitives import box
    >>> cube = CollisionMesh(*box([0.1, 0.1, 0.1]))
    >>> model = CSpaceModel.from_shapes({"part": cube, "wall": cube})
    >>> X_FB = np.tile(np.eye(4), (3, 2, 1, 1))  # three configurations of two bodies
    >>> X_FB[:, 0, 0, 3] = 0.05, 0.105, 0.2
    >>> found = classify(model, X_FB, standoff=0.01)
    >>> [CSpaceClass(kind).name for kind in found.kind]
    ['COLLIDING', 'NEAR', 'FREE']
    """
    poses = model.as_configurations(X_FB)
    best = _Best(len(poses), _checked_bound(standoff, upper_bound))
    p_FCa, p_FCb = np.zeros((len(poses), 3)), np.zeros((len(poses), 3))
    threads = as_threads(threads)
    for index, (a, b) in enumerate(model.pairs):
        X_FA, X_AB = _relative(model, poses, a, b)
        found = distance_batch(
            model._shapes[a],
            model._shapes[b],
            X_AB,
            upper_bound=best.distance,
            threads=threads,
        )
        p_ACa, p_ACb = found.p_ACa.copy(), found.p_ACb.copy()
        distance = found.distance.copy()
        wanted = (best.distance > 0) & (distance > 0)
        rows, p_AC = _find_inside(model, index, X_AB, wanted, threads)
        p_ACa[rows] = p_ACb[rows] = p_AC
        distance[rows] = 0
        better = best.improve(distance, index)
        for p_FC, p_AC in ((p_FCa, p_ACa), (p_FCb, p_ACb)):
            p_FC[better] = _transform(X_FA[better], p_AC[better])
    return Classification(best.kind(standoff), best.distance_found(), best.pair, p_FCa, p_FCb)


def classify_motions(
    model: CSpaceModel,
    X_FB: ArrayLike,
    *,
    standoff: float = 0.0,
    tolerance: float | None = None,
    upper_bound: float = np.inf,
    threads: int | None = 1,
) -> MotionClassification:
    """Tell of the motion between each configuration and the next what `classify` tells of one.

    The origins of the bodies move straight while the bodies turn about fixed axes (see
    `swept_distance`); if both bodies of a pair turn, it is their relative motion that is so.
    Nothing between the configurations is missed: with rotation, what comes within the tolerance of
    a collision is called one.

    Parameters
    ----------
    X_FB
        (n + 1, nb, 4, 4) poses of the model's bodies in a common frame F.
    standoff
        [m], at least 0; pairs no farther apart are near.
    tolerance
        [m] on distances of motions with rotation; by default a millionth of the smaller shape.
    upper_bound
        [m], at least the standoff; distances beyond are of no interest, which saves time.
    threads
        How many share the work; None: as many as the process may use.

    Examples
    --------
    >>> import numpy as np
    >>> from contact_toolkit import CollisionMesh, CSpaceClass, CSpaceModel, classify_motions
    >>> from contact_toolkit.shapes.primitives import box
    >>> cube = CollisionMesh(*box([0.1, 0.1, 0.1]))
    >>> model = CSpaceModel.from_shapes({"part": cube, "wall": cube})
    >>> X_FB = np.tile(np.eye(4), (3, 2, 1, 1))
    >>> X_FB[:, 0, 0, 3] = -0.3, 0.3, 0.6  # through the wall, then away from it
    >>> found = classify_motions(model, X_FB)
    >>> [CSpaceClass(kind).name for kind in found.kind]
    ['COLLIDING', 'FREE']
    """
    poses = model.as_configurations(X_FB)
    count = max(len(poses) - 1, 0)
    best = _Best(count, _checked_bound(standoff, upper_bound))
    time = np.zeros(count)
    threads = as_threads(threads)
    turn = np.abs(np.diff(poses[:, :, :3, :3], axis=0)).max(axis=(2, 3), initial=0)
    for index, (a, b) in enumerate(model.pairs):
        distance, when = np.full(count, np.inf), np.zeros(count)
        # Seen from the body that does not turn, or turns less.
        a_turns = turn[:, model._body_of[a]] > turn[:, model._body_of[b]]
        for rows, seen, moving in ((~a_turns, a, b), (a_turns, b, a)):
            _, X = _relative(model, poses, seen, moving)
            found = swept_distance_batch(
                model._shapes[seen],
                model._shapes[moving],
                X[:-1][rows],
                X[1:][rows],
                tolerance=tolerance,
                upper_bound=best.distance[rows],
                threads=threads,
            )
            distance[rows], when[rows] = found.distance, found.time
        # What starts outside cannot come inside but through the surface.
        _, X_AB = _relative(model, poses[:-1], a, b)
        wanted = (best.distance > 0) & (distance > 0)
        rows, _ = _find_inside(model, index, X_AB, wanted, threads)
        distance[rows], when[rows] = 0, 0
        better = best.improve(distance, index)
        time[better] = when[better]
    return MotionClassification(best.kind(standoff), best.distance_found(), best.pair, time)


class _Best:
    """The least distance so far in each row, and the pair it belongs to."""

    def __init__(self, rows: int, upper_bound: float) -> None:
        self.distance = as_upper_bounds(upper_bound, rows)
        self.pair = np.full(rows, -1, dtype=np.int32)

    def improve(self, distance: Floats, pair: int) -> NDArray[np.bool_]:
        """Take over smaller distances; return where."""
        better = np.isfinite(distance) & (
            (distance < self.distance) | ((self.pair < 0) & (distance <= self.distance))
        )
        self.distance[better] = distance[better]
        self.pair[better] = pair
        return better

    def distance_found(self) -> Floats:
        return np.where(self.pair < 0, np.inf, self.distance)

    def kind(self, standoff: float) -> NDArray[np.int8]:
        distance = self.distance_found()
        near = np.where(distance <= standoff, CSpaceClass.NEAR, CSpaceClass.FREE)
        return np.where(distance == 0, CSpaceClass.COLLIDING, near).astype(np.int8)


def _checked_bound(standoff: float, upper_bound: float) -> float:
    standoff = as_standoff(standoff)
    if not upper_bound >= standoff:
        raise ValueError(f"upper_bound must be at least the standoff {standoff}, not {upper_bound}")
    return upper_bound


def _relative(model: CSpaceModel, X_FB: Floats, a: int, b: int) -> tuple[Floats, Floats]:
    """Return the poses (n, 4, 4) of geometry a's body in F, and of geometry b's body in that."""
    X_FA, X_FC = X_FB[:, model._body_of[a]], X_FB[:, model._body_of[b]]
    R_AF = X_FA[:, :3, :3].transpose(0, 2, 1)
    X_AB = np.zeros_like(X_FA)
    X_AB[:, :3, :3] = R_AF @ X_FC[:, :3, :3]
    X_AB[:, :3, 3] = np.einsum("nij,nj->ni", R_AF, X_FC[:, :3, 3] - X_FA[:, :3, 3])
    X_AB[:, 3, 3] = 1
    return X_FA, X_AB


def _find_inside(
    model: CSpaceModel, pair: int, X_AB: Floats, wanted: NDArray[np.bool_], threads: int
) -> tuple[NDArray[np.intp], Floats]:
    """Return the wanted rows where one shape is inside the other, and a point of both, in A."""
    b_in_a, a_in_b = model._inside[pair]
    rows = np.nonzero(wanted)[0]
    X_AB = X_AB[rows]
    inside, p_A = b_in_a.find(X_AB, threads)
    X_BA = X_AB.copy()
    X_BA[:, :3, :3] = X_AB[:, :3, :3].transpose(0, 2, 1)
    X_BA[:, :3, 3] = -np.einsum("nij,nj->ni", X_BA[:, :3, :3], X_AB[:, :3, 3])
    other, p_B = a_in_b.find(X_BA, threads)
    points = np.where(inside[:, None], p_A, _transform(X_AB, p_B))
    either = inside | other
    return rows[either], points[either]


def _transform(X: Floats, p: Floats) -> Floats:
    moved: Floats = np.einsum("nij,nj->ni", X[:, :3, :3], p) + X[:, :3, 3]
    return moved
