"""The nonlinear damper's closed forms, against high precision and against its own motion."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from contact_toolkit import NonlinearDamper

# D = 3/2 α v, and the restitution it gives.
PUBLISHED = {0.1: 0.937476, 0.5: 0.748435, 1.0: 0.593624, 2.0: 0.410720, 5.0: 0.196980}


def exact_loss(D: float) -> mpmath.mpf:
    """1 − e to 50 digits."""
    with mpmath.workdps(50):
        D = mpmath.mpf(D)
        return 1 - (1 + mpmath.lambertw(-(1 + D) * mpmath.exp(-(1 + D))).real) / D


def impact(damper: NonlinearDamper, mass: float, speed: float) -> tuple[float, float, float]:
    """Restitution, peak deformation and duration of an impact, by integrating the motion."""

    def leaves(_time, state):
        return state[0]

    leaves.terminal, leaves.direction = True, -1
    scale = damper.peak_deformation(mass, speed)
    motion = solve_ivp(
        lambda _, y: [y[1], -float(damper.force(y[0], y[1])) / mass],
        (0, 1e3 * scale / speed),
        [0, speed],
        method="DOP853",
        events=leaves,
        rtol=1e-11,
        atol=1e-13 * scale,
        max_step=scale / speed / 20,
        dense_output=True,
    )
    end = motion.t_events[0][0]
    times = np.linspace(0, end, 20001)
    return -motion.sol(end)[1] / speed, motion.sol(times)[0].max(), end


@pytest.mark.parametrize(("D", "e"), PUBLISHED.items())
def test_restitution_is_the_published_relation(D, e):
    assert NonlinearDamper(k=1.0, alpha=2 / 3 * D).restitution(1.0) == pytest.approx(e, abs=5e-7)


@pytest.mark.parametrize("D", np.geomspace(1e-14, 2e3, 35))
def test_restitution_is_accurate_however_small_the_damping(D):
    loss = 1 - NonlinearDamper(k=1.0, alpha=2 / 3 * D).restitution(1.0)
    assert loss == pytest.approx(float(exact_loss(D)), rel=1e-12, abs=2e-16)


def test_restitution_starts_as_one_minus_alpha_v():
    damper = NonlinearDamper(k=1.0, alpha=0.3)
    assert (1 - damper.restitution(1e-3)) / 1e-3 == pytest.approx(0.3, rel=0.01)
    assert damper.restitution(0.0) == 1.0


@given(e=st.floats(1e-3, 1 - 1e-9), v=st.floats(1e-6, 1e3))
def test_alpha_for_inverts_restitution(e, v):
    alpha = NonlinearDamper.alpha_for(e, v)
    assert NonlinearDamper(k=1.0, alpha=alpha).restitution(v) == pytest.approx(e, rel=1e-9)


def test_alpha_for_a_perfect_bounce_is_zero():
    assert NonlinearDamper.alpha_for(1.0, 2.0) == 0.0


@pytest.mark.parametrize("n", [1.0, 1.5, 2.5])
@pytest.mark.parametrize("alpha", [0.0, 1e-6, 0.2, 3.0])
def test_motion_meets_the_closed_forms(n, alpha):
    damper, mass, speed = NonlinearDamper(k=4e4, alpha=alpha, n=n), 0.3, 1.7
    e, peak, time = impact(damper, mass, speed)
    assert e == pytest.approx(damper.restitution(speed), rel=1e-7)
    assert peak == pytest.approx(damper.peak_deformation(mass, speed), rel=1e-7)
    if alpha == 0:
        assert time == pytest.approx(damper.elastic_impact_time(mass, speed), rel=1e-7)


def test_linear_and_hertz_impacts_are_the_textbook_ones():
    mass, speed, k = 0.2, 1.3, 5e5
    linear, hertz = NonlinearDamper(k), NonlinearDamper(k, n=1.5)
    assert linear.elastic_impact_time(mass, speed) == pytest.approx(math.pi * math.sqrt(mass / k))
    force = linear.force(linear.peak_deformation(mass, speed), 0.0)
    assert float(force) == pytest.approx(speed * math.sqrt(k * mass))
    peak = (5 * mass * speed**2 / (4 * k)) ** 0.4
    assert hertz.peak_deformation(mass, speed) == pytest.approx(peak)
    assert hertz.elastic_impact_time(mass, speed) == pytest.approx(2.943 * peak / speed, rel=1e-4)


@pytest.mark.parametrize("n", [1.0, 1.5])
def test_settling_has_the_stated_damping_ratio(n):
    damper, mass, gravity = NonlinearDamper(k=1e4, alpha=2.0, n=n), 0.5, 9.81
    load = mass * gravity
    rest = damper.equilibrium(load)
    zeta = damper.damping_ratio(mass, load)
    omega = math.sqrt(n * load / rest / mass)
    if n == 1:
        assert zeta == pytest.approx(1.5 * 2.0 * gravity / 2 * math.sqrt(mass / 1e4))
    period = 2 * math.pi / (omega * math.sqrt(1 - zeta**2))
    motion = solve_ivp(
        lambda _, y: [y[1], gravity - float(damper.force(y[0], y[1])) / mass],
        (0, 2 * period),
        [rest * (1 + 1e-4), 0.0],
        t_eval=[0, period],
        rtol=1e-10,
        atol=1e-16,
    )
    decay = (motion.y[0, 1] - rest) / (motion.y[0, 0] - rest)
    assert decay == pytest.approx(math.exp(-zeta * omega * period), rel=0.01)


def test_settling_damps_the_smallest_motions_as_stated():
    """Small motions about equilibrium: 1 + s/w times the damping ratio."""
    mass, gravity, k, s, w = 0.5, 9.81, 1e6, 1e-3, 1e-4
    damper = NonlinearDamper(k=k, alpha=2.0, settling=s, smallest=w)
    load = mass * gravity
    zeta, omega = (1 + s / w) * damper.damping_ratio(mass, load), math.sqrt(k / mass)
    period = 2 * math.pi / (omega * math.sqrt(1 - zeta**2))
    motion = solve_ivp(
        lambda _, y: [y[1], gravity - float(damper.force(y[0], y[1])) / mass],
        (0, period),
        [load / k + 1e-4 * w / omega, 0.0],
        t_eval=[0, period],
        rtol=1e-10,
        atol=1e-18,
    )
    decay = (motion.y[0, 1] - load / k) / (motion.y[0, 0] - load / k)
    assert decay == pytest.approx(math.exp(-zeta * omega * period), rel=0.01)


@pytest.mark.parametrize("n", [1.0, 1.5])
@pytest.mark.parametrize("speed", [0.05, 1.0])
def test_settling_takes_from_an_impact_what_the_work_of_its_halves_says(n, speed):
    """With w → 0: m v dv = ∓ k δⁿ (1 ± a (v + s²/(s + v))) dδ, of equal ∫ k δⁿ dδ in and out."""
    alpha, s = 0.4, 0.05
    a = 1.5 * alpha

    def work(v: float, way: int) -> float:
        return quad(lambda u: u / (1 + way * a * (u + s**2 / (s + u))), 0, v, epsabs=1e-14)[0]

    e = brentq(lambda e: work(e * speed, -1) - work(speed, 1), 0.1, 1.0, xtol=1e-14)
    damper = NonlinearDamper(k=1e5, alpha=alpha, n=n, settling=s, smallest=1e-6)
    assert impact(damper, 0.3, speed)[0] == pytest.approx(e, rel=5e-5)
    loss = NonlinearDamper(k=1e5, alpha=alpha, n=n).restitution(speed) - e
    assert 0 < loss < a * s * (1.0 if speed <= s else 0.2)  # what is fast keeps the closed form


def test_force_is_the_gradient_of_the_energy():
    damper, step = NonlinearDamper(k=3e3, n=1.5), 1e-7
    deformation = np.linspace(1e-3, 5e-3, 7)
    slope = (damper.energy(deformation + step) - damper.energy(deformation - step)) / (2 * step)
    assert_allclose(damper.force(deformation, 0.0), slope, rtol=1e-8)


def test_only_adhesion_lets_the_damping_pull():
    deformation, rate = [1e-3, 1e-3, 0.0, -1e-3], [-2.0, 0.0, 5.0, 5.0]
    clamped = NonlinearDamper(k=1e3, alpha=1.0).force(deformation, rate)
    literal = NonlinearDamper(k=1e3, alpha=1.0, adhesion=True).force(deformation, rate)
    assert_allclose(clamped, [0.0, 1.0, 0.0, 0.0])
    assert_allclose(literal, [-2.0, 1.0, 0.0, 0.0])


@pytest.mark.parametrize(
    ("parameters", "complaint"),
    [
        ({"k": 0.0}, "k must be positive"),
        ({"k": -1.0}, "k must be positive"),
        ({"k": math.nan}, "k must be positive and finite, not nan"),
        ({"k": math.inf}, "k must be positive and finite"),
        ({"k": 1.0, "alpha": -0.1}, "alpha must be finite and not negative, not -0.1"),
        ({"k": 1.0, "alpha": math.nan}, "alpha must be finite"),
        ({"k": 1.0, "n": 0.5}, "n must be at least 1"),
        ({"k": 1.0, "n": math.inf}, "n must be at least 1 and finite"),
        ({"k": 1.0, "settling": -1.0}, "settling must be finite and not negative, not -1.0"),
        ({"k": 1.0, "smallest": 0.0}, "smallest must be positive and finite, not 0.0"),
    ],
)
def test_impossible_parameters_are_named(parameters, complaint):
    with pytest.raises(ValueError, match=complaint):
        NonlinearDamper(**parameters)


def test_impossible_questions_are_refused():
    damper = NonlinearDamper(k=1.0)
    for restitution in (0.0, -0.1, 1.1, math.nan):
        with pytest.raises(ValueError, match="restitution must be in"):
            NonlinearDamper.alpha_for(restitution, 1.0)
    with pytest.raises(ValueError, match="velocity must be positive"):
        NonlinearDamper.alpha_for(0.5, 0.0)
    with pytest.raises(ValueError, match="velocity must be finite and not negative"):
        damper.restitution(-1.0)
    with pytest.raises(ValueError, match="mass must be positive"):
        damper.peak_deformation(0.0, 1.0)
    with pytest.raises(ValueError, match="load must be finite"):
        damper.equilibrium(math.inf)
