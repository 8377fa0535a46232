"""The least distance, against the better of coal and FCL.

Why: the query everyone has, and the one to compare engines by. The fitted parts (thread, gears,
peg) are its hard cases: thousands of facet pairs are almost equally close. Distances are checked to
agree.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from benchmarks.harness import Row, Stopwatch
from benchmarks.mesh_pairs import MeshPair, Pose, all_pairs
from benchmarks.yardsticks import Coal, Fcl
from contact_toolkit import distance

NAME = "distance"
TARGET = 3.0


def measure(watch: Stopwatch, coarser: int = 1) -> Iterator[Row]:
    """Compare all pairs at all poses, and apart by once their size."""
    for pair in all_pairs(coarser):
        A, B = pair.meshes()
        coal, fcl = Coal(pair.A, pair.B), Fcl(pair.A, pair.B)
        for name, X_AB in {**pair.poses, "far apart": far_apart(pair)}.items():
            ours = distance(A, B, X_AB).distance
            np.testing.assert_allclose([coal.distance(X_AB), fcl.distance(X_AB)], ours, atol=1e-6)
            yield watch.row(
                NAME,
                f"{pair.name}, {name}",
                partial(distance, A, B, X_AB),
                {"coal": partial(coal.distance, X_AB), "FCL": partial(fcl.distance, X_AB)},
                target=TARGET,
                size=pair.facets,
            )


def far_apart(pair: MeshPair) -> Pose:
    """Return the last pose, B moved off along a diagonal by A's and B's size."""
    X_AB = list(pair.poses.values())[-1].copy()
    size = sum(np.ptp(vertices, axis=0).max() for vertices, _ in (pair.A, pair.B))
    X_AB[:3, 3] += size * np.array([0.6, 0.64, 0.48])
    return X_AB
