"""Worst errors of the queries on two single facets, judged in rational arithmetic."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

import numpy as np
import oracle_triangle as exact
from facet_cases import Pairs
from numpy.typing import NDArray

from contact_toolkit import CollisionMesh, distance, witness_pairs


class Answer(NamedTuple):
    """What a query says of a pair: distance and the two witness points, in A."""

    distance: float
    p_ACa: NDArray[np.float64]
    p_ACb: NDArray[np.float64]


def ask_distance(A: CollisionMesh, B: CollisionMesh, X_AB: NDArray[np.float64], _: float) -> Answer:
    found = distance(A, B, X_AB)
    return Answer(found.distance, found.p_ACa, found.p_ACb)


def ask_witness_pairs(
    A: CollisionMesh, B: CollisionMesh, X_AB: NDArray[np.float64], standoff: float
) -> Answer:
    found = witness_pairs(A, B, X_AB, standoff)
    if len(found.distance) != 1:
        return Answer(np.inf, np.zeros(3), np.zeros(3))
    return Answer(found.distance[0], found.p_ACa[0], found.p_ACb[0])


Query = Callable[[CollisionMesh, CollisionMesh, NDArray[np.float64], float], Answer]
QUERIES: dict[str, Query] = {"distance": ask_distance, "witness_pairs": ask_witness_pairs}


@dataclass(frozen=True)
class WorstErrors:
    """The largest errors over a class of cases, as shares of the coordinates' size.

    Attributes
    ----------
    distance
        Reported against exact distance.
    off_facet
        Exact distance of a witness point from its own facet.
    gap
        Distance between the witness points against the reported one: where facets cross, how far
        apart the two points are that should coincide.
    """

    distance: float
    off_facet: float
    gap: float
    pairs: int


def worst_errors(query: Query, pairs: Pairs, rng: np.random.Generator) -> WorstErrors:
    """Ask for each pair as given, and with the second facet in a frame of its own."""
    found = np.array([errors(query, *case) for s, t in pairs for case in _in_two_frames(s, t, rng)])
    return WorstErrors(*found.max(axis=0), len(found))


def _in_two_frames(
    s: NDArray[np.float64], t: NDArray[np.float64], rng: np.random.Generator
) -> Iterator[tuple[NDArray[np.float64], ...]]:
    """The facets in A and in B, and X_AB."""
    yield s, t, np.eye(4)
    X_AB = np.eye(4)
    X_AB[:3, :3], _ = np.linalg.qr(rng.normal(size=(3, 3)))
    X_AB[:3, 3] = rng.uniform(-1, 1, 3) * np.abs(t).max()
    X_AB[:3, :3] *= np.sign(np.linalg.det(X_AB[:3, :3]))
    yield s, (t - X_AB[:3, 3]) @ X_AB[:3, :3], X_AB


def errors(
    query: Query, s: NDArray[np.float64], t: NDArray[np.float64], X_AB: NDArray[np.float64]
) -> tuple[float, float, float]:
    """The three errors of one case, in the order of `WorstErrors`."""
    A, B = (CollisionMesh(corners, [[0, 1, 2]]) for corners in (s, t))
    t_in_a = exact.posed(X_AB, t)
    squared = exact.squared_distance(s, t_in_a)
    size = max(np.abs(s).max(), np.abs(t).max(), np.abs(X_AB[:3, 3]).max())
    answer = query(A, B, X_AB, float(squared) ** 0.5 + 0.01 * size)
    witnesses = exact.squared_distance([answer.p_ACa] * 3, [answer.p_ACb] * 3)
    off_facet = max(
        exact.squared_distance([answer.p_ACa] * 3, s),
        exact.squared_distance([answer.p_ACb] * 3, t_in_a),
    )
    return (
        _relative(answer.distance, squared, size),
        float(off_facet) ** 0.5 / size,
        _relative(answer.distance, witnesses, size),
    )


def _relative(value: float, squared: Fraction, size: float) -> float:
    return exact.error(value, squared) / size if np.isfinite(value) else np.inf
