"""One evaluation of contact forces with about 1000 loaded springs, and what one accepted step adds.

Why: the evaluation is what an integrator pays for at every stage of every step, on top of what
`contact_in_drake` measures. Within a step the table remembers what was near, and poses change by a
micrometre from call to call. Without a table everything is found anew; what a fast body pays.

An accepted step moves the anchors that slid. Once in many steps it also gathers what is near, and
while much energy is being lost the ledger asks for one more evaluation: neither is in these times.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import cycle

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.harness import Row, Stopwatch
from benchmarks.mesh_pairs import Pose, doughnut_on_cone, pose
from benchmarks.witness_coherent import closed_path
from contact_toolkit import (
    AreaWeb,
    CollisionMesh,
    ContactGeometry,
    ContactModel,
    ContactPair,
    FacetWeb,
    Friction,
    NonlinearDamper,
)

NAME = "contact forces"
SPRINGS = 1000
_ANCHOR_BUDGET = 50e-6  # [s]
_SLIDE = 0.03  # [rad] of the doughnut about the cone's axis, some 2 mm, which alters no depth
_FRICTION = Friction(0.5)
# The area web, or None for the facet web, whose standoff is chosen; budget [s] of an evaluation.
_WEBS: dict[str, tuple[AreaWeb | None, Friction | None, float]] = {
    "facet web": (None, None, 150e-6),
    "facet web, friction": (None, _FRICTION, 150e-6),
    "area web, smooth": (AreaWeb(), None, 150e-6),
    "area web, exact": (AreaWeb(field="exact"), None, 400e-6),
    "area web, friction": (AreaWeb(), _FRICTION, 150e-6),
}


def measure(watch: Stopwatch, coarser: int = 1) -> Iterator[Row]:
    """Evaluate the doughnut tilted on the cone, without and with the table of the last step."""
    pair = doughnut_on_cone(coarser)
    meshes = pair.meshes()
    turn = pose(Rotation.from_rotvec([0.0, 0.0, _SLIDE]), np.zeros(3))
    V_FB = np.array([np.zeros(6), [0.0, 0.0, 0.0, 0.0, 0.01, -0.1]])
    for name, (web, friction, budget) in _WEBS.items():
        least = SPRINGS // coarser**2
        model, X_AB = loaded(*meshes, pair.poses["tilted"], least, web=web, friction=friction)
        path = closed_path(X_AB)
        X_FB = [np.stack([np.eye(4), X]) for X in path]
        turned = [np.stack([np.eye(4), turn @ X]) for X in path]  # further than anchors stretch
        state = model.initial_state()
        state = model.advance(state, 0.0, model.evaluate(X_FB[0], V_FB, state))
        cold, warm = (partial(model.evaluate, V_FB=V_FB, state=last) for last in (None, state))
        cases: dict[str, tuple[Iterator[object], float, float | None]] = {
            "nothing remembered": (
                map(cold, cycle(X_FB)),
                budget,
                1.0 if web else None,
            ),
            "within a step": (map(warm, cycle(X_FB)), budget, 1.0),
        }
        if friction:
            update = partial(model.advance, state, state.time)
            cases["update of sliding anchors"] = (
                map(update, cycle([warm(X) for X in turned])),
                _ANCHOR_BUDGET,
                1.0,
            )
        sizes = {"size": pair.facets, "output": len(model.find(X_FB[0]))}
        for case, (calls, least, target) in cases.items():
            (seconds,) = watch.medians(partial(next, calls))
            yield Row(NAME, f"{name}, {case}", "budget", seconds, least, target, **sizes)


def loaded(
    A: CollisionMesh,
    B: CollisionMesh,
    X_AB: Pose,
    springs: int,
    *,
    web: AreaWeb | None,
    friction: Friction | None,
) -> tuple[ContactModel, Pose]:
    """Return a model and a pose that load at least so many springs, and hardly more.

    On the facet web the standoff is chosen for it; on the area web, whose standoff is zero unless
    set, how far B is pressed down on A.
    """
    geometries = [ContactGeometry(name, name, mesh) for name, mesh in (("a", A), ("b", B))]

    def at(closer: float) -> tuple[ContactModel, Pose]:
        pressed = closer if web else 0.0
        damper = NonlinearDamper(k=1e6, alpha=0.3)
        pair = ContactPair(0, 1, damper, web or FacetWeb(closer), friction)
        X = pose(Rotation.identity(), [0.0, 0.0, -pressed]) @ X_AB
        return ContactModel(["a", "b"], geometries, [pair]), X

    low, high = 0.0, 0.05  # [m]
    for _ in range(16):
        middle = (low + high) / 2
        model, X = at(middle)
        few = len(model.find(np.stack([np.eye(4), X]))) < springs
        low, high = (middle, high) if few else (low, middle)
    return at(high)
