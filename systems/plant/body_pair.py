"""BodyPair: what one body of a contact model does to another."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from contact_toolkit import ContactArrays, ContactModel

Floats = NDArray[np.float64]


class BodyPair:
    """Two bodies of a contact model by name, and which of its pairs of geometries are theirs.

    Raises ValueError for a body that the model does not know, and for two that never touch.
    """

    def __init__(self, model: ContactModel, a: str, b: str) -> None:
        for name in (a, b):
            if name not in model.bodies:
                raise ValueError(
                    f"no body {name!r} in this contact; there are {', '.join(model.bodies)}"
                )
        self.name = f"{a} from {b}"
        self._row = model.bodies.index(a)
        row_b = model.bodies.index(b)
        body_of = model.geometry_bodies
        self._sign = np.zeros(len(model.pairs))
        for i, pair in enumerate(model.pairs):
            sides = body_of[pair.a], body_of[pair.b]
            if sides == (self._row, row_b):
                self._sign[i] = 1.0
            elif sides == (row_b, self._row):
                self._sign[i] = -1.0
        if not self._sign.any():
            raise ValueError(
                f"{a!r} and {b!r} never touch: they are joined, filtered, or the same body"
            )

    def wrench(self, contacts: ContactArrays, X_WB: Floats) -> Floats:
        """Return what the second body does to the first: (6,) torque about Ao [N m], force [N]; W.

        X_WB: (nb, 4, 4) poses of the bodies of the model.
        """
        sign = self._sign[contacts.pair][:, None]
        forces = sign * (
            contacts.normal_force[:, None] * contacts.normal_F + contacts.friction_force_F
        )
        arms = contacts.p_FC - X_WB[self._row, :3, 3]
        return np.concatenate([np.cross(arms, forces).sum(axis=0), forces.sum(axis=0)])
