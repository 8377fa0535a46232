"""Every witness pair, cold, one thread, unmerged, against coal.

Why: finding all facet pairs within the standoff is what every force evaluation begins with, and
what no other engine is built for. coal can be made to do it (a security margin and no limit on
contacts) and is the fastest that can. Both find the very same facet pairs, which is checked first.
Cold means that nothing is remembered from earlier poses.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness import Row, Stopwatch
from benchmarks.mesh_pairs import all_pairs
from benchmarks.yardsticks import Coal
from contact_toolkit import CollisionMesh, witness_pairs

NAME = "witness pairs, cold"
TARGET = 15.0
_COAL_ERROR = 1e-6  # [m] to which coal iterates


def measure(watch: Stopwatch, coarser: int = 1) -> Iterator[Row]:
    """Compare all pairs, standoffs and poses."""
    for pair in all_pairs(coarser):
        A, B = pair.meshes()
        coal = Coal(pair.A, pair.B)
        for standoff in pair.standoffs:
            for name, X_AB in pair.poses.items():
                count = require_same_pairs(A, B, X_AB, standoff, coal)
                yield watch.row(
                    NAME,
                    f"{pair.name}, {1e3 * standoff:g} mm, {name}",
                    partial(witness_pairs, A, B, X_AB, standoff, merge=False),
                    {"coal": partial(coal.witness_pairs, X_AB, standoff)},
                    target=TARGET,
                    size=pair.facets,
                    output=count,
                )


def require_same_pairs(
    A: CollisionMesh, B: CollisionMesh, X_AB: NDArray[np.float64], standoff: float, coal: Coal
) -> int:
    """Return how many facet pairs there are; raise if coal finds others.

    Pairs whose distance is the standoff to within coal's accuracy may be in or out.
    """
    coal.witness_pairs(X_AB, standoff)
    theirs = coal.facets()
    certain, possible, ours = (
        {*zip(rows.facet_a.tolist(), rows.facet_b.tolist(), strict=True)}
        for rows in (
            witness_pairs(A, B, X_AB, reach, merge=False)
            for reach in (standoff - _COAL_ERROR, standoff + _COAL_ERROR, standoff)
        )
    )
    if missing := certain - theirs:
        raise AssertionError(f"coal lacks {len(missing)} facet pairs, such as {min(missing)}")
    if extra := theirs - possible:
        raise AssertionError(f"coal has {len(extra)} facet pairs more, such as {min(extra)}")
    return len(ours)
