"""DifferentiatedForces: contact forces with their derivatives, for systems of AutoDiffXd."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray
from pydrake.autodiffutils import AutoDiffXd
from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform_
from pydrake.multibody.math import SpatialVelocity_
from pydrake.multibody.plant import ExternallyAppliedSpatialForce_
from pydrake.systems.framework import BasicVector_, Context, InputPort, LeafSystem, OutputPort

from contact_toolkit import ContactModel, ContactState
from systems.body_motion import BodyMotion
from systems.body_slopes import BodySlopes, count_variables, joined, spatial_force, split
from systems.python_cache import producer

Floats = NDArray[np.float64]


class DifferentiatedForces:
    """Declares in a system of AutoDiffXd the ports of a contact system of doubles.

    The ports of forces carry derivatives: those of `ContactModel.differentiate`, at the contact
    state that the context holds. The others raise RuntimeError when they are asked.

    Parameters
    ----------
    system
        Gets the ports, in the order of the other's.
    other
        The system of doubles.
    model, bodies
        Its contact model, and how the model's bodies are read.
    contact_state
        Reads the contact state of a context of `system`.
    """

    def __init__(
        self,
        system: LeafSystem,
        other: LeafSystem,
        model: ContactModel,
        bodies: BodyMotion,
        contact_state: Callable[[Context], ContactState],
    ) -> None:
        self._model, self._bodies, self._contact_state = model, bodies, contact_state
        size = other.GetInputPort("state").size()
        self._no_state = joined(np.zeros(size), np.zeros((size, 0)))
        self._num_positions = size - other.GetOutputPort("generalized_forces").size()
        self._state = system.DeclareVectorInputPort("state", BasicVector_[AutoDiffXd](size))
        self._poses = _declare_list(system, "body_poses", RigidTransform_[AutoDiffXd]())
        self._velocities = _declare_list(
            system, "body_spatial_velocities", SpatialVelocity_[AutoDiffXd]()
        )
        self._forces = system.DeclareCacheEntry("forces", producer(self._push))
        for i in range(other.num_output_ports()):
            self._declare_output(system, other.get_output_port(i))

    def _declare_output(self, system: LeafSystem, port: OutputPort) -> None:
        name = port.get_name()
        calculate = {
            "generalized_forces": self._output_generalized_forces,
            "spatial_forces": self._output_spatial_forces,
            "body_wrenches": self._output_wrenches,
        }.get(name, _refusing(name))
        if name == "spatial_forces":
            force = ExternallyAppliedSpatialForce_[AutoDiffXd]()
            system.DeclareAbstractOutputPort(name, lambda: AbstractValue.Make([force]), calculate)
        elif port.size() > 0:
            vector = BasicVector_[AutoDiffXd](port.size())
            system.DeclareVectorOutputPort(name, vector, calculate)
        else:
            system.DeclareAbstractOutputPort(name, Value[object], calculate)

    def _read(self, context: Context) -> BodySlopes:
        bodies = self._bodies
        state = self._state.Eval(context) if bodies.uses_state else self._no_state
        listed = [index for _, index in bodies.listed]
        poses = self._poses.Eval(context) if listed else []
        velocities = self._velocities.Eval(context) if listed else []
        X_WB = {index: poses[index].GetAsMatrix4() for index in listed}
        V_WB = {index: velocities[index].get_coeffs() for index in listed}
        numbers = [state, *X_WB.values(), *V_WB.values()]
        count = max(count_variables(each.flat) for each in numbers)
        values, slopes = split(state, count)
        moving = BodySlopes(
            *bodies.read_state(values),
            *(np.zeros((len(self._model.bodies), 6, count)) for _ in "XV"),
        )
        for row, q_start, v_start in bodies.floating:
            q, dq = values[q_start:][:4], slopes[q_start:][:4]
            moving.dX_WB[row, :3] = _turn_of_quaternion(q) @ dq
            moving.dX_WB[row, 3:] = slopes[q_start + 4 :][:3]
            moving.dV_WB[row] = slopes[self._num_positions + v_start :][:6]
        for row, index in bodies.listed:
            moving.set_pose(row, X_WB[index])
            moving.set_velocity(row, V_WB[index])
        return moving

    def _push(self, context: Context, output: AbstractValue) -> None:
        moving, state = self._read(context), self._contact_state(context)
        forces = self._model.evaluate(moving.X_WB, moving.V_WB, state)
        output.set_value((forces.body_wrenches, self._model.differentiate(*moving, state)))

    def _output_generalized_forces(self, context: Context, output: Any) -> None:
        wrenches, slopes = self._forces.Eval(context)
        values = self._bodies.generalized_forces(wrenches)
        changes = np.zeros((len(values), slopes.shape[2]))
        for row, _, v_start in self._bodies.floating:
            changes[v_start : v_start + 6] = slopes[row]
        output.SetFromVector(joined(values, changes))

    def _output_spatial_forces(self, context: Context, output: AbstractValue) -> None:
        wrenches, slopes = self._forces.Eval(context)
        output.set_value(
            [
                spatial_force(index, joined(wrenches[row], slopes[row]))
                for row, index in self._bodies.listed
                if wrenches[row].any()
            ]
        )

    def _output_wrenches(self, context: Context, output: Any) -> None:
        wrenches, slopes = self._forces.Eval(context)
        output.SetFromVector(
            joined(wrenches.ravel(), slopes.reshape(wrenches.size, slopes.shape[2]))
        )


def _turn_of_quaternion(q: Floats) -> Floats:
    """Return (3, 4): how a body turns [rad] as its quaternion [w x y z] of any length changes."""
    w, x, y, z = 2 * q / (q @ q)
    return np.array([[-x, w, -z, y], [-y, z, w, -x], [-z, -y, x, w]])


def _declare_list(system: LeafSystem, name: str, entry: object) -> InputPort:
    return system.DeclareAbstractInputPort(name, AbstractValue.Make([entry]))


def _refusing(name: str) -> Callable[[Context, Any], NoReturn]:
    def refuse(context: Context, output: Any) -> NoReturn:
        del context, output
        raise RuntimeError(
            f"port {name!r} of contact has no derivatives; evaluate it in the diagram of doubles"
        )

    return refuse
