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
    load
        [N] of all that hangs together with it by joints: what its contacts bear at rest, such as
        those of a robot's foot; infinite likewise.
    """

    diagonal: float
    weight: float
    load: float


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
        tree_of = joint_trees(plant)
        masses = np.bincount(
            tree_of, [plant.get_body(BodyIndex(i)).get_mass(context) for i in range(len(tree_of))]
        )
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
            anchored = plant.IsAnchored(body)
            whole = WholeBody(
                diagonal=float(np.linalg.norm(np.ptp(box, axis=0))),
                weight=math.inf if anchored else mass * gravity,
                load=math.inf if anchored else float(masses[tree_of[int(index)]]) * gravity,
            )
            self._whole.update({each.index(): whole for each in welded})

    def of(self, body: BodyIndex) -> WholeBody:
        """Return the whole that a body with geometry is part of."""
        return self._whole[body]


def joint_trees(plant: MultibodyPlant) -> list[int]:
    """Return a number for each body, equal for bodies of one tree of joints.

    The world is an assembly of its own: what stands on it is not part of it. Nor are free bodies of
    one model instance, which may be all there are.
    """
    world = plant.world_body().index()
    leader = list(range(plant.num_bodies()))

    def join(a: int, b: int) -> None:
        old, new = leader[a], leader[b]
        leader[:] = [new if each == old else each for each in leader]

    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        ends = joint.parent_body().index(), joint.child_body().index()
        if world not in ends:
            join(*map(int, ends))
    return leader


def _corners(mesh: CollisionMesh, X_BG: Floats) -> Floats:
    """Return the (8, 3) corners of the mesh's bounding box, in B."""
    ends = np.stack([mesh.lower, mesh.upper])
    corners = ends[np.indices((2, 2, 2)).reshape(3, 8).T, np.arange(3)]
    return corners @ X_BG[:3, :3].T + X_BG[:3, 3]
