"""What parts thrown on a heap are judged by: all there, none inside another, at rest, carried."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from pydrake.multibody.tree import BodyIndex

from contact_toolkit import CollisionMesh
from scenarios.format.errors import ScenarioError
from scenarios.format.models import surface_of
from scenarios.judge.overlap import deepest_overlap
from systems.plant.names import BodyNames

if TYPE_CHECKING:
    from scenarios.judge.measures import Run

FIGURES = (
    "parts",
    "parts lost",
    "deepest overlap [mm]",
    "largest speed at the end [mm/s]",
    "weight carried",
    "largest unbalanced force [weights]",
)


def heap(run: Run) -> dict[str, float]:
    """Figures of all parts that move, at the end.

    A part is lost if any of it is outside of the box around the fixed parts. Overlaps come from the
    distances of points, not from the forces. What contact does less the part's weight is unbalanced.
    """
    plant, context = run.plant, run.plant_context
    names, gravity = BodyNames(plant), plant.gravity_field().gravity_vector()
    fixed = {body.index() for body in plant.GetBodiesWeldedTo(plant.world_body())}
    meshes = {name: CollisionMesh(*surface_of(part)) for name, part in run.scenario.parts.items()}
    bodies = [plant.get_body(BodyIndex(i)) for i in range(plant.num_bodies())]
    bodies = [body for body in bodies if body.name() in meshes]
    moving = [body for body in bodies if body.index() not in fixed]
    if not 0 < len(moving) < len(bodies):
        raise ScenarioError("the measure 'heap' needs parts that move and parts that are fixed")

    solids = [meshes[body.name()] for body in bodies]
    X_WB = [plant.EvalBodyPoseInWorld(context, body).GetAsMatrix4() for body in bodies]
    corners = [
        mesh.vertices @ X[:3, :3].T + X[:3, 3] for mesh, X in zip(solids, X_WB, strict=True)
    ]
    low, high = (np.array([end(p, axis=0) for p in corners]) for end in (np.min, np.max))
    moves = np.array([body.index() not in fixed for body in bodies])
    outside = (low < low[~moves].min(axis=0)) | (high > high[~moves].max(axis=0))

    last = run.record.last(run.scenario.acceptance.window)
    velocity, force = (
        np.array(
            [[run[f"{names.name_of(b.index())}.{q}{x}"][last] for x in "xyz"] for b in moving]
        )
        for q in "vf"
    )
    mean_force = force.mean(axis=2)
    weight = np.array([body.get_mass(context) * gravity for body in moving])
    left = np.linalg.norm(mean_force + weight, axis=1) / np.linalg.norm(weight, axis=1)
    figures = (
        len(moving),
        outside[moves].any(axis=1).sum(),
        1e3 * deepest_overlap(solids, X_WB, moves),
        1e3 * np.linalg.norm(velocity, axis=1).max(),
        -mean_force.sum(axis=0) @ gravity / (weight.sum(axis=0) @ gravity),
        left.max(),
    )
    return {name: float(value) for name, value in zip(FIGURES, figures, strict=True)}
