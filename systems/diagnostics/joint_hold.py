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
_MOST_SPRINGS = 500  # looked at one by one, of as many as there are


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
        moved = self._moved(pair, rows, force[None])[0]
        return bool(moved * self._mass <= _HELD * force.sum() ** 2)

    def holds_everywhere(self, pair: int) -> bool:
        """Whether each spring hardly moves the joints, such as between the faces of a hinge.

        Those at their rims, which push aside, count by what they bear.
        """
        rows = np.flatnonzero(self._contacts.pair == pair)
        rows = rows[:: 1 + len(rows) // _MOST_SPRINGS]
        force = self._contacts.normal_force[rows]
        moved = self._moved(pair, rows, np.eye(len(rows)))
        return bool(force.sum() > 0 and force @ moved * self._mass <= _HELD * force.sum())

    def _moved(self, pair: int, rows: NDArray[np.intp], force: Floats) -> Floats:
        """Return f J M⁻¹ Jᵀ fᵀ [N²/kg] for each set (n, rows) of forces along the normals."""
        normal, point = self._contacts.normal_F[rows], self._contacts.p_FC[rows]
        generalized = np.zeros((len(force), self._plant.num_velocities()))
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
        return np.einsum("ni,ij,nj->n", generalized, self._lightness, generalized)
