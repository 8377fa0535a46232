"""Swept distance over a translation, against the static distance at its start.

Why: a sweep is what keeps fast bodies from passing through thin ones, step by step, and is
affordable only if it costs little more than the static query: at most 1.5 times, a ratio of at
least 1/1.5. Over a micrometre (a step), a millimetre, and a tenth of B's size (a fast body), along
the surfaces and away from them. A sweep that collides ends as soon as a collision is found, mostly
far faster than the static query: such rows stand apart and have no target.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from benchmarks.harness import Row, Stopwatch
from benchmarks.mesh_pairs import Pose, all_pairs
from contact_toolkit import CollisionMesh, distance, swept_distance

TARGET = 1 / 1.5
TARGETS = {"translation sweep, staying clear": TARGET, "translation sweep, colliding": None}


def measure(watch: Stopwatch, coarser: int = 1) -> Iterator[Row]:
    """Compare each pair's last, most general pose; those that stay clear first."""
    pairs = [(pair, *pair.meshes()) for pair in all_pairs(coarser)]
    for name, target in TARGETS.items():
        for pair, A, B in pairs:
            pose_name, X_AB = list(pair.poses.items())[-1]
            for motion_name, X_end in motions(A, B, X_AB).items():
                collides = swept_distance(A, B, X_AB, X_end).distance == 0.0
                if collides == (target is not None):
                    continue
                yield watch.row(
                    name,
                    f"{pair.name}, {pose_name}, {motion_name}",
                    partial(swept_distance, A, B, X_AB, X_end),
                    {"distance": partial(distance, A, B, X_AB)},
                    target=target,
                    size=pair.facets,
                )


def motions(A: CollisionMesh, B: CollisionMesh, X_AB: Pose) -> dict[str, Pose]:
    """Return the ends of the motions from a pose, by name."""
    away = -distance(A, B, X_AB).normal_A
    along = np.linalg.svd(away[None])[2][1]
    lengths = {"a micrometre": 1e-6, "a millimetre": 1e-3, "a tenth of B": 0.1 * B.diagonal}
    ends = {}
    for length_name, length in lengths.items():
        for direction_name, direction in {"along": along, "away": away}.items():
            X_end = X_AB.copy()
            X_end[:3, 3] += length * direction
            ends[f"{length_name} {direction_name}"] = X_end
    return ends
