"""StepLimits: whether a plant answers forces as a linear system does over a step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant

from systems.step.controllers import Controllers

Floats = NDArray[np.float64]

# Of a step's way: Drake's limits push before they are reached.
_AHEAD = 4.0
_CLOSE = 0.999  # of an effort limit


class StepLimits:
    """Joint limits, and the effort limits of controllers: what bends a plant's answer to forces.

    Parameters
    ----------
    plant
        Finalized and discrete.
    controllers
        Its own.
    """

    def __init__(self, plant: MultibodyPlant, controllers: Sequence[Controllers]) -> None:
        q, v, lower, upper = [], [], [], []
        for index in plant.GetJointIndices():
            joint = plant.get_joint(index)
            low, high = joint.position_lower_limits(), joint.position_upper_limits()
            if joint.num_positions() != joint.num_velocities():
                continue
            for i in np.flatnonzero(np.isfinite(low) | np.isfinite(high)):
                q.append(joint.position_start() + int(i))
                v.append(joint.velocity_start() + int(i))
                lower.append(low[i])
                upper.append(high[i])
        self._q, self._v = np.array(q, int), np.array(v, int)
        self._lower, self._upper = np.array(lower), np.array(upper)
        self._controllers = [each for each in controllers if np.isfinite(each.limit).any()]
        self.bend = bool(q or controllers)
        """Whether there are any, or controllers at all."""

    def amid(self, q: Floats) -> Floats:
        """Return positions q (nq,) with those of limited joints amid their limits."""
        q = q.copy()
        lower = np.where(np.isfinite(self._lower), self._lower, self._upper - 1)
        upper = np.where(np.isfinite(self._upper), self._upper, self._lower + 1)
        q[self._q] = (lower + upper) / 2
        return q

    def are_far(
        self, q: Floats, velocities: Floats, step: float, inputs: Mapping[str, object]
    ) -> bool:
        """Whether steps that end with any of these velocities (n, nv) are far from all limits."""
        if len(self._q):
            q_limited = q[self._q]
            ahead = q_limited + _AHEAD * step * velocities[:, self._v]
            if (np.minimum(ahead, q_limited) <= self._lower).any():
                return False
            if (np.maximum(ahead, q_limited) >= self._upper).any():
                return False
        return all(_unsaturated(each, q, velocities, step, inputs) for each in self._controllers)


def _unsaturated(
    own: Controllers, q: Floats, velocities: Floats, step: float, inputs: Mapping[str, object]
) -> bool:
    desired = inputs.get(own.desired)
    if not isinstance(desired, np.ndarray):
        return True  # without one Drake leaves the controllers out
    effort = own.pull(q, velocities, step, desired)
    for name, rows in ((own.feedforward, own.own), ("actuation", own.every)):
        value = inputs.get(name)
        if isinstance(value, np.ndarray):
            effort = effort + value[rows]
    return bool((np.abs(effort) < _CLOSE * own.limit).all())
