"""Where the motion of each body of a contact model is read, and its force handed back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex


@dataclass(frozen=True)
class BodyMotion:
    """The bodies of a contact model (rows), sorted by how they move.

    Attributes
    ----------
    X_WB
        (nb, 4, 4) poses of the anchored bodies; the identity for others.
    floating
        Rows of the bodies whose motion stands in the plant's state as it is.
    q_start, v_start
        Indices into the plant's positions and velocities of each floating body's quaternion
        [w x y z] and position, and of its angular and translational velocity in W.
    listed
        Rows and indices of the other moving bodies, whose motion is read from the plant's lists.
    """

    X_WB: NDArray[np.float64]
    floating: list[int]
    q_start: list[int]
    v_start: list[int]
    listed: list[tuple[int, BodyIndex]]


def sort_by_motion(
    plant: MultibodyPlant, bodies: Sequence[BodyIndex], *, lists_only: bool = False
) -> BodyMotion:
    """Sort the bodies; with `lists_only`, every moving body is read from the lists.

    Anchored bodies stay where the plant's default parameters put them.
    """
    motion = BodyMotion(np.tile(np.eye(4), (len(bodies), 1, 1)), [], [], [], [])
    context = plant.CreateDefaultContext()
    for row, index in enumerate(bodies):
        body = plant.get_body(index)
        if plant.IsAnchored(body):
            motion.X_WB[row] = plant.EvalBodyPoseInWorld(context, body).GetAsMatrix4()
        elif body.is_floating_base_body() and body.has_quaternion_dofs() and not lists_only:
            motion.floating.append(row)
            motion.q_start.append(body.floating_positions_start())
            motion.v_start.append(body.floating_velocities_start_in_v())
        else:
            motion.listed.append((row, index))
    motion.X_WB.setflags(write=False)
    return motion
