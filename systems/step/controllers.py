"""Controllers: the PD-controlled actuators of a plant, by model instance."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JointActuatorIndex, ModelInstanceIndex

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


class Controllers(NamedTuple):
    """Those of one model instance, n of them.

    Attributes
    ----------
    desired, feedforward
        Names of their input ports.
    q, v
        (n,) rows in positions and velocities.
    own, every
        (n,) rows in the instance's actuators, and in all actuators.
    actuators
        Number of the instance's.
    p, d, limit
        (n,) gains [N/m, N s/m; N m/rad, …] and effort limits [N, N m].
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
    limit: Floats

    def pull(self, q: Floats, v: Floats, step: float, desired: Floats) -> Floats:
        """Return efforts (..., n) at the end of a step from q (nq,) at velocities v (..., nv)."""
        v = v[..., self.v]
        behind = desired[self.own] - q[self.q] - step * v
        return self.p * behind + self.d * (desired[self.actuators + self.own] - v)


def controllers_of(plant: MultibodyPlant) -> list[Controllers]:
    """Return those of every model instance that has some."""
    actuators = [
        plant.get_joint_actuator(JointActuatorIndex(i)) for i in range(plant.num_actuators())
    ]
    instances = {each.model_instance() for each in actuators if each.has_controller()}
    return [_of_instance(plant, instance) for instance in sorted(instances, key=int)]


def _of_instance(plant: MultibodyPlant, instance: ModelInstanceIndex) -> Controllers:
    indices = list(plant.GetJointActuatorIndices(instance))
    rows = [i for i, each in enumerate(indices) if plant.get_joint_actuator(each).has_controller()]
    mine = [plant.get_joint_actuator(indices[row]) for row in rows]
    gains = [each.get_controller_gains() for each in mine]
    return Controllers(
        plant.get_desired_state_input_port(instance).get_name(),
        plant.get_actuation_input_port(instance).get_name(),
        np.array([each.joint().position_start() for each in mine]),
        np.array([each.joint().velocity_start() for each in mine]),
        np.array(rows),
        np.array([int(indices[row]) for row in rows]),
        len(indices),
        np.array([each.p for each in gains]),
        np.array([each.d for each in gains]),
        np.array([each.effort_limit() for each in mine]),
    )
