"""Every witness pair along a motion of a micrometre a query, against coal.

Why: within a simulation step the integrator asks for the same bodies at poses micrometres apart.
`WitnessCache` answers from candidates gathered once; the rows are those of the cold query, bit for
bit, which is checked. coal remembers nothing of the kind, so its cost is that of one pose.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.harness import Row, Stopwatch
from benchmarks.mesh_pairs import Pose, all_pairs, pose
from benchmarks.yardsticks import Coal
from contact_toolkit import CollisionMesh, WitnessCache, witness_pairs

NAME = "witness pairs, coherent"
TARGET = 60.0
_STEPS = 64
_RADIUS, _TURN = 1e-5, 1e-4  # [m], [rad]: 1 µm and 10 µrad from pose to pose


def measure(watch: Stopwatch, coarser: int = 1) -> Iterator[Row]:
    """Follow each pair about each pose, unmerged as in the cold comparison."""
    for pair in all_pairs(coarser):
        A, B = pair.meshes()
        coal = Coal(pair.A, pair.B)
        for standoff in pair.standoffs:
            for name, X_AB in pair.poses.items():
                path = closed_path(X_AB)
                cache = WitnessCache(A, B)
                query = partial(cache.witness_pairs, standoff=standoff, merge=False)
                require_cold_rows(A, B, path, standoff, cache)
                row = watch.row(
                    NAME,
                    f"{pair.name}, {1e3 * standoff:g} mm, {name}",
                    partial(follow, path, query),
                    {"coal": partial(coal.witness_pairs, X_AB, standoff)},
                    target=TARGET,
                    size=pair.facets,
                    output=len(query(X_AB)),
                )
                yield replace(row, seconds=row.seconds / _STEPS)


def closed_path(X_AB: Pose, radius: float = _RADIUS) -> list[Pose]:
    """Return poses on a small circle that starts and ends at X_AB."""
    angles = np.linspace(0.0, 2 * np.pi, _STEPS, endpoint=False)
    return [
        pose(
            Rotation.from_rotvec([0.0, _TURN * np.sin(angle), _TURN * (1 - np.cos(angle))]),
            [radius * np.sin(angle), radius * (1 - np.cos(angle)), 0.0],
        )
        @ X_AB
        for angle in angles
    ]


def follow(path: list[Pose], query: Callable[[Pose], object]) -> None:
    """Query once around: in places edges are parallel, and the features found there of no use."""
    for X_AB in path:
        query(X_AB)


def require_cold_rows(
    A: CollisionMesh, B: CollisionMesh, path: list[Pose], standoff: float, cache: WitnessCache
) -> None:
    """Raise unless the cache answers as the cold query does, at some poses of the path."""
    for X_AB in path[:: _STEPS // 4]:
        warm = cache.witness_pairs(X_AB, standoff, merge=False)
        cold = witness_pairs(A, B, X_AB, standoff, merge=False)
        for column, values in cold.columns().items():
            np.testing.assert_array_equal(getattr(warm, column), values, err_msg=column)
