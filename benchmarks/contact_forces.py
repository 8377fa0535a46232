"""One evaluation of contact forces: springs found, forces and wrenches summed, about 1000 springs.

Why: this is what an integrator pays for at every stage of every step, on top of Drake's own 20 µs.
The budget is 150 µs an evaluation, the aim 60 µs. Poses change by a micrometre from call to call.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import cycle

import numpy as np

from benchmarks.harness import Row, Stopwatch
from benchmarks.mesh_pairs import MeshPair, doughnut_on_cone
from benchmarks.witness_coherent import closed_path
from contact_toolkit import (
    ContactGeometry,
    ContactModel,
    ContactPair,
    NonlinearDamper,
    witness_pairs,
)

NAME = "contact forces"
SPRINGS = 1000
_BUDGET = 150e-6  # [s]


def measure(watch: Stopwatch, coarser: int = 1) -> Iterator[Row]:
    """Evaluate the doughnut on the cone, without and with the table of the last step."""
    pair = doughnut_on_cone(coarser)
    X_AB = pair.poses["tilted"]
    model = facet_web(pair, standoff_for(pair, SPRINGS // coarser**2))
    path = cycle([np.stack([np.eye(4), X]) for X in closed_path(X_AB)])
    V_FB = np.zeros((2, 6))
    V_FB[1, 5] = -0.1
    start = np.stack([np.eye(4), X_AB])
    table = model.initial_table()
    table = model.advance(table, 0.0, model.evaluate(start, V_FB, table))
    springs = len(model.find(start))
    for case, last in {"nothing remembered": None, "within a step": table}.items():
        (seconds,) = watch.medians(lambda t=last: model.evaluate(next(path), V_FB, t))
        yield Row(
            NAME,
            f"facet web, {springs} springs, {case}",
            "budget",
            seconds,
            _BUDGET,
            target=1.0,
            size=pair.facets,
            output=springs,
        )


def facet_web(pair: MeshPair, standoff: float) -> ContactModel:
    """Return a model of the pair's two bodies."""
    return ContactModel(
        ["a", "b"],
        [
            ContactGeometry(name, name, mesh)
            for name, mesh in zip(("a", "b"), pair.meshes(), strict=True)
        ],
        [ContactPair(0, 1, NonlinearDamper(k=1e4, alpha=0.3), web="facet", standoff=standoff)],
    )


def standoff_for(pair: MeshPair, springs: int) -> float:
    """Return the standoff [m] at which about so many merged witness pairs are loaded, tilted."""
    low, high = 0.0, max(pair.standoffs)
    for _ in range(20):
        middle = (low + high) / 2
        few = len(witness_pairs(*pair.meshes(), pair.poses["tilted"], middle)) < springs
        low, high = (middle, high) if few else (low, middle)
    return high
