"""How the wrenches on all bodies change as the bodies move: derivatives along given motions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from contact_toolkit import _core

Floats = NDArray[np.float64]


def wrench_slopes(
    linear: _core.Linearization, X_FB: Floats, V_FB: Floats, dX_FB: Floats, dV_FB: Floats
) -> Floats:
    """Return (nb, 6, n) changes of the wrenches on bodies along n motions.

    See `ContactModel.differentiate` for the arguments.
    """
    slopes = np.zeros_like(dX_FB)
    for (a, b), wrench, stiffness, damping in zip(
        linear.bodies, linear.wrench, linear.stiffness, linear.damping, strict=True
    ):
        # The body b takes the whole contact along, and turns it; what is left moves a.
        turn = dX_FB[b, :3]
        r = X_FB[a, :3, 3] - X_FB[b, :3, 3]
        V = V_FB[a] - V_FB[b]
        V[3:] -= np.cross(V_FB[b, :3], r)
        dr = dX_FB[a, 3:] - dX_FB[b, 3:]
        xi = dX_FB[a] - dX_FB[b]
        xi[3:] -= _cross(turn, r)
        dV = dV_FB[a] - dV_FB[b]
        dV[3:] -= _cross(dV_FB[b, :3], r) - _cross(dr, V_FB[b, :3])
        dV -= np.concatenate([_cross(turn, V[:3]), _cross(turn, V[3:])])
        on_a = np.concatenate([_cross(turn, wrench[:3]), _cross(turn, wrench[3:])])
        on_a -= stiffness @ xi + damping @ dV
        slopes[a] += on_a
        slopes[b] -= on_a
        slopes[b, :3] -= _cross(dr, wrench[3:]) - _cross(on_a[3:], r)
    return slopes


def _cross(columns: Floats, vector: Floats) -> Floats:
    return np.cross(columns.T, vector).T
