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
    a, b = linear.bodies.T
    wrench = linear.wrench
    # The body b takes the whole contact along, and turns it; what is left moves a.
    turn = dX_FB[b, :3]
    r = X_FB[a, :3, 3] - X_FB[b, :3, 3]
    V = V_FB[a] - V_FB[b]
    V[:, 3:] -= np.cross(V_FB[b, :3], r)
    dr = dX_FB[a, 3:] - dX_FB[b, 3:]
    xi = dX_FB[a] - dX_FB[b]
    xi[:, 3:] -= _cross(turn, r)
    dV = dV_FB[a] - dV_FB[b]
    dV[:, 3:] -= _cross(dV_FB[b, :3], r) - _cross(dr, V_FB[b, :3])
    on_a = _turned(turn, wrench) - linear.stiffness @ xi - linear.damping @ (dV - _turned(turn, V))
    on_b = -on_a
    on_b[:, :3] -= _cross(dr, wrench[:, 3:]) - _cross(on_a[:, 3:], r)
    slopes = np.zeros_like(dX_FB)
    np.add.at(slopes, a, on_a)
    np.add.at(slopes, b, on_b)
    return slopes


def _cross(columns: Floats, vectors: Floats) -> Floats:
    """Return the vector product of each of (np, 3, n) columns with the pair's of (np, 3)."""
    return np.cross(columns, vectors[:, :, None], axis=1)


def _turned(turn: Floats, pairs_of_vectors: Floats) -> Floats:
    """Return what small rotations (np, 3, n) change of (np, 6)."""
    upper, lower = pairs_of_vectors[:, :3], pairs_of_vectors[:, 3:]
    return np.concatenate([_cross(turn, upper), _cross(turn, lower)], axis=1)
