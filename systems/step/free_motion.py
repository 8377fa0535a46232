"""FreeMotion: where a step of a plant leads without contact, in closed form."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JointActuatorIndex, MultibodyForces
from pydrake.systems.framework import Context

from systems.step.controllers import Controllers

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
    controllers
        Its own.
    """

    def __init__(self, plant: MultibodyPlant, controllers: Sequence[Controllers]) -> None:
        self._plant, self._controllers = plant, {each.desired: each for each in controllers}
        self._nq, self._rest = plant.num_positions(), np.zeros(plant.num_velocities())
        actuation = plant.MakeActuationMatrix()
        self._inputs = {FORCES: np.eye(len(self._rest)), "actuation": actuation}
        actuators = [
            plant.get_joint_actuator(JointActuatorIndex(i)) for i in range(plant.num_actuators())
        ]
        for instance in {each.model_instance() for each in actuators}:
            indices = [int(each) for each in plant.GetJointActuatorIndices(instance)]
            port = plant.get_actuation_input_port(instance)
            self._inputs[port.get_name()] = actuation[:, indices]
        self._limited = any(
            np.isfinite(each.effort_limit()) and not each.has_controller() for each in actuators
        )

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
        for name, each in self._controllers.items():
            tried[name] = np.zeros(2 * each.actuators)
            tried[name][each.own] = x[each.q] + 1e-4
            tried[name][each.actuators + each.own] = x[self._nq + each.v] + 1e-4
        return tried

    def at(self, context: Context, x: Floats, inputs: Mapping[str, object], A: Floats) -> Floats:
        """Return v⁺ (nv,) from the state x (nq + nv), at which the context is."""
        q, v, step = x[: self._nq], x[self._nq :], self._plant.time_step()
        forces = MultibodyForces(self._plant)
        self._plant.CalcForceElementsContribution(context, forces)
        drive = -self._plant.CalcInverseDynamics(context, self._rest, forces)
        for name, matrix in self._inputs.items():
            if name in inputs:
                drive += matrix @ np.asarray(inputs[name])
        for name, each in self._controllers.items():
            np.add.at(drive, each.v, each.pull(q, v, step, np.asarray(inputs[name])))
        return v + step * np.linalg.solve(A, drive)
