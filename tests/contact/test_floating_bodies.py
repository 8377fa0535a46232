"""The state read and the forces written are exactly those of the multibody state."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from contact_toolkit import FloatingBodies

pytestmark = pytest.mark.engine


def two_of_four() -> tuple[FloatingBodies, np.ndarray]:
    """Bodies 3 and 1 float, in that order in the state, after one joint angle."""
    X_FB = np.tile(np.eye(4), (4, 1, 1))
    X_FB[2, :3, 3] = [7, 8, 9]
    state = np.random.default_rng(1).normal(size=(1 + 14) + (1 + 12))
    return FloatingBodies([3, 1], [1, 8], [1, 7], X_FB, num_positions=15, num_velocities=13), state


def test_gather_reads_poses_and_velocities():
    floating, state = two_of_four()
    X_FB, V_FB = floating.gather(state)
    for row, q, v in [(3, state[1:8], state[16:22]), (1, state[8:15], state[22:28])]:
        rotation = Rotation.from_quat(np.roll(q[:4], -1)).as_matrix()
        np.testing.assert_allclose(X_FB[row, :3, :3], rotation, atol=1e-15)
        np.testing.assert_array_equal(X_FB[row, :3, 3], q[4:])
        np.testing.assert_array_equal(X_FB[row, 3], [0, 0, 0, 1])
        np.testing.assert_array_equal(V_FB[row], v)
    np.testing.assert_array_equal(X_FB[2, :3, 3], [7, 8, 9])
    assert V_FB.shape == (4, 6)
    np.testing.assert_array_equal(V_FB[[0, 2]], np.zeros((2, 6)))


def test_gather_hands_out_fresh_arrays():
    """Else filling in a jointed body would move it for ever after."""
    floating, state = two_of_four()
    X_FB, V_FB = floating.gather(state)
    X_FB[:], V_FB[:] = 1, 1
    again_X, again_V = floating.gather(state)
    np.testing.assert_array_equal(again_X[0], np.eye(4))
    np.testing.assert_array_equal(again_V[0], np.zeros(6))


def test_scatter_is_the_transpose_of_gather():
    floating, _ = two_of_four()
    wrenches = np.arange(24.0).reshape(4, 6)
    generalized = floating.scatter(wrenches)
    np.testing.assert_array_equal(generalized, [0, *wrenches[3], *wrenches[1]])


@pytest.mark.parametrize(
    ("body", "q_start", "v_start"), [(4, 0, 0), (-1, 0, 0), (0, 9, 0), (0, -1, 0), (0, 0, 8)]
)
def test_out_of_range_is_refused(body, q_start, v_start):
    X_FB = np.tile(np.eye(4), (4, 1, 1))
    with pytest.raises(ValueError, match="floating body 0 lies outside"):
        FloatingBodies([body], [q_start], [v_start], X_FB, num_positions=15, num_velocities=13)


def test_wrong_sizes_are_refused():
    floating, state = two_of_four()
    with pytest.raises(ValueError, match="28 numbers, not 27"):
        floating.gather(state[:-1])
    with pytest.raises(ValueError, match="4 rows, not 3"):
        floating.scatter(np.zeros((3, 6)))
    with pytest.raises(ValueError, match="one length"):
        FloatingBodies([0], [], [], np.eye(4)[None], num_positions=7, num_velocities=6)
