"""How fast contact springs swing the bodies, which bounds the time step of a discrete plant."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import Context

from contact_toolkit import ContactArrays

Floats = NDArray[np.float64]


class ContactFrequency:
    """Bounds the highest natural frequency of a plant's bodies on their contact springs.

    A discrete plant takes contact forces explicitly: they are kept over a step, so a mode of
    frequency ω gains energy when the step exceeds 2/ω.

    Parameters
    ----------
    plant
        Finalized; its default masses are used.
    bodies
        The plant's body for each body of the contact model.
    pair_bodies
        (np, 2) rows of the two bodies of each pair of the model.
    """

    def __init__(
        self, plant: MultibodyPlant, bodies: Sequence[BodyIndex], pair_bodies: NDArray[np.intp]
    ) -> None:
        self._pair_bodies = pair_bodies
        context = plant.CreateDefaultContext()
        self._mobility_B = np.array([_mobility(plant, context, body) for body in bodies])

    def bound(
        self,
        X_WB: Floats,
        contacts: ContactArrays,
        *,
        stiffness: Floats | None = None,
        enough: float = 0.0,
    ) -> float:
        """Return a bound on the highest frequency [rad/s]; zero without contact.

        Parameters
        ----------
        X_WB
            (nb, 4, 4) poses of the bodies.
        contacts
            Their loaded springs, in W.
        stiffness
            (nc,) of each spring [N/m], in place of its own.
        enough
            A bound below this [rad/s] need not be close: it is found without eigenvalues.

        Notes
        -----
        Exact for one body on springs to a fixed one, or two bodies on one spring. In general each
        spring between moving bodies is split into one spring to the ground for each of them, stiff
        enough to store no less energy: k (u − v)² ≤ k (1 + s) u² + k (1 + 1/s) v² for any s > 0, s
        the ratio of the two mobilities along the spring. Joints only add inertia to a body.
        """
        R = X_WB[:, :3, :3]
        turn = np.zeros((len(R), 6, 6))
        turn[:, :3, :3] = turn[:, 3:, 3:] = R
        mobility = turn @ self._mobility_B @ turn.transpose(0, 2, 1)
        sides = self._pair_bodies[contacts.pair]
        arms = contacts.p_FC[:, None] - X_WB[sides, :3, 3]
        normals = np.broadcast_to(contacts.normal_F[:, None], arms.shape)
        jacobians = np.concatenate([np.cross(arms, normals), normals], axis=2)
        along = np.einsum("nsi,nsij,nsj->ns", jacobians, mobility[sides], jacobians)
        k = contacts.stiffness if stiffness is None else stiffness
        grounded = np.divide(  # stiffness of each spring's two springs to the ground
            k[:, None] * along.sum(axis=1, keepdims=True),
            along,
            where=along > 0,
            out=np.zeros_like(along),
        )
        # The sum of a body's squared frequencies is none less than the largest.
        sums = np.bincount(sides.ravel(), weights=(grounded * along).ravel())
        if sums.size == 0 or sums.max() < enough**2:
            return math.sqrt(sums.max(initial=0.0))
        square = 0.0
        for body in np.unique(sides[along > 0]):
            mine = sides == body
            J = jacobians[mine]
            K = J.T @ (grounded[mine][:, None] * J)
            square = max(square, np.linalg.eigvals(mobility[body] @ K).real.max())
        return math.sqrt(square)


def _mobility(plant: MultibodyPlant, context: Context, index: BodyIndex) -> Floats:
    """Return the inverse spatial inertia (6, 6) of a body and what is welded to it, about Bo in B.

    Zero for anchored bodies and for bodies without mass, which only their joints make heavy.
    """
    body = plant.get_body(index)
    if plant.IsAnchored(body):
        return np.zeros((6, 6))
    welded = [each.index() for each in plant.GetBodiesWeldedTo(body)]
    inertia = plant.CalcSpatialInertia(context, body.body_frame(), welded)
    matrix = inertia.CopyToFullMatrix6()
    return np.linalg.inv(matrix) if np.linalg.matrix_rank(matrix) == 6 else np.zeros((6, 6))
