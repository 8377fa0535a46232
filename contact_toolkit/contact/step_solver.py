"""StepSolver: steps of a discrete multibody system, solved implicitly in the contact forces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from contact_toolkit import _core
from contact_toolkit.contact.contact_model import ContactModel, ContactState

Floats = NDArray[np.float64]

StepSolution = _core.StepSolution


class StepSolver:
    """Backward Euler in all contact forces: Newton's method, island by island; immutable.

        A (v⁺ − v_free) = h Σ Jᵀ F(q⁺, v⁺),   q⁺ = q₀ + h N v⁺

    Parameters
    ----------
    model
        The contact model; F is its frame.
    num_positions, num_velocities
        Of the whole system: nq, nv.
    v_start, nv, q_start
        For each tree (a block of A): first velocity and number of velocities; and, of a single
        rigid body on a quaternion joint, its first position ([w x y z], then position), else −1.
        Its velocities are angular, then translational, in F.
    inertia_R
        (nt, 6, 6) spatial inertias of floating trees about the floating body's origin, in its frame
        R, rotation first; others are ignored.
    tree
        For each body of the model its tree; −1: it does not move.
    X_RB
        (nb, 4, 4) poses of bodies of floating trees in R.

    Raises
    ------
    ValueError
        For trees that overlap or lie outside the system, and arrays of the wrong length.

    Examples
    --------
    >>> import numpy as np
    >>> from contact_toolkit import CollisionMesh, ContactGeometry, ContactModel, ContactPair
    >>> from contact_toolkit import NonlinearDamper, StepSolver
    >>> from contact_toolkit.shapes.primitives import box
    >>> cube = CollisionMesh(*box([0.1, 0.1, 0.1]))
    >>> geometries = [ContactGeometry(name, name, cube) for name in ("table", "brick")]
    >>> pair = ContactPair(0, 1, NonlinearDamper(k=1e9))
    >>> model = ContactModel(["table", "brick"], geometries, [pair])
    >>> X_FB = np.tile(np.eye(4), (2, 1, 1))
    >>> X_FB[1, 2, 3] = 0.1  # on the table
    >>> inertia = np.diag([0.01, 0.01, 0.01, 1.0, 1.0, 1.0])[None]  # of the brick, 1 kg
    >>> solver = StepSolver(
    ...     model, num_positions=7, num_velocities=6, v_start=[0], nv=[6], q_start=[0],
    ...     inertia_R=inertia, tree=[-1, 0], X_RB=np.tile(np.eye(4), (2, 1, 1)),
    ... )
    >>> q, v = np.array([1.0, 0, 0, 0, 0, 0, 0.1]), np.zeros(6)
    >>> gravity = np.array([0, 0, -9.81])
    >>> begin = model.initial_state()
    >>> solved = solver.solve_under_gravity(begin, 0.0, 0.001, q, v, gravity, X_FB)
    >>> free = solver.free_motion(q, v, 0.001, gravity)
    >>> (solved.v[5] / free[5]).round(3)  # 1/(1 + h² k A/m): the table holds it
    np.float64(0.091)
    """

    def __init__(
        self,
        model: ContactModel,
        *,
        num_positions: int,
        num_velocities: int,
        v_start: Sequence[int],
        nv: Sequence[int],
        q_start: Sequence[int],
        inertia_R: Floats,
        tree: Sequence[int],
        X_RB: Floats,
    ) -> None:
        self._native = _core.StepSolver(
            model._native,
            num_positions,
            num_velocities,
            list(v_start),
            list(nv),
            list(q_start),
            np.asarray(inertia_R, float).reshape(-1, 6, 6),
            list(tree),
            np.asarray(X_RB, float),
        )

    def free_motion(self, q0: Floats, v0: Floats, step: float, gravity: Floats) -> Floats:
        """Return velocities (nv,) at the end of a step under gravity (3,) [m/s²] alone.

        Of floating trees, as semi-implicit Euler has them (the inertia and gyroscopic forces of the
        start); those of other trees stay as they are.
        """
        return self._native.free_motion(q0, v0, step, gravity)

    def solve(
        self,
        state: ContactState,
        time: float,
        step: float,
        q0: Floats,
        v0: Floats,
        v_free: Floats,
        X_FB: Floats,
        inertia: Floats,
        jacobian: Floats,
        v_reference: Floats,
    ) -> StepSolution:
        """Solve one step; one native call without the interpreter's lock.

        Parameters
        ----------
        state
            Of the contact at the start of the step.
        time, step
            Start and length of the step [s].
        q0, v0
            (nq,), (nv,) at the start.
        v_free
            (nv,) at the end, were there no contact.
        X_FB
            (nb, 4, 4) poses: of bodies that do not move; of those in trees that do not float, where
            velocities `v_reference` (nv,) take them over the step; these are also where solving
            starts.
        inertia
            (nv, nv) A, on the blocks of trees that do not float; empty without such trees.
        jacobian
            (nb, 6, nv) of the velocities of their bodies in F there; empty likewise.

        Raises
        ------
        ValueError
            For arrays of the wrong shape, or with numbers that are not finite.
        """
        return self._native.solve(
            state, time, step, q0, v0, v_free, X_FB, inertia, jacobian, v_reference
        )

    def solve_under_gravity(
        self,
        state: ContactState,
        time: float,
        step: float,
        q0: Floats,
        v0: Floats,
        gravity: Floats,
        X_FB: Floats,
    ) -> StepSolution:
        """Solve one step of floating bodies on which nothing but contact and gravity acts.

        The same as `solve` with `free_motion`, in one call; gravity (3,) [m/s²].

        Raises
        ------
        ValueError
            Also for a system with trees that do not float.
        """
        return self._native.solve_under_gravity(state, time, step, q0, v0, gravity, X_FB)
