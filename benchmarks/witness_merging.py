"""What merging adds to finding witness pairs.

Why: a contact of two vertices is met by every facet pair around them; forces want it once, with its
multiplicity. Merging may cost half again as much as finding: the ratio must be at least 1/1.5.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from benchmarks.harness import Row, Stopwatch
from benchmarks.mesh_pairs import all_pairs
from contact_toolkit import witness_pairs

NAME = "witness pairs, merged"
TARGET = 1 / 1.5


def measure(watch: Stopwatch, coarser: int = 1) -> Iterator[Row]:
    """Compare with and without merging at each pair's last, most general pose."""
    for pair in all_pairs(coarser):
        A, B = pair.meshes()
        name, X_AB = list(pair.poses.items())[-1]
        for standoff in pair.standoffs:
            yield watch.row(
                NAME,
                f"{pair.name}, {1e3 * standoff:g} mm, {name}",
                partial(witness_pairs, A, B, X_AB, standoff),
                {"not merged": partial(witness_pairs, A, B, X_AB, standoff, merge=False)},
                target=TARGET,
                size=pair.facets,
                output=len(witness_pairs(A, B, X_AB, standoff)),
            )
