"""Witness pairs, distances and sweeps of parts that nobody made for this engine, in any attitude.

Why: a generated part is as regular as its generator, and measured where features line up. Here are
parts as a CAD kernel tessellates them, with fans and slivers, and noisy surfaces as scanners leave
them, turned at random: near each other, crossing, and far apart. With `--meshes DIR` the same is
done with the mesh files of a folder.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from benchmarks.attitudes import each_with_itself_and_the_next, translated_at_random
from benchmarks.harness import Row, Stopwatch
from benchmarks.mesh_pairs import MeshPair
from benchmarks.translation_sweep import TARGET as SWEEP_TARGET
from benchmarks.witness_coherent import closed_path, follow
from benchmarks.yardsticks import Coal, Fcl
from contact_toolkit import WitnessCache, distance, swept_distance, witness_pairs
from scenarios.parts import Surface, bumpy_sphere

_MANY_ROWS = 1000
_COLD_TARGETS = {"few": 5.0, "many": 15.0, "none": 3.0}
_COHERENT_TARGET = 30.0  # with many rows
_DISTANCE_TARGET, _WORTH_TIMING = 3.0, 5e-5  # [s]: below, it must only be no slower
_NOISE = 0.15  # [-] of an edge's length


def measure(watch: Stopwatch, coarser: int = 1) -> Iterator[Row]:
    """Compare tessellated and scanned parts."""
    from benchmarks.tessellated_parts import tessellated_parts

    parts = [*tessellated_parts(coarser), ("scan", scan(32 // coarser))]
    return measure_pairs(watch, each_with_itself_and_the_next(parts))


def scan(frequency: int, seed: int = 5) -> Surface:
    """Return a bumpy sphere whose vertices stray by some share of an edge's length."""
    vertices, faces = bumpy_sphere(frequency=frequency)
    edge = np.median(np.linalg.norm(np.diff(vertices[faces], axis=1), axis=-1))
    return vertices + _NOISE * edge * np.random.default_rng(seed).normal(size=vertices.shape), faces


def measure_pairs(watch: Stopwatch, pairs: Iterable[MeshPair]) -> Iterator[Row]:
    """Compare witness pairs, cold and coherent, distances and sweeps in each attitude."""
    rng = np.random.default_rng(7)
    for pair in pairs:
        A, B = pair.meshes()
        coal, fcl = Coal(pair.A, pair.B), Fcl(pair.A, pair.B)
        (standoff,) = pair.standoffs
        for name, X_AB in pair.poses.items():
            case = f"{pair.name}, {name}"
            ours = distance(A, B, X_AB).distance
            np.testing.assert_allclose(fcl.distance(X_AB), ours, atol=1e-4 * A.diagonal)
            rows = len(witness_pairs(A, B, X_AB, standoff, merge=False))
            amount = "none" if rows == 0 else "few" if rows <= _MANY_ROWS else "many"
            cold = watch.row(
                "real parts, witness pairs",
                case,
                partial(witness_pairs, A, B, X_AB, standoff, merge=False),
                {"coal": partial(coal.witness_pairs, X_AB, standoff)},
                target=_COLD_TARGETS[amount],
                size=pair.facets,
                output=rows,
            )
            yield cold
            if rows > 0:
                path = closed_path(X_AB, radius=1e-4 * B.diagonal)
                query = partial(WitnessCache(A, B).witness_pairs, standoff=standoff, merge=False)
                (lap,) = watch.medians(partial(follow, path, query))
                yield replace(
                    cold,
                    benchmark="real parts, witness pairs, coherent",
                    seconds=lap / len(path),
                    target=_COHERENT_TARGET if amount == "many" else None,
                )
            closest = watch.row(
                "real parts, distance",
                case,
                partial(distance, A, B, X_AB),
                {"coal": partial(coal.distance, X_AB), "FCL": partial(fcl.distance, X_AB)},
                size=pair.facets,
            )
            worth_timing = closest.yardstick_seconds > _WORTH_TIMING
            yield replace(closest, target=_DISTANCE_TARGET if worth_timing else 1.0)
            X_end = translated_at_random(X_AB, min(A.diagonal, B.diagonal), rng)
            yield watch.row(
                "real parts, translation sweep",
                case,
                partial(swept_distance, A, B, X_AB, X_end),
                {"distance": partial(distance, A, B, X_AB)},
                target=SWEEP_TARGET,
                size=pair.facets,
            )
