"""StepLimits: whether a plant answers forces as a linear system does over a step."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JointActuator, JointActuatorIndex, ModelInstanceIndex

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# Of a step's way: Drake's limits push before they are reached.
_AHEAD = 4.0
_CLOSE = 0.999  # of an effort limit


class _Controllers(NamedTuple):
    """Those of one model instance that have an effort limit.

    Attributes
    ----------
    desired, feedforward
        Names of their input ports.
    q, v, own, every
        Rows in positions, velocities, the instance's actuators and all actuators.
    actuators
        Actuators of the instance.
    p, d, effort
        Gains and limits.
    """

    desired: str
    feedforward: str
    q: Integers
    v: Integers
    own: Integers
    every: Integers
    actuators: int
    p: Floats
    d: Floats
    effort: Floats


class StepLimits:
    """Joint limits, and the effort limits of controllers: what bends a plant's answer to forces.

    Parameters
    ----------
    plant
        Finalized and discrete.
    """

    def __init__(self, plant: MultibodyPlant) -> None:
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
        actuators = [
            plant.get_joint_actuator(JointActuatorIndex(i)) for i in range(plant.num_actuators())
        ]
        controlled = [each for each in actuators if each.has_controller()]
        self.bend = bool(q or controlled)
        """Whether there are any, or controllers at all."""
        limited = [each for each in controlled if np.isfinite(each.effort_limit())]
        self._controllers = [
            _of_instance(plant, instance, limited)
            for instance in sorted({each.model_instance() for each in limited}, key=int)
        ]

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


def _of_instance(
    plant: MultibodyPlant, instance: ModelInstanceIndex, limited: list[JointActuator]
) -> _Controllers:
    every = list(plant.GetJointActuatorIndices(instance))
    mine = [each for each in limited if each.model_instance() == instance]
    gains = [each.get_controller_gains() for each in mine]
    return _Controllers(
        plant.get_desired_state_input_port(instance).get_name(),
        plant.get_actuation_input_port(instance).get_name(),
        np.array([each.joint().position_start() for each in mine]),
        np.array([each.joint().velocity_start() for each in mine]),
        np.array([every.index(each.index()) for each in mine]),
        np.array([int(each.index()) for each in mine]),
        len(every),
        np.array([each.p for each in gains]),
        np.array([each.d for each in gains]),
        np.array([each.effort_limit() for each in mine]),
    )


def _unsaturated(
    own: _Controllers,
    q: Floats,
    velocities: Floats,
    step: float,
    inputs: Mapping[str, object],
) -> bool:
    desired = inputs.get(own.desired)
    if not isinstance(desired, np.ndarray):
        return True  # without one Drake leaves the controllers out
    fed = np.zeros(len(own.own))
    for name, rows in ((own.feedforward, own.own), ("actuation", own.every)):
        value = inputs.get(name)
        if isinstance(value, np.ndarray):
            fed = fed + value[rows]
    v = velocities[:, own.v]
    behind = desired[own.own] - q[own.q] - step * v
    effort = fed + own.p * behind + own.d * (desired[own.actuators + own.own] - v)
    return bool((np.abs(effort) < _CLOSE * own.effort).all())
