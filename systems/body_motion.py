"""BodyMotion: reads the motion of a contact model's bodies from a plant, and hands forces back."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialForce, SpatialVelocity
from pydrake.multibody.plant import ExternallyAppliedSpatialForce, MultibodyPlant
from pydrake.multibody.tree import BodyIndex

from contact_toolkit import FloatingBodies

Floats = NDArray[np.float64]


class BodyMotion:
    """The bodies of a contact model, sorted by how they move.

    - Anchored bodies stay where the plant's default parameters put them.
    - Floating bodies (on the quaternion joint that the plant gives a free body) stand in its state.
    - All others are read from the plant's lists of poses and velocities over all bodies.

    Parameters
    ----------
    plant
        Finalized.
    bodies
        The plant's body for each body (row) of the model.
    lists_only
        Read floating bodies from the lists too.

    Attributes
    ----------
    uses_state, uses_lists
        Whether a body is read from the state, from the lists.
    """

    def __init__(
        self, plant: MultibodyPlant, bodies: Sequence[BodyIndex], *, lists_only: bool = False
    ) -> None:
        X_WB = np.tile(np.eye(4), (len(bodies), 1, 1))
        rows: list[int] = []
        q_start: list[int] = []
        v_start: list[int] = []
        self._listed: list[tuple[int, BodyIndex]] = []
        context = plant.CreateDefaultContext()
        for row, index in enumerate(bodies):
            body = plant.get_body(index)
            if plant.IsAnchored(body):
                X_WB[row] = plant.EvalBodyPoseInWorld(context, body).GetAsMatrix4()
            elif body.is_floating_base_body() and body.has_quaternion_dofs() and not lists_only:
                rows.append(row)
                q_start.append(body.floating_positions_start())
                v_start.append(body.floating_velocities_start_in_v())
            else:
                self._listed.append((row, index))
        self._starts = list(zip(rows, q_start, v_start, strict=True))
        self.uses_state, self.uses_lists = bool(self._starts), bool(self._listed)
        self._floating = FloatingBodies(
            rows,
            q_start,
            v_start,
            X_WB,
            num_positions=plant.num_positions(),
            num_velocities=plant.num_velocities(),
        )

    @property
    def floating(self) -> list[tuple[int, int, int]]:
        """Row of each body read from the state, and where its numbers start in q and in v."""
        return self._starts

    @property
    def listed(self) -> list[tuple[int, BodyIndex]]:
        """Row of each body read from the lists, and its index in them."""
        return self._listed

    def read_state(self, state: Floats) -> tuple[Floats, Floats]:
        """Return poses X_WB (nb, 4, 4) and velocities V_WB (nb, 6) = [w; v] from the state [q; v].

        Those of listed bodies are the identity and zero, to be filled in.
        """
        return self._floating.gather(state)

    def fill_in_poses(self, X_WB: Floats, poses: Sequence[RigidTransform]) -> None:
        """Fill in the listed bodies from the poses of all bodies of the plant."""
        for row, body in self._listed:
            X_WB[row] = poses[body].GetAsMatrix4()

    def fill_in_velocities(self, V_WB: Floats, velocities: Sequence[SpatialVelocity]) -> None:
        """Fill in the listed bodies from the velocities of all bodies of the plant."""
        for row, body in self._listed:
            V_WB[row] = velocities[body].get_coeffs()

    def generalized_forces(self, body_wrenches: Floats) -> Floats:
        """Return the (nv,) generalized forces on the floating bodies.

        body_wrenches: (nb, 6) torque about Bo and force in W.
        """
        return self._floating.scatter(body_wrenches)

    def spatial_forces(self, body_wrenches: Floats) -> list[ExternallyAppliedSpatialForce]:
        """Return the forces on the listed bodies, without the zeros."""
        forces = []
        for row, body in self._listed:
            if body_wrenches[row].any():
                force = ExternallyAppliedSpatialForce()
                force.body_index = body
                force.p_BoBq_B = np.zeros(3)
                force.F_Bq_W = SpatialForce(body_wrenches[row, :3], body_wrenches[row, 3:])
                forces.append(force)
        return forces
