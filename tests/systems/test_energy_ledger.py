"""The energy ledger: what is stored and lost adds up, to the accuracy of the integration."""

import contact_scenes as scenes
import numpy as np
import pytest
from numpy.testing import assert_array_equal
from scipy.spatial.transform import Rotation

from contact_toolkit import Friction, NonlinearDamper

pytestmark = pytest.mark.engine

STANDOFF = 5e-3


def thrown(accuracy, *, mu=0.3, alpha=0.4, across=3.0, speed=1.1):
    model = scenes.facet_model(
        scenes.stool(),
        scenes.plane(),
        NonlinearDamper(1e5, alpha),
        standoff=STANDOFF,
        friction=Friction(mu) if mu else None,
    )
    return scenes.Slider(
        model, 0.7, (0.2, 0.1, STANDOFF), (across, 0, -speed), np.zeros(3), accuracy
    )


@pytest.mark.parametrize(
    ("mu", "across"),
    [(0.0, 0.0), (0.3, 3.0), (0.3, 0.5)],  # no friction, slip, and stick with slip
)
def test_an_impact_closes_better_the_tighter_the_integration(mu, across):
    errors = []
    for accuracy in (1e-5, 1e-6, 1e-7):
        body = thrown(accuracy, mu=mu, across=across)
        start = body.energy()
        body.advance_to(0.02)
        errors.append(abs(body.energy() / start - 1))
    assert errors[0] < 2e-4
    assert errors[2] < 2e-6


def test_damping_loses_what_restitution_says():
    speed, alpha = 1.1, 0.4
    body = thrown(1e-7, mu=0.0, alpha=alpha, across=0.0, speed=speed)
    body.advance_to(0.02)
    e = NonlinearDamper(1.0, alpha).restitution(speed)
    assert body.contact_state.losses[0] == pytest.approx(0.35 * speed**2 * (1 - e**2), rel=1e-5)
    assert body.contact_state.losses[1] == 0


def test_a_body_without_damping_or_friction_loses_nothing():
    body = thrown(1e-6, mu=0.0, alpha=0.0)
    body.advance_to(0.02)
    assert_array_equal(body.contact_state.losses, 0)


def test_powers_are_the_rates_of_the_losses():
    # Sliding at a steady depth: μ N v. Sinking: what the damping adds to the force, times the rate.
    mu, alpha, k, depth = 0.3, 0.4, 1e5, 1e-3
    model = thrown(1e-6, mu=mu, alpha=alpha).model
    state = model.initial_state()
    for time in (0.0, 0.01):
        X_FB, V_FB = (
            scenes.poses((0.2 + 3 * time, 0.1, STANDOFF - depth)),
            scenes.velocities((3, 0, 0)),
        )
        forces = model.evaluate(X_FB, V_FB, state)
        state = model.advance(state, time, forces)
    assert forces.powers == pytest.approx([0.0, mu * 3 * k * depth * 3.0])
    sinking = model.evaluate(X_FB, scenes.velocities((0, 0, -0.2)), state)
    assert sinking.powers[0] == pytest.approx(3 * k * depth * 1.5 * alpha * 0.2**2)


def test_a_turning_body_is_followed_through_long_steps():
    # The loss of a prescribed motion: halving the step gains much more than a factor of 4.
    def motion(t):
        turn = Rotation.from_rotvec([0.1 * np.sin(9 * t), 0.08 * np.cos(7 * t), 3 * t])
        p = [0.2 + 0.01 * np.sin(5 * t), 0.1, 3e-3 + 5e-4 * np.sin(11 * t)]
        return p, turn

    def velocity(t, h=1e-6):
        (p0, R0), (p1, R1) = motion(t - h), motion(t + h)
        return [*((R1 * R0.inv()).as_rotvec() / (2 * h)), *((np.array(p1) - p0) / (2 * h))]

    def lost(steps):
        model = thrown(1e-6, mu=0.0).model
        state = model.initial_state()
        for t in np.linspace(0, 0.5, steps + 1):
            p, turn = motion(t)
            V_FB = np.array([[0.0] * 6, velocity(t)])
            state = model.advance(
                state, t, model.evaluate(scenes.poses(p, turn.as_matrix()), V_FB, state)
            )
        return state.losses[0]

    truth = lost(3000)
    coarse, fine = abs(lost(25) / truth - 1), abs(lost(50) / truth - 1)
    assert fine < 1e-6
    assert coarse / fine > 6
