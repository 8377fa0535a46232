"""What parts thrown on a heap are judged by: all there, none inside another, at rest, carried."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.tree import BodyIndex

from contact_toolkit import CollisionMesh
from scenarios.format.errors import ScenarioError
from scenarios.format.models import surface_of
from scenarios.judge.overlap import deepest_overlap
from scenarios.simulation.record import Record
from systems.plant.names import BodyNames

if TYPE_CHECKING:
    from scenarios.judge.measures import Run

Floats = NDArray[np.float64]

FIGURES = (
    "parts",
    "parts lost",
    "deepest overlap [mm]",
    "largest speed at the end [mm/s]",
    "weight carried",
    "largest unbalanced force [weights]",
)


@dataclass(frozen=True)
class Heap:
    """Solids at their poses X_WB (4, 4), and which of them can move."""

    solids: Sequence[CollisionMesh]
    X_WB: Sequence[Floats]
    moves: NDArray[np.bool_]

    @cached_property
    def deepest_overlap(self) -> float:
        """How deep any is in another [m]."""
        return deepest_overlap(self.solids, self.X_WB, self.moves)

    def figures(self, moving: Sequence[str], record: Record, window: float) -> dict[str, float]:
        """Return the figures of motion alone; `moving` are the names of what can move.

        A part is lost if any of it is outside of the box around the fixed ones.
        """
        corners = [
            mesh.vertices @ X[:3, :3].T + X[:3, 3]
            for mesh, X in zip(self.solids, self.X_WB, strict=True)
        ]
        low, high = (np.array([end(p, axis=0) for p in corners]) for end in (np.min, np.max))
        fixed = ~self.moves
        outside = (low < low[fixed].min(axis=0)) | (high > high[fixed].max(axis=0))
        speed = np.linalg.norm(_vectors(record, moving, "v", window), axis=1)
        return {
            "parts": float(len(moving)),
            "parts lost": float(outside[self.moves].any(axis=1).sum()),
            "deepest overlap [mm]": 1e3 * self.deepest_overlap,
            "largest speed at the end [mm/s]": 1e3 * float(speed.max()),
        }


def heap(run: Run) -> dict[str, float]:
    """Figures of all parts that move, at the end.

    Overlaps come from the distances of points, not from the forces. What contact does less a part's
    weight is unbalanced.
    """
    plant, context, names = run.plant, run.plant_context, BodyNames(run.plant)
    gravity = plant.gravity_field().gravity_vector()
    fixed = {body.index() for body in plant.GetBodiesWeldedTo(plant.world_body())}
    meshes = {name: CollisionMesh(*surface_of(part)) for name, part in run.scenario.parts.items()}
    bodies = [plant.get_body(BodyIndex(i)) for i in range(plant.num_bodies())]
    bodies = [body for body in bodies if body.name() in meshes]
    moving = [body for body in bodies if body.index() not in fixed]
    if not 0 < len(moving) < len(bodies):
        raise ScenarioError("the measure 'heap' needs parts that move and parts that are fixed")
    at_end = Heap(
        [meshes[body.name()] for body in bodies],
        [plant.EvalBodyPoseInWorld(context, body).GetAsMatrix4() for body in bodies],
        np.array([body.index() not in fixed for body in bodies]),
    )
    called = [names.name_of(body.index()) for body in moving]
    window = run.scenario.acceptance.window
    force = _vectors(run.record, called, "f", window).mean(axis=2)
    weight = np.array([body.get_mass(context) * gravity for body in moving])
    left = np.linalg.norm(force + weight, axis=1) / np.linalg.norm(weight, axis=1)
    carried = -force.sum(axis=0) @ gravity / (weight.sum(axis=0) @ gravity)
    return at_end.figures(called, run.record, window) | {
        "weight carried": float(carried),
        "largest unbalanced force [weights]": float(left.max()),
    }


def _vectors(record: Record, bodies: Sequence[str], quantity: str, window: float) -> Floats:
    """Return a quantity of bodies in the last part of a run, (bodies, 3, rows)."""
    last = record.last(window)
    return np.array([[record[f"{name}.{quantity}{x}"][last] for x in "xyz"] for name in bodies])
