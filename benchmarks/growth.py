"""How cost grows with the number of facets: bumpy spheres from 1 k to 1 M facets, 0.1 mm apart.

Why: an engine is fast or slow by its slope. Cost must grow no faster than n log n + output; it
grows far slower, because only what is near is looked at. Two standoffs: 1 mm, where output grows
with the facets, and two facet edges, where only the hierarchy does.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

from benchmarks.harness import Row, Stopwatch
from benchmarks.mesh_pairs import bumpy_spheres
from benchmarks.yardsticks import Coal
from contact_toolkit import CollisionMesh, distance, witness_pairs

NAME = "growth"
FREQUENCIES = (7, 22, 71, 224)  # 980 to 1 003 520 facets
_EDGE = 0.06  # [m] mean facet edge times frequency


def measure(watch: Stopwatch, coarser: int = 1) -> Iterator[Row]:
    """Compare each size with coal, then the largest with the smallest."""
    frequencies = [max(2, frequency // coarser) for frequency in FREQUENCIES]
    rows = {
        key: list(rows)
        for key, rows in zip(
            ("1 mm", "two edges", "distance", "build"),
            zip(*(_rows(watch, frequency) for frequency in frequencies), strict=True),
            strict=True,
        )
    }
    for key, sizes in rows.items():
        yield from sizes
        first, last = (row.seconds / _allowed(row) for row in (sizes[0], sizes[-1]))
        yield Row(NAME, f"{key}, per n log n + output", "smallest size", last, first, target=1.0)


def _rows(watch: Stopwatch, frequency: int) -> Iterator[Row]:
    pair = bumpy_spheres(frequency)
    mesh, X_AB = CollisionMesh(*pair.A), pair.poses["askew 1"]
    coal = Coal(pair.A, pair.B)
    for key, standoff in {"1 mm": 0.001, "two edges": 1e-4 + 2 * _EDGE / frequency}.items():
        yield watch.row(
            NAME,
            f"witness pairs, {key}, {len(mesh.faces)} facets each",
            partial(witness_pairs, mesh, mesh, X_AB, standoff, merge=False),
            {"coal": partial(coal.witness_pairs, X_AB, standoff)},
            target=15.0,
            size=pair.facets,
            output=len(witness_pairs(mesh, mesh, X_AB, standoff, merge=False)),
        )
    yield watch.row(
        NAME,
        f"distance, {len(mesh.faces)} facets each",
        partial(distance, mesh, mesh, X_AB),
        {"coal": partial(coal.distance, X_AB)},
        target=3.0,
        size=pair.facets,
        output=1,
    )
    yield watch.row(
        NAME,
        f"build, {len(mesh.faces)} facets",
        partial(CollisionMesh, *pair.A),
        {"coal": partial(coal.build, pair.A)},
        size=pair.facets // 2,
        output=0,
    )


def _allowed(row: Row) -> float:
    """Return n log n + output."""
    assert row.size is not None
    assert row.output is not None
    return row.size * math.log2(row.size) + row.output
