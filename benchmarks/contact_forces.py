"""One evaluation of contact forces: springs found, forces and wrenches summed, about 1000 springs.

Why: this is what an integrator pays for at every stage of every step, on top of Drake's own 20 µs.
Within a step the step table remembers what was near, and poses change by a micrometre from call to
call: the budget is 150 µs an evaluation, the aim 60 µs. Without a table everything is found anew.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import cycle

import numpy as np

from benchmarks.harness import Row, Stopwatch
from benchmarks.mesh_pairs import doughnut_on_cone
from benchmarks.witness_coherent import closed_path
from contact_toolkit import (
    CollisionMesh,
    ContactGeometry,
    ContactModel,
    ContactPair,
    Friction,
    NonlinearDamper,
)

NAME = "contact forces"
SPRINGS = 1000
_BUDGET = 150e-6  # [s]
_WEBS = {
    "facet web": {"web": "facet"},
    "facet web, friction": {"web": "facet", "friction": Friction(0.5)},
    "area web, smooth": {"web": "area"},
    "area web, exact": {"web": "area", "field": "exact"},
    "area web, friction": {"web": "area", "friction": Friction(0.5)},
}


def measure(watch: Stopwatch, coarser: int = 1) -> Iterator[Row]:
    """Evaluate the doughnut tilted on the cone, without and with the table of the last step."""
    pair = doughnut_on_cone(coarser)
    meshes, poses = pair.meshes(), closed_path(pair.poses["tilted"])
    X_FB = [np.stack([np.eye(4), X_AB]) for X_AB in poses]
    V_FB = np.array([np.zeros(6), [0.0, 0.0, 0.0, 0.0, 0.01, -0.1]])
    for web, settings in _WEBS.items():
        model = loaded_model(*meshes, X_FB[0], SPRINGS // coarser**2, settings)
        table = model.initial_table()
        table = model.advance(table, 0.0, model.evaluate(X_FB[0], V_FB, table))
        springs = len(model.find(X_FB[0]))
        for case, last in {"nothing remembered": None, "within a step": table}.items():
            call = partial(model.evaluate, V_FB=V_FB, table=last)
            (seconds,) = watch.medians(partial(next, map(call, cycle(X_FB))))
            yield Row(
                NAME,
                f"{web}, {case}",
                "budget",
                seconds,
                _BUDGET,
                target=1.0 if last else None,
                size=pair.facets,
                output=springs,
            )


def loaded_model(
    A: CollisionMesh, B: CollisionMesh, X_FB: np.ndarray, springs: int, settings: dict[str, object]
) -> ContactModel:
    """Return a model whose standoff loads at least so many springs, and hardly more."""
    geometries = [ContactGeometry(name, name, mesh) for name, mesh in (("a", A), ("b", B))]
    low, high = 0.0, 0.02
    for _ in range(12):
        middle = (low + high) / 2
        pair = ContactPair(0, 1, NonlinearDamper(k=1e6, alpha=0.3), standoff=middle, **settings)
        model = ContactModel(["a", "b"], geometries, [pair])
        few = len(model.find(X_FB)) < springs
        low, high = (middle, high) if few else (low, middle)
    return model
