"""FloatingBodies: between a multibody state and the poses and wrenches of a contact model."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contact_toolkit import _core

Floats = NDArray[np.float64]


class FloatingBodies:
    """Bodies whose motion stands in a multibody state [q; v] as it is, in the common frame F.

    In q: a quaternion [w x y z], of any length but zero, then a position. In v: angular, then
    translational velocity of the body's origin.

    Parameters
    ----------
    body
        Rows of the floating bodies in the contact model.
    q_start, v_start
        Where each one's numbers start in q and in v.
    X_FB
        (nb, 4, 4) poses of all bodies of the model, for those that are not floating.
    num_positions, num_velocities
        Sizes of q and of v.

    Raises
    ------
    ValueError
        For a body or a start out of range.

    Examples
    --------
    >>> import numpy as np
    >>> from contact_toolkit import FloatingBodies
    >>> poses = np.tile(np.eye(4), (2, 1, 1))  # the world's, and one to be read
    >>> bodies = FloatingBodies([1], [0], [0], poses, num_positions=7, num_velocities=6)
    >>> state = np.array([1.0, 0, 0, 0, 0.1, 0.2, 0.3, 0, 0, 0, 0, 0, -2.0])
    >>> X_FB, V_FB = bodies.gather(state)
    >>> X_FB[1, :3, 3], V_FB[1, 5]
    (array([0.1, 0.2, 0.3]), np.float64(-2.0))
    """

    def __init__(
        self,
        body: Sequence[int],
        q_start: Sequence[int],
        v_start: Sequence[int],
        X_FB: ArrayLike,
        *,
        num_positions: int,
        num_velocities: int,
    ) -> None:
        if not len(body) == len(q_start) == len(v_start):
            raise ValueError("body, q_start and v_start must be of one length")
        poses = np.ascontiguousarray(X_FB, dtype=np.float64)
        self._native = _core.FloatingBodies(
            list(body), list(q_start), list(v_start), poses, num_positions, num_velocities
        )

    def gather(self, state: Floats) -> tuple[Floats, Floats]:
        """Return X_FB (nb, 4, 4) and V_FB (nb, 6) = [w_FB; v_FBo] [rad/s, m/s] of all bodies.

        Velocities of bodies that are not floating are zero. Both arrays are the caller's to change.
        """
        return self._native.gather(state)

    def scatter(self, body_wrenches: Floats) -> Floats:
        """Return the generalized forces of wrenches (nb, 6), torque about Bo then force, in F.

        Wrenches on bodies that are not floating are left out.
        """
        return self._native.scatter(body_wrenches)
