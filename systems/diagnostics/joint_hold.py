"""JointHold: whether joints leave two geometries a way out of each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, JacobianWrtVariable

from contact_toolkit import ContactArrays, ContactModel

Floats = NDArray[np.float64]

# [-] Of what a push would give to all of the plant's mass at once: what moves joints less parts
# nothing, whatever its force.
_HELD = 1e-2


class JointHold:
    """The joints of a plant at some positions, against the contacts of a model there.

    Parameters
    ----------
    plant
        Finalized.
    model, bodies
        The contact model, and the plant's body for each of its bodies.
    q
        (nq,) positions.
    contacts
        What is loaded there, in W.
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        model: ContactModel,
        bodies: Sequence[BodyIndex],
        q: Floats,
        contacts: ContactArrays,
    ) -> None:
        self._plant, self._model, self._bodies = plant, model, bodies
        self._contacts = contacts
        self._context = plant.CreateDefaultContext()
        plant.SetPositions(self._context, q)
        self._mass = plant.CalcTotalMass(self._context)
        self._lightness = np.linalg.pinv(plant.CalcMassMatrix(self._context))

    def holds_against_push(self, pair: int) -> bool:
        """Whether all springs together hardly move the joints, such as those around an axle."""
        rows = np.flatnonzero(self._contacts.pair == pair)
        force = self._contacts.normal_force[rows]
        generalized = self._generalized(pair, rows, force)
        moved = generalized @ self._lightness @ generalized  # [N²/kg]
        return bool(moved * self._mass <= _HELD * force.sum() ** 2)

    def _generalized(self, pair: int, rows: NDArray[np.intp], force: Floats) -> Floats:
        """Return what forces (rows,) along the normals are to the joints, (nv,)."""
        normal, point = self._contacts.normal_F[rows], self._contacts.p_FC[rows]
        generalized = np.zeros(self._plant.num_velocities())
        sides = self._model.pairs[pair].a, self._model.pairs[pair].b
        world = self._plant.world_frame()
        for sign, geometry in zip((1, -1), sides, strict=True):
            body = self._plant.get_body(self._bodies[self._model.geometry_bodies[geometry]])
            p_WBo = self._plant.EvalBodyPoseInWorld(self._context, body).translation()
            wrench = np.hstack([np.cross(point - p_WBo, normal), normal])
            J = self._plant.CalcJacobianSpatialVelocity(
                self._context, JacobianWrtVariable.kV, body.body_frame(), np.zeros(3), world, world
            )
            generalized += sign * (force @ wrench) @ J
        return generalized
