"""BodySlopes: how bodies move, with derivatives; and numbers of AutoDiffXd as arrays and back."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.autodiffutils import AutoDiffXd, ExtractGradient, ExtractValue, InitializeAutoDiff
from pydrake.multibody.math import SpatialForce_
from pydrake.multibody.plant import ExternallyAppliedSpatialForce_

Floats = NDArray[np.float64]
AutoDiffs = NDArray[Any]


class BodySlopes(NamedTuple):
    """Where bodies are and how they move, with derivatives by n variables.

    Attributes
    ----------
    X_WB, V_WB
        (nb, 4, 4), (nb, 6).
    dX_WB
        (nb, 6, n) how each turns [rad], then how its origin moves [m].
    dV_WB
        (nb, 6, n).
    """

    X_WB: Floats
    V_WB: Floats
    dX_WB: Floats
    dV_WB: Floats

    def set_pose(self, row: int, X_WB: AutoDiffs) -> None:
        """Set a body's pose, (4, 4)."""
        values, slopes = split(X_WB, self.dX_WB.shape[2])
        self.X_WB[row] = values
        spin = np.einsum("ikn,jk->ijn", slopes[:3, :3], values[:3, :3])  # dR Rᵀ
        self.dX_WB[row, :3] = spin[2, 1], spin[0, 2], spin[1, 0]
        self.dX_WB[row, 3:] = slopes[:3, 3]

    def displace(self, row: int, xi: AutoDiffs) -> None:
        """Turn and move a body by xi (6,), as a quaternion is stepped: by 2 atan(‖θ‖/2)."""
        values, slopes = split(xi, self.dX_WB.shape[2])
        half, dhalf = values[:3] / 2, slopes[:3] / 2
        cross = np.cross(np.eye(3), half)  # half ×
        gain = 2 / (1 + half @ half)
        R = np.eye(3) + gain * (cross + cross @ cross)
        self.X_WB[row, :3, :3] = R @ self.X_WB[row, :3, :3]
        self.X_WB[row, :3, 3] += values[3:]
        self.dX_WB[row, :3] = R @ self.dX_WB[row, :3] + gain * (dhalf + cross @ dhalf)
        self.dX_WB[row, 3:] += slopes[3:]

    def set_velocity(self, row: int, V_WB: AutoDiffs) -> None:
        """Set a body's spatial velocity, (6,)."""
        self.V_WB[row], self.dV_WB[row] = split(V_WB, self.dV_WB.shape[2])


def split(numbers: AutoDiffs, count: int) -> tuple[Floats, Floats]:
    """Return values, of the shape of `numbers`, and derivatives by `count` variables, (..., n)."""
    column = numbers.reshape(-1, 1)
    slopes = np.zeros((numbers.size, count))
    if count_variables(numbers.flat) > 0:
        slopes[:] = ExtractGradient(column)
    return ExtractValue(column).reshape(numbers.shape), slopes.reshape(*numbers.shape, count)


def joined(values: Floats, slopes: Floats) -> AutoDiffs:
    """Return (m,) numbers of these values (m,) and derivatives (m, n)."""
    return InitializeAutoDiff(values.reshape(-1, 1), slopes).reshape(values.shape)


def count_variables(numbers: Iterable[AutoDiffXd]) -> int:
    """Return by how many variables numbers are derived; constants are by none."""
    return max((len(number.derivatives()) for number in numbers), default=0)


def spatial_force(index: Any, wrench: AutoDiffs, p_BoBq_B: Any = (0.0, 0.0, 0.0)) -> Any:
    """Return Drake's force of AutoDiffXd on a body, of torque and force (6,) in W at Bq."""
    force = ExternallyAppliedSpatialForce_[AutoDiffXd]()
    force.body_index = index
    force.p_BoBq_B = joined(np.array(p_BoBq_B), np.zeros((3, 0)))
    force.F_Bq_W = SpatialForce_[AutoDiffXd](wrench[:3], wrench[3:])
    return force
