"""WholeBodies: how large and heavy bodies are with all that is welded to them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex

from contact_toolkit import CollisionMesh

Floats = NDArray[np.float64]
FixedMesh = tuple[BodyIndex, CollisionMesh, Floats]  # body, mesh, (4, 4) pose X_BG in the body

_STANDARD_GRAVITY = 9.81  # [m/s²] where the plant has none: a load must be of some size


@dataclass(frozen=True)
class WholeBody:
    """A body with all that is welded to it.

    Attributes
    ----------
    diagonal
        Of the bounding box of its geometries in the frame of its first body [m].
    weight
        [N]; infinite where it is anchored to the world.
    """

    diagonal: float
    weight: float


class WholeBodies:
    """Groups of bodies welded together: an object is one however it was cut into pieces.

    Parameters
    ----------
    plant
        Finalized; its default masses and welds are used.
    meshes
        All that may touch.
    """

    def __init__(self, plant: MultibodyPlant, meshes: Iterable[FixedMesh]) -> None:
        context = plant.CreateDefaultContext()
        g_W = plant.gravity_field().gravity_vector()
        gravity = float(np.linalg.norm(g_W)) or _STANDARD_GRAVITY
        corners_on: dict[BodyIndex, list[Floats]] = {}
        for index, mesh, X_BG in meshes:
            corners_on.setdefault(index, []).append(_corners(mesh, X_BG))
        self._whole: dict[BodyIndex, WholeBody] = {}
        for index in corners_on:
            if index in self._whole:
                continue
            body = plant.get_body(index)
            welded = plant.GetBodiesWeldedTo(body)
            corners, mass = [], 0.0
            for each in welded:
                mass += each.get_mass(context)
                X_BE = plant.CalcRelativeTransform(context, body.body_frame(), each.body_frame())
                corners += [(X_BE @ p.T).T for p in corners_on.get(each.index(), [])]
            box = np.concatenate(corners)
            whole = WholeBody(
                diagonal=float(np.linalg.norm(np.ptp(box, axis=0))),
                weight=math.inf
                if plant.IsAnchored(body)
                else mass * (gravity or _STANDARD_GRAVITY),
            )
            self._whole.update({each.index(): whole for each in welded})

    def of(self, body: BodyIndex) -> WholeBody:
        """Return the whole that a body with geometry is part of."""
        return self._whole[body]


def _corners(mesh: CollisionMesh, X_BG: Floats) -> Floats:
    """Return the (8, 3) corners of the mesh's bounding box, in B."""
    ends = np.stack([mesh.lower, mesh.upper])
    corners = ends[np.indices((2, 2, 2)).reshape(3, 8).T, np.arange(3)]
    return corners @ X_BG[:3, :3].T + X_BG[:3, 3]
