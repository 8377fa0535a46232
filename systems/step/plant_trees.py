"""PlantTrees: the degrees of freedom of a plant, by the bodies that they move together."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex

Integers = NDArray[np.int64]


class PlantTrees:
    """The plant's degrees of freedom as the solver wants them.

    Each floating body, with what is welded to it, is a tree of its own, unless the plant has
    constraints, which may tie it, or it is `tied` by built-in contact; all other velocities, the
    `rest`, make one more tree. Trees stand in the order of their velocities; only a rest with gaps
    comes last, and `order` then sorts velocities so.
    """

    def __init__(
        self, plant: MultibodyPlant, bodies: Sequence[BodyIndex], tied: set[BodyIndex]
    ) -> None:
        context = plant.CreateDefaultContext()
        single = _floating_trees(plant, tied)
        dofs: dict[BodyIndex | None, Integers] = {}  # of a tree, by the body that floats
        for root in single:
            start = plant.get_body(root).floating_velocities_start_in_v()
            dofs[root] = np.arange(start, start + 6)
        every = np.arange(plant.num_velocities())
        self.rest = np.setdiff1d(every, np.concatenate([every[:0], *dofs.values()]))
        gaps = bool((np.diff(self.rest) > 1).any())
        if len(self.rest):
            dofs[None] = self.rest
        roots = sorted(dofs, key=lambda root: (gaps and root is None, dofs[root][0]))
        self.order = np.concatenate([dofs[root] for root in roots]) if gaps else None
        self.nv = [len(dofs[root]) for root in roots]
        self.v_start = [sum(self.nv[:i]) for i in range(len(roots))]
        self.q_start = [-1] * len(roots)
        self.inertia_R = np.zeros((len(roots), 6, 6))
        for tree, root in enumerate(roots):
            if root is not None:
                floating, welded = plant.get_body(root), sorted(single[root], key=int)
                self.q_start[tree] = floating.floating_positions_start()
                inertia = plant.CalcSpatialInertia(context, floating.body_frame(), welded)
                self.inertia_R[tree] = inertia.CopyToFullMatrix6()
        root_of = {body: root for root, welded in single.items() for body in welded}
        self.X_WB = np.tile(np.eye(4), (len(bodies), 1, 1))
        self.X_RB = np.tile(np.eye(4), (len(bodies), 1, 1))
        self.tree = [-1] * len(bodies)
        self.jointed: dict[int, BodyIndex] = {}
        for row, index in enumerate(bodies):
            body = plant.get_body(index)
            X_WB = plant.EvalBodyPoseInWorld(context, body)
            if plant.IsAnchored(body):
                self.X_WB[row] = X_WB.GetAsMatrix4()
                continue
            root = root_of.get(index)
            self.tree[row] = roots.index(root)
            if root is None:
                self.jointed[row] = index
            else:
                X_WR = plant.EvalBodyPoseInWorld(context, plant.get_body(root))
                self.X_RB[row] = (X_WR.inverse() @ X_WB).GetAsMatrix4()


def _floating_trees(plant: MultibodyPlant, tied: set[BodyIndex]) -> dict[BodyIndex, set[BodyIndex]]:
    """Return the bodies that float by themselves, and for each what is welded to it, itself too."""
    if plant.num_constraints():
        return {}
    joints = (plant.get_joint(index) for index in plant.GetJointIndices())
    children = {each.parent_body().index() for each in joints if each.num_velocities() > 0}
    single = {}
    for index in plant.GetFloatingBaseBodies():
        body = plant.get_body(index)
        welded = {each.index() for each in plant.GetBodiesWeldedTo(body)}
        if body.has_quaternion_dofs() and not welded & (children | tied):
            single[index] = welded
    return single
