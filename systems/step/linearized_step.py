"""LinearizedStep: how the end of an implicit step changes with its start and with an input."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.tree import BodyIndex, JacobianWrtVariable
from pydrake.systems.framework import Context

from contact_toolkit import ContactModel, ContactState
from systems.body_slopes import BodySlopes, joined, spatial_force, split
from systems.step.plant_twin import PlantTwin

Floats = NDArray[np.float64]
_OURS = "applied_generalized_force"


class LinearizedStep(NamedTuple):
    """x⁺ ≈ x_next + A dx + B du, for a step that starts at x + dx under the input u + du.

    Attributes
    ----------
    A
        (nx, nx) with x = [q; v] of the plant.
    B
        (nx, nu).
    x, u, x_next
        (nx,), (nu,), (nx,): about which.
    time_step
        [s]

    Examples
    --------
    A free mass of 2 kg as a system of Drake's; `NonlinearDamperContact.LinearizeStep` makes such a
    step of a plant in contact.

    >>> import numpy as np
    >>> from pydrake.systems.primitives import LinearSystem
    >>> from systems import LinearizedStep
    >>> h, rest = 0.01, np.zeros(2)
    >>> A, B = np.array([[1, h], [0, 1]]), np.array([[h * h / 2], [h / 2]])
    >>> step = LinearizedStep(A, B, x=rest, u=np.zeros(1), x_next=rest, time_step=h)
    >>> system = LinearSystem(step.A, step.B, np.eye(2), np.zeros((2, 1)), step.time_step)
    >>> system.time_period()
    0.01
    """

    A: Floats
    B: Floats
    x: Floats
    u: Floats
    x_next: Floats
    time_step: float


class StepSlopes:
    """Derivatives of implicit steps, by the implicit function theorem.

    The velocities v⁺ that a step ends with solve R = v⁺ − Φ(x, u, Jᵀ F(x, v⁺)) = 0, where Φ is the
    plant's own update under generalized forces. All of it is evaluated once with AutoDiffXd, of
    x, u and v⁺; then dv⁺ = −(∂R/∂v⁺)⁻¹ (∂R/∂x dx + ∂R/∂u du).

    Parameters
    ----------
    twin
        Whose update it is.
    model, bodies
        The contact model, and the plant's body for each of its bodies.
    jointed
        By row, bodies that the solver moves by their Jacobians; the others float, or stay.
    X_WB
        (nb, 4, 4) poses, of those that stay.
    time_step
        [s]
    """

    def __init__(
        self,
        twin: PlantTwin,
        model: ContactModel,
        bodies: Sequence[BodyIndex],
        jointed: Mapping[int, BodyIndex],
        X_WB: Floats,
        time_step: float,
    ) -> None:
        self._diagram, self._plant = twin.with_derivatives()
        self._model, self._jointed, self._X_WB, self._step = model, jointed, X_WB, time_step
        self._floating = {
            row: index
            for row, index in enumerate(bodies)
            if row not in jointed and not twin.plant.IsAnchored(twin.plant.get_body(index))
        }

    def at(
        self,
        x: Floats,
        inputs: Mapping[str, object],
        state: ContactState,
        v_next: Floats,
        port: str,
    ) -> LinearizedStep:
        """Linearize the step from x, at the contact state there, that ends at velocities v_next."""
        plant, h = self._plant, self._step
        nq, nv, nu = plant.num_positions(), plant.num_velocities(), self._size_of(port)
        u = np.array(inputs.get(port, np.zeros(nu)), float)
        q, v, u_ad, w = np.split(
            joined(np.concatenate([x, u, v_next]), np.eye(nq + nv + nu + nv)),
            [nq, nq + nv, nq + nv + nu],
        )
        context, elsewhere = self._new_context(), self._new_context()
        plant.SetPositionsAndVelocities(context, np.concatenate([q, v]))
        q_next = q + h * plant.MapVelocityToQDot(context, w)
        forces = _Forces(self._model, self._X_WB, nv, nq + nv + nu + nv)
        plant.SetPositions(elsewhere, q_next)
        for row, index in self._floating.items():
            forces.add(row, *self._kinematics(elsewhere, index))
        plant.SetPositions(elsewhere, q + h * plant.MapVelocityToQDot(context, v))
        for row, index in self._jointed.items():
            forces.add(row, *self._kinematics(elsewhere, index), since=(v, h))
        given = {port: u, _OURS: np.zeros(nv)} | dict(inputs) | {port: u_ad}
        given[_OURS] = given[_OURS] + forces.generalized(w, state)
        for name, value in given.items():
            plant.GetInputPort(name).FixValue(context, _with_derivatives(value))
        residual = split(w, forces.count)[1] - split(self._reached(context), forces.count)[1]
        dv = -np.linalg.solve(residual[:, -nv:], residual[:, :-nv])
        q_end, dq = split(q_next, forces.count)
        slopes = np.vstack([dq[:, :-nv] + dq[:, -nv:] @ dv, dv])
        x_next = np.concatenate([q_end, v_next])
        return LinearizedStep(slopes[:, : nq + nv], slopes[:, nq + nv :], x.copy(), u, x_next, h)

    def _size_of(self, port: str) -> int:
        ports = [self._plant.get_input_port(i) for i in range(self._plant.num_input_ports())]
        sizes = {each.get_name(): each.size() for each in ports if each.size() > 0}
        if port not in sizes:
            raise ValueError(
                f"input_port must be a vector port of the plant, one of {list(sizes)}, not {port!r}"
            )
        return sizes[port]

    def _new_context(self) -> Context:
        return self._plant.GetMyMutableContextFromRoot(self._diagram.CreateDefaultContext())

    def _kinematics(self, context: Context, index: BodyIndex) -> tuple[Any, Any]:
        """Return the pose (4, 4) of a body, and the Jacobian (6, nv) of its velocity in W by v."""
        plant, body = self._plant, self._plant.get_body(index)
        world = plant.world_frame()
        jacobian = plant.CalcJacobianSpatialVelocity(
            context, JacobianWrtVariable.kV, body.body_frame(), np.zeros(3), world, world
        )
        return plant.EvalBodyPoseInWorld(context, body).GetAsMatrix4(), jacobian

    def _reached(self, context: Context) -> Any:
        if self._plant.has_sampled_output_ports():
            result = self._new_context()
            self._plant.CalcForcedUnrestrictedUpdate(context, result.get_mutable_state())
            values = result.get_discrete_state()
        else:
            values = self._plant.EvalUniquePeriodicDiscreteUpdate(context)
        return values.get_vector(0).CopyToVector()[self._plant.num_positions() :]


class _Forces:
    """Contact of bodies at the end of a step, with derivatives by `count` variables."""

    def __init__(self, model: ContactModel, X_WB: Floats, nv: int, count: int) -> None:
        self._model, self._nv, self.count = model, nv, count
        slopes = (np.zeros((len(X_WB), 6, count)) for _ in "XV")
        self._moving = BodySlopes(X_WB.copy(), np.zeros((len(X_WB), 6)), *slopes)
        self._jacobians: dict[int, Any] = {}
        self._since: dict[int, tuple[Any, float]] = {}

    def add(
        self, row: int, X_WB: Any, jacobian: Any, since: tuple[Any, float] | None = None
    ) -> None:
        """Add a body at X_WB; `since`: where it would be, had it moved at such v for so long."""
        self._moving.set_pose(row, X_WB)
        self._jacobians[row] = jacobian
        if since is not None:
            self._since[row] = since

    def generalized(self, w: Any, state: ContactState) -> Any:
        """Return (nv,) of AutoDiffXd, at velocities w."""
        moving = self._moving
        for row, jacobian in self._jacobians.items():
            moving.set_velocity(row, jacobian @ w)
            if row in self._since:
                v, duration = self._since[row]
                moving.displace(row, duration * (jacobian @ (w - v)))
        wrenches = self._model.evaluate(moving.X_WB, moving.V_WB, state).body_wrenches
        slopes = self._model.differentiate(*moving, state)
        total = joined(np.zeros(self._nv), np.zeros((self._nv, self.count)))
        for row, jacobian in self._jacobians.items():
            total = total + jacobian.T @ joined(wrenches[row], slopes[row])
        return total


def _with_derivatives(value: Any) -> Any:
    """Return the value of an input port as a plant of AutoDiffXd takes it."""
    if isinstance(value, list):
        return [
            spatial_force(
                each.body_index,
                joined(each.F_Bq_W.get_coeffs(), np.zeros((6, 0))),
                each.p_BoBq_B,
            )
            for each in value
        ]
    if value.dtype == object:
        return value
    return joined(np.asarray(value, float), np.zeros((len(value), 0)))
