"""Contact where numbers are extreme: every run stays finite and makes no energy from nothing.

Two free bodies, no gravity, so kinetic plus stored energy may only fall, and total momentum stays.
What would be wrong if one failed: a force that is no gradient, a division by a vanished distance, a
rounding error that grows with the distance from the origin.
"""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from contact_toolkit import CollisionMesh, Friction, NonlinearDamper
from contact_toolkit.testbed import MovingBody, Testbed, Trajectory
from scenarios import parts

pytestmark = pytest.mark.engine

SIDE = 0.1  # [m]
FAR = 1e4  # [m]
LOOSE = 1e-5  # share of the energy by which the integration may be off


@dataclass(frozen=True)
class Meeting:
    """A block at rest, and what comes to it, or starts in it.

    Attributes
    ----------
    p
        Where it starts, from the block [m].
    v
        Its velocity [m/s].
    duration
        [s].
    max_step
        [s].
    k
        Foundation stiffness [Pa/m].
    density
        Of the comer [kg/m³]; the block has 1000.
    part
        The comer's shape.
    turn
        How the comer is turned, about an oblique axis [rad].
    origin
        Where the block is, on every axis [m].
    """

    p: tuple[float, float, float]
    v: tuple[float, float, float] = (0.0, 0.0, 0.0)
    duration: float = 0.02
    max_step: float = 5e-4
    k: float = 1e9
    density: float = 1e3
    part: str = "box"
    turn: float = 0.0
    origin: float = 0.0


TOUCHING = (0.01, 0.02, SIDE + 1e-3)
FALLING = (0.0, 0.0, -1.0)

MEETINGS = {
    "stiffness 1e12": Meeting(TOUCHING, FALLING, duration=3e-3, max_step=2e-5, k=1e12),
    "stiffness 1": Meeting(TOUCHING, FALLING, duration=0.3, max_step=5e-3, k=1.0),
    "mass ratio 1e6": Meeting(TOUCHING, FALLING, density=1e-3, duration=3e-3, max_step=2e-5),
    "mass ratio 1e-6": Meeting(TOUCHING, FALLING, density=1e9),
    "overlapped": Meeting((0.01, 0.02, SIDE - 2e-3)),
    "overlapped at a corner": Meeting((0.09, 0.095, 0.093)),
    "coincident": Meeting((0.0, 0.0, 0.0)),
    "nearly coincident": Meeting((1e-9, 0.0, 0.0), turn=1e-9),
    "one inside the other": Meeting((0.012, 0.005, 0.02), part="ball", k=1e7, duration=5e-3),
    "concentric": Meeting((0.0, 0.0, 0.0), part="ball", k=1e7, duration=5e-3),
    "far from the origin": Meeting(TOUCHING, FALLING, origin=FAR),
    "1 km/s": Meeting(
        (0.01, 0.02, SIDE + 0.01), (0, 0, -1e3), duration=1e-4, max_step=1e-6, k=1e12
    ),
}

PARTS = {
    "box": parts.box(SIDE, SIDE, SIDE),
    "ball": parts.icosphere(0.02, frequency=4),
}


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
        resolution=0.1,
    )
    trajectory = testbed.run(
        meeting.duration, method="RK45", rtol=rtol, atol=rtol / 10, max_step=meeting.max_step
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
    assert met.springs.max() > 0
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
