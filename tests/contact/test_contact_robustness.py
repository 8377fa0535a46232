"""Contact where numbers are extreme: every run stays finite and makes no energy from nothing.

Two free bodies, no gravity, so kinetic plus stored energy may only fall, and total momentum stays.
What would be wrong if one failed: a force that is no gradient, a division by a vanished distance, a
rounding error that grows with the distance from the origin.
"""

from dataclasses import replace

import numpy as np
import pytest
from meetings import LOOSE, MEETINGS, PARTS, Meeting
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from contact_toolkit import AreaWeb, CollisionMesh, Friction, NonlinearDamper
from contact_toolkit.testbed import MovingBody, Testbed, Trajectory

pytestmark = pytest.mark.engine


def run(
    meeting: Meeting, alpha: float, friction: float, rtol: float = 1e-8
) -> tuple[Testbed, Trajectory]:
    def pose(p, turn=0.0):
        X = np.eye(4)
        X[:3, :3] = Rotation.from_rotvec(turn * np.array([1.0, 0.6, 0.3])).as_matrix()
        X[:3, 3] = np.asarray(p) + meeting.origin
        return X

    block = MovingBody.from_density("block", CollisionMesh(*PARTS["box"]), 1e3, pose(np.zeros(3)))
    comer = MovingBody.from_density(
        "comer",
        CollisionMesh(*PARTS[meeting.part]),
        meeting.density,
        pose(meeting.p, meeting.turn),
        np.array([0, 0, 0, *meeting.v]),
    )
    testbed = Testbed(
        [block, comer],
        None,
        NonlinearDamper(meeting.k, alpha),
        friction=Friction(friction),
        gravity=(0, 0, 0),
        web=AreaWeb(resolution=0.1),
    )
    # Lengths must be resolved that are as small as the offset the two start with.
    atol = min(rtol / 10, 1e-4 * np.linalg.norm(meeting.p) or rtol)
    trajectory = testbed.run(
        meeting.duration, method="RK45", rtol=rtol, atol=atol, max_step=meeting.max_step
    )
    return testbed, trajectory


def momenta_and_energies(testbed: Testbed, run: Trajectory) -> tuple[np.ndarray, np.ndarray]:
    momentum, kinetic = np.zeros((len(run.time), 3)), np.zeros(len(run.time))
    for i, body in enumerate(testbed.bodies):
        R, w, v = run.X_FB[:, i, :3, :3], run.V_FB[:, i, :3], run.V_FB[:, i, 3:]
        v_cm = v + np.cross(w, R @ np.asarray(body.p_BoBcm))
        w_B = np.einsum("nij,ni->nj", R, w)
        momentum += body.mass * v_cm
        kinetic += body.mass * (v_cm**2).sum(axis=1) / 2
        kinetic += np.einsum("ni,ij,nj->n", w_B, body.I_BBcm, w_B) / 2
    stored = [
        testbed.model.evaluate(X, V).energies[0] for X, V in zip(run.X_FB, run.V_FB, strict=True)
    ]
    return momentum, kinetic + np.array(stored)


@pytest.mark.parametrize(("alpha", "friction"), [(0.0, 0.0), (0.5, 0.5)])
@pytest.mark.parametrize("name", MEETINGS)
def test_nothing_from_nothing(name, alpha, friction):
    """Numbers that are not finite, energy that grows, momentum that comes from nowhere."""
    testbed, met = run(MEETINGS[name], alpha, friction)
    momentum, energy = momenta_and_energies(testbed, met)
    # Every node of coincident bodies is on the other's surface: not deep at all, and not pushed.
    assert (met.springs.max() > 0) == (name != "coincident")
    assert np.isfinite(met.X_FB).all()
    assert np.isfinite(met.V_FB).all()
    assert energy.max() <= energy[0] * (1 + LOOSE)
    if alpha == 0:
        assert energy.min() >= energy[0] * (1 - LOOSE)
    largest = np.sqrt(2 * energy[0] * sum(body.mass for body in testbed.bodies))
    assert np.abs(momentum - momentum[0]).max() <= 1e-9 * largest


def test_far_from_the_origin_is_as_near_it():
    """Rounding of positions 10 km away that shows in an impact."""
    far = MEETINGS["far from the origin"]
    # At 1e-8 the integrator's own choice of steps scatters the ends by 2e-6 m/s.
    runs = [run(meeting, 0.5, 0.0, rtol=1e-10) for meeting in (far, replace(far, origin=0.0))]
    ends = [trajectory.V_FB[-1] for _, trajectory in runs]
    assert_allclose(ends[0], ends[1], atol=1e-6)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_motion_that_is_not_finite_is_refused(bad):
    """A simulation that has blown up and goes on as if nothing touched."""
    testbed, _ = run(replace(MEETINGS["coincident"], duration=1e-5), 0.0, 0.0)
    X_FB, V_FB = np.tile(np.eye(4), (2, 1, 1)), np.zeros((2, 6))
    V_FB[1, 2] = bad
    with pytest.raises(ValueError, match="V_FB of body 1 is not finite"):
        testbed.model.evaluate(X_FB, V_FB)
    X_FB[1, 0, 3] = bad
    with pytest.raises(ValueError, match="X_FB of body 1 is not finite"):
        testbed.model.evaluate(X_FB, np.zeros((2, 6)))
