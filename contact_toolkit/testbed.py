"""Bodies that fly, fall and touch, without a simulator: the check of the Drake coupling.

The equations of motion are written out here and integrated by scipy's error-controlled solvers;
nothing is shared with Drake but the contact model itself. Frame F is fixed, z up.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import DOP853, RK23, RK45, OdeSolver, Radau
from scipy.spatial.transform import Rotation

from contact_toolkit.contact.contact_law import NonlinearDamper
from contact_toolkit.contact.contact_model import ContactModel, ContactState
from contact_toolkit.contact.contact_pair import ContactGeometry, ContactPair
from contact_toolkit.contact.friction import Friction
from contact_toolkit.contact.spring_webs import AreaWeb, SpringWeb
from contact_toolkit.shapes.mass_properties import mass_properties
from contact_toolkit.shapes.mesh import CollisionMesh

Floats = NDArray[np.float64]

_SOLVERS: dict[str, type[OdeSolver]] = {
    "RK23": RK23,
    "RK45": RK45,
    "DOP853": DOP853,
    "Radau": Radau,
}
_STATES = 13  # numbers a body: quaternion w x y z, position, angular velocity, velocity


@dataclass(frozen=True)
class MovingBody:
    """A rigid body with its mass properties, geometry and start.

    Attributes
    ----------
    name
        Unlike the other bodies'.
    mesh
        Its surface, in the body frame B [m].
    mass
        [kg], positive.
    p_BoBcm
        (3,) centre of mass, in B [m].
    I_BBcm
        (3, 3) inertia about the centre of mass, in B [kg m²], positive definite.
    X_FB
        (4, 4) pose at the start.
    V_FB
        (6,) angular velocity [rad/s], then velocity of Bo [m/s], in F, at the start.
    """

    name: str
    mesh: CollisionMesh
    mass: float
    p_BoBcm: ArrayLike
    I_BBcm: ArrayLike
    X_FB: ArrayLike = field(default_factory=lambda: np.eye(4))
    V_FB: ArrayLike = field(default_factory=lambda: np.zeros(6))

    def __post_init__(self) -> None:
        inertia = np.asarray(self.I_BBcm, dtype=np.float64)
        if not (np.isfinite(self.mass) and self.mass > 0):
            raise ValueError(f"body {self.name!r}: mass must be positive, not {self.mass}")
        if inertia.shape != (3, 3) or not np.allclose(inertia, inertia.T):
            raise ValueError(f"body {self.name!r}: I_BBcm must be a symmetric (3, 3) matrix")
        if np.linalg.eigvalsh(inertia)[0] <= 0:
            raise ValueError(f"body {self.name!r}: I_BBcm must be positive definite")

    @classmethod
    def from_density(
        cls,
        name: str,
        mesh: CollisionMesh,
        density: float,
        X_FB: ArrayLike | None = None,
        V_FB: ArrayLike | None = None,
    ) -> MovingBody:
        """Make a body of uniform density [kg/m³]; its mesh must be closed and wound outwards."""
        if mesh.solid.kind != "closed":
            defects = "; ".join(mesh.describe_defects())
            raise ValueError(
                f"body {name!r}: a density needs a closed mesh wound outwards, and "
                f"{mesh.source or 'its mesh'} has {defects}"
            )
        mass, p_BoBcm, I_BBcm = mass_properties(mesh.repaired(), density)
        return cls(
            name,
            mesh,
            mass,
            p_BoBcm,
            I_BBcm,
            np.eye(4) if X_FB is None else X_FB,
            np.zeros(6) if V_FB is None else V_FB,
        )


@dataclass(frozen=True)
class Trajectory:
    """States at the accepted steps.

    Attributes
    ----------
    time
        (n,) [s].
    X_FB
        (n, nb, 4, 4) poses.
    V_FB
        (n, nb, 6) angular velocities [rad/s], then velocities of the origins [m/s], in F.
    springs
        (n,) loaded springs.
    contact_state
        The contact state after the last step: anchors and losses.
    evaluations
        Of the forces.
    """

    time: Floats
    X_FB: Floats
    V_FB: Floats
    springs: NDArray[np.int64]
    contact_state: ContactState
    evaluations: int


class Testbed:
    """Moving bodies over a fixed ground, each pair touching by the same law.

    Parameters
    ----------
    bodies
        What moves.
    ground
        A fixed surface in F, or None.
    damper
        The contact law: k, α, n and adhesion.
    web, friction
        As for `ContactPair`.
    gravity
        (3,) in F [m/s²].
    """

    __test__ = False  # not a test case, whatever pytest makes of the name

    def __init__(
        self,
        bodies: Sequence[MovingBody],
        ground: CollisionMesh | None,
        damper: NonlinearDamper,
        *,
        web: SpringWeb = AreaWeb(),  # noqa: B008  immutable
        friction: Friction | None = None,
        gravity: ArrayLike = (0.0, 0.0, -9.81),
    ) -> None:
        if not bodies:
            raise ValueError("bodies must hold at least one MovingBody")
        self.bodies = tuple(bodies)
        self._g_F = np.asarray(gravity, dtype=np.float64)
        self._fixed = 0 if ground is None else 1  # the ground comes first, as Drake's world does
        meshes = [*([] if ground is None else [ground]), *(body.mesh for body in bodies)]
        names = [*([] if ground is None else ["ground"]), *(body.name for body in bodies)]
        self.model = ContactModel(
            names,
            [ContactGeometry(n, n, mesh) for n, mesh in zip(names, meshes, strict=True)],
            [
                ContactPair(a, b, damper, web, friction)
                for a in range(len(names))
                for b in range(a + 1, len(names))
            ],
        )
        self._mass = np.array([body.mass for body in bodies])
        self._p_BoBcm = np.array([np.asarray(body.p_BoBcm, dtype=float) for body in bodies])
        self._I_BBcm = np.array([np.asarray(body.I_BBcm, dtype=float) for body in bodies])
        self._evaluations = 0

    def run(
        self,
        duration: float,
        *,
        method: str = "RK45",
        rtol: float = 1e-8,
        atol: float = 1e-10,
        max_step: float = np.inf,
    ) -> Trajectory:
        """Integrate from the start for `duration` [s], taking over anchors at each accepted step.

        method is RK23, RK45, DOP853 or Radau. Raises RuntimeError where the solver gives up.
        """
        if method not in _SOLVERS:
            raise ValueError(f"method must be one of {sorted(_SOLVERS)}, not {method!r}")
        self._evaluations = 0
        contact_state = self.model.initial_state()

        def rates(_: float, state: Floats) -> Floats:
            return self._rates(state, contact_state)

        solver = _SOLVERS[method](
            rates, 0.0, self._start(), duration, rtol=rtol, atol=atol, max_step=max_step
        )
        times, states, springs = [], [], []
        while True:
            X_FB, V_FB = self._kinematics(solver.y)
            forces = self.model.evaluate(X_FB, V_FB, contact_state)
            contact_state = self.model.advance(contact_state, solver.t, forces)
            times.append(solver.t)
            states.append((X_FB[self._fixed :], V_FB[self._fixed :]))
            springs.append(len(forces.contacts.key))
            if solver.status == "finished":
                break
            if hasattr(solver, "f"):
                solver.f = rates(solver.t, solver.y)  # as the new anchors have it
            message = solver.step()
            if solver.status == "failed":
                raise RuntimeError(f"{method} gave up at t = {solver.t} s: {message}")
        return Trajectory(
            np.array(times),
            np.array([X for X, _ in states]),
            np.array([V for _, V in states]),
            np.array(springs),
            contact_state,
            self._evaluations,
        )

    def _start(self) -> Floats:
        state = np.empty((len(self.bodies), _STATES))
        for row, body in zip(state, self.bodies, strict=True):
            X_FB, V_FB = np.asarray(body.X_FB, float), np.asarray(body.V_FB, float)
            row[:4] = Rotation.from_matrix(X_FB[:3, :3]).as_quat(scalar_first=True)
            row[4:7] = X_FB[:3, 3]
            row[7:] = V_FB
        return state.ravel()

    def _kinematics(self, state: Floats) -> tuple[Floats, Floats]:
        """Poses and velocities of all bodies of the model, the ground's first."""
        rows = state.reshape(-1, _STATES)
        first, count = self._fixed, len(self.model.bodies)
        X_FB = np.tile(np.eye(4), (count, 1, 1))
        V_FB = np.zeros((count, 6))
        X_FB[first:, :3, :3] = Rotation.from_quat(rows[:, :4], scalar_first=True).as_matrix()
        X_FB[first:, :3, 3] = rows[:, 4:7]
        V_FB[first:] = rows[:, 7:]
        return X_FB, V_FB

    def _rates(self, state: Floats, contact_state: ContactState) -> Floats:
        self._evaluations += 1
        rows = state.reshape(-1, _STATES)
        X_FB, V_FB = self._kinematics(state)
        F_Bo_F = np.asarray(self.model.evaluate(X_FB, V_FB, contact_state).body_wrenches)[
            self._fixed :
        ]
        w, v = rows[:, 7:10], rows[:, 10:13]
        R_FB = X_FB[self._fixed :, :3, :3]
        p_BoBcm_F = np.einsum("nij,nj->ni", R_FB, self._p_BoBcm)
        I_F = R_FB @ self._I_BBcm @ R_FB.transpose(0, 2, 1)
        force = F_Bo_F[:, 3:] + self._mass[:, None] * self._g_F
        torque_cm = F_Bo_F[:, :3] - np.cross(p_BoBcm_F, F_Bo_F[:, 3:])
        gyroscopic = np.cross(w, np.einsum("nij,nj->ni", I_F, w))
        alpha = np.linalg.solve(I_F, (torque_cm - gyroscopic)[:, :, None])[:, :, 0]
        a_cm = force / self._mass[:, None]
        rate = np.empty_like(rows)
        q = rows[:, :4]
        # q̇ = ½ (0, ω) q, with ω in F.
        rate[:, 0] = -0.5 * np.einsum("ni,ni->n", w, q[:, 1:])
        rate[:, 1:4] = 0.5 * (q[:, :1] * w + np.cross(w, q[:, 1:]))
        rate[:, 4:7] = v
        rate[:, 7:10] = alpha
        rate[:, 10:13] = a_cm - np.cross(alpha, p_BoBcm_F) - np.cross(w, np.cross(w, p_BoBcm_F))
        return rate.ravel()
