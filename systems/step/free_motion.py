"""FreeMotion: where a step of a plant leads without contact, in closed form."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JointActuatorIndex, ModelInstanceIndex, MultibodyForces
from pydrake.systems.framework import Context

Floats = NDArray[np.float64]
FORCES = "applied_generalized_force"
"""The plant's port for generalized forces."""


class FreeMotion:
    """What Drake's discrete update comes to where nothing limits it.

        A v⁺ = A v₀ + h (τ(q₀, v₀) − C + B u − p (q₀ + h v₀ − q_d) − d (v₀ − v_d))

    With forces τ of gravity, springs and joint damping, Coriolis forces C, actuation u and the
    gains p, d of controllers; A is the mass matrix and what joint damping and controllers add.
    Spatial forces, effort limits without a controller and controllers without a desired state are
    not in it.

    Parameters
    ----------
    plant
        Finalized and discrete, without constraints.
    """

    def __init__(self, plant: MultibodyPlant) -> None:
        self._plant, self._h = plant, plant.time_step()
        self._nq, self._rest = plant.num_positions(), np.zeros(plant.num_velocities())
        actuation = plant.MakeActuationMatrix()
        self._inputs = {FORCES: np.eye(len(self._rest)), "actuation": actuation}
        # (nv, nq + nv + 2 n) by x and x_d; the rows of x that x_d stands for.
        self._controllers: dict[str, tuple[Floats, list[int]]] = {}
        actuators = [
            plant.get_joint_actuator(JointActuatorIndex(i)) for i in range(plant.num_actuators())
        ]
        for instance in {each.model_instance() for each in actuators}:
            indices = [int(each) for each in plant.GetJointActuatorIndices(instance)]
            port = plant.get_actuation_input_port(instance)
            self._inputs[port.get_name()] = actuation[:, indices]
            self._add_controllers(instance)
        self._limited = any(
            np.isfinite(each.effort_limit()) and not each.has_controller() for each in actuators
        )

    def _add_controllers(self, instance: ModelInstanceIndex) -> None:
        plant, nq, nv = self._plant, self._nq, len(self._rest)
        actuators = list(map(plant.get_joint_actuator, plant.GetJointActuatorIndices(instance)))
        q = [each.joint().position_start() for each in actuators]
        v = [each.joint().velocity_start() for each in actuators]
        gains = np.zeros((nv, nq + nv + 2 * len(actuators)))
        for i, actuator in enumerate(actuators):
            if actuator.has_controller():
                p, d = actuator.get_controller_gains().p, actuator.get_controller_gains().d
                gains[v[i], q[i]], gains[v[i], nq + v[i]] = -p, -d - self._h * p
                gains[v[i], nq + nv + i], gains[v[i], nq + nv + len(actuators) + i] = p, d
        if gains.any():
            port = plant.get_desired_state_input_port(instance)
            self._controllers[port.get_name()] = gains, q + [nq + each for each in v]

    def knows(self, inputs: Mapping[str, object]) -> bool:
        """Whether these inputs are in it."""
        if not self._controllers.keys() <= inputs.keys():
            return False
        known = self._inputs.keys() | self._controllers.keys()
        return all(
            name in known and not (self._limited and name != FORCES)
            for name, value in inputs.items()
            if not isinstance(value, list) or value
        )

    def some_inputs(self, x: Floats) -> dict[str, Floats]:
        """Return inputs to try it with at a state x: small forces, and desired states close by."""
        given = {FORCES} if self._limited else self._inputs.keys() - {"actuation"}
        tried = {name: np.linspace(0.1, 0.2, self._inputs[name].shape[1]) for name in given}
        return tried | {name: x[rows] + 1e-4 for name, (_, rows) in self._controllers.items()}

    def at(self, context: Context, x: Floats, inputs: Mapping[str, object], A: Floats) -> Floats:
        """Return v⁺ (nv,) from the state x (nq + nv), at which the context is."""
        forces = MultibodyForces(self._plant)
        self._plant.CalcForceElementsContribution(context, forces)
        drive = -self._plant.CalcInverseDynamics(context, self._rest, forces)
        for name, matrix in self._inputs.items():
            if name in inputs:
                drive += matrix @ np.asarray(inputs[name])
        for name, (gains, _) in self._controllers.items():
            drive += gains @ np.concatenate([x, np.asarray(inputs[name])])
        return x[self._nq :] + self._h * np.linalg.solve(A, drive)
