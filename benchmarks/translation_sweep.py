"""Swept distance over a translation, against the static distance at its start.

Why: a sweep is what keeps fast bodies from passing through thin ones, step by step, and is
affordable only if it costs little more than the static query: at most 1.5 times, a ratio of at
least 1/1.5. Over a micrometre (a step) and a tenth of B's size (a fast body), along the surfaces
and away from them. A sweep that collides ends early, which flatters it: such rows have no target.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from benchmarks.harness import Row, Stopwatch
from benchmarks.mesh_pairs import all_pairs
from contact_toolkit import distance, swept_distance

NAME = "translation sweep"
TARGET = 1 / 1.5


def measure(watch: Stopwatch, coarser: int = 1) -> Iterator[Row]:
    """Compare each pair's last, most general pose."""
    for pair in all_pairs(coarser):
        A, B = pair.meshes()
        name, X_AB = list(pair.poses.items())[-1]
        away = distance(A, B, X_AB).normal_A
        along = np.linalg.svd(away[None])[2][1]
        for case, motion in {
            "a micrometre along": 1e-6 * along,
            "a tenth of B along": 0.1 * B.diagonal * along,
            "a tenth of B away": -0.1 * B.diagonal * away,
        }.items():
            X_end = X_AB.copy()
            X_end[:3, 3] += motion
            collides = swept_distance(A, B, X_AB, X_end).distance == 0.0
            yield watch.row(
                NAME,
                f"{pair.name}, {name}, {case}{', collides' if collides else ''}",
                partial(swept_distance, A, B, X_AB, X_end),
                {"distance": partial(distance, A, B, X_AB)},
                target=None if collides else TARGET,
                size=pair.facets,
            )
