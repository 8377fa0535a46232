"""Two threads against one.

Why: batches and bins of parts are what threads are for; answers are the same bits on any number, so
the only question is whether they are sooner. Wall time, whatever clock the others run on. A single
query may be split as well; its rows still have to be joined, so it has no target.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import cycle

import numpy as np

from benchmarks.bin_of_parts import contact_model, filling, jolted
from benchmarks.harness import Row, Stopwatch
from benchmarks.mesh_pairs import doughnut_on_cone
from benchmarks.witness_coherent import closed_path
from contact_toolkit import distance_batch, intersects_batch, swept_distance_batch, witness_pairs

NAME = "two threads"
TARGET = 1.6
_ONE_QUERY = "one query of witness pairs"


def measure(watch: Stopwatch, coarser: int = 1) -> Iterator[Row]:
    """Compare batches, a bin of parts, and one large query."""
    watch = replace(watch, clock=time.perf_counter)
    pair = doughnut_on_cone(coarser)
    A, B = pair.meshes()
    X_AB = np.stack([X for pose in pair.poses.values() for X in closed_path(pose)])
    meshes, poses = filling(200 // coarser)
    bin_of_parts = {threads: contact_model(meshes, threads=threads) for threads in (1, 2)}
    jolts, V_WB = cycle([jolted(poses, seed) for seed in range(8)]), np.zeros((len(poses), 6))
    tilted = pair.poses["tilted"]
    cases: dict[str, Callable[[int], object]] = {
        f"distance, {len(X_AB)} poses": lambda n: distance_batch(A, B, X_AB, threads=n),
        f"intersects, {len(X_AB)} poses": lambda n: intersects_batch(A, B, X_AB, threads=n),
        f"swept distance, {len(X_AB) - 1} motions": lambda n: swept_distance_batch(
            A, B, X_AB[:-1], X_AB[1:], tolerance=1e-5, threads=n
        ),
        f"forces between {len(poses)} bodies": lambda n: bin_of_parts[n].evaluate(
            next(jolts), V_WB
        ),
        _ONE_QUERY: lambda n: witness_pairs(A, B, tilted, 0.008, threads=n),
    }
    for case, call in cases.items():
        one, two = watch.medians(lambda f=call: f(1), lambda f=call: f(2))
        target = None if case == _ONE_QUERY else TARGET
        yield Row(NAME, case, "one thread", two, one, target=target)
