"""The facet kernel alone: distances of given facet pairs, no hierarchy, no rows.

Why: it bounds every query from below, so a slow kernel must show before it hides in a query. The
budget of 62 ns a pair is twice what four-wide double vectors took on the machine it was set on. The
pairs are those a query finds, hence of every case: vertices, edges and facets against each other.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from benchmarks.harness import Row, Stopwatch
from benchmarks.mesh_pairs import all_pairs
from contact_toolkit import _core, witness_pairs

NAME = "facet kernel"
_BUDGET = 62e-9  # [s] a pair


def measure(watch: Stopwatch, coarser: int = 1) -> Iterator[Row]:
    """Measure the witness pairs of each mesh pair once more, each SIMD path in turn."""
    best = _core.simd()
    for pair in all_pairs(coarser)[:4]:
        A, B = pair.meshes()
        name, X_AB = list(pair.poses.items())[-1]
        rows = witness_pairs(A, B, X_AB, max(pair.standoffs), merge=False)
        arguments = (A._core, B._core, X_AB, rows.facet_a, rows.facet_b)
        for path in dict.fromkeys([best, "scalar"]):
            _core.select_simd(path)
            (seconds,) = watch.medians(partial(_core.facet_distances, *arguments))
            _core.select_simd(best)
            yield Row(
                NAME,
                f"{pair.name}, {name}, {path}",
                "budget",
                seconds / len(rows),
                _BUDGET,
                target=1.0 if path == best else None,
                output=len(rows),
            )
