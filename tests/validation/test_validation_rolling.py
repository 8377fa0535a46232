"""Rows 10 to 12 and 22 of the validation: balls that skid, roll, bounce and bear."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest
from validation_scenes import (
    GRAVITY,
    ON_BOTH_PLANTS,
    Scene,
    area_web,
    check,
    check_first_order,
    on,
    slope,
)

from contact_toolkit import NonlinearDamper
from systems import ContactConfig, FrictionConfig, PairConfig

MASS = 1.0
RADIUS = 0.05
SINK = 0.004 * RADIUS  # of the resting ball
K = MASS * GRAVITY / (math.pi * RADIUS * SINK**2)  # F = π K R δ²
# Six nodes a radius of the resting patch; facets that lie 1/40 of the sink inside the ball.
FINE = {"resolution": 0.006, "tessellation_tolerance": 1e-4}


class Ball:
    """A ball at its resting depth on a floor that falls towards +x, or `above` its touch."""

    def __init__(
        self,
        contact: ContactConfig,
        incline=0.0,
        *,
        time_step=0.0,
        v=(0.0, 0.0),
        above=None,
        step=1e-3,
    ):
        scene = Scene(time_step=time_step, gravity=GRAVITY if above is None else 0.0)
        R_WF = scene.floor(incline)
        self.body = scene.ball("ball", MASS, RADIUS)
        self.run = scene.build(contact, step=step)
        self.along, self.up = R_WF.matrix()[:, 0], R_WF.matrix()[:, 2]
        if above is None:
            above = -SINK * math.sqrt(math.cos(incline))
        self.run.place(
            self.body, p=(RADIUS + above) * self.up, v=v[0] * self.along + v[1] * self.up
        )


@ON_BOTH_PLANTS
def test_skidding_to_rolling(record_property, time_step):
    """Row 10: v = 5/7 v₀ from t = 2 v₀/(7 μ g) and x = 12 v₀²/(49 μ g) on."""
    mu, v0 = 0.2, 1.0
    contact = area_web(K, alpha=0.1, mu=mu, **FINE)
    ball = Ball(contact, time_step=time_step, v=(v0, 0.0), step=5e-4)
    t = 2 * v0 / (7 * mu * GRAVITY)
    log = ball.run.advance_to(1.5 * t)
    v, x = log.v[:, 3], log.q[:, 4]
    rolling, skidding = log.time > 1.1 * t, log.time < 0.9 * t
    v_end = v[rolling].mean()
    v_skid = np.polyfit(log.time[skidding], v[skidding], 1)
    t_turn = (v_end - v_skid[1]) / v_skid[0]
    x_turn = np.interp(t_turn, log.time, x)
    figures = {
        "v/v₀": (5 / 7, v_end / v0),
        "t [s]": (t, t_turn),
        "x [m]": (12 * v0**2 / (49 * mu * GRAVITY), x_turn),
    }
    for name, (expected, got) in figures.items():
        row = (10, f"skid to roll: {name}" + on(time_step))
        check(record_property, row, expected, got, 0.01)


@ON_BOTH_PLANTS
@pytest.mark.parametrize("share", [0.5, 0.9])
def test_rolling_down(record_property, share, time_step):
    """Row 11: a = 5/7 g sin θ while tan θ < 7 μ/2."""
    mu = 0.2
    angle = math.atan(share * 3.5 * mu)
    ball = Ball(area_web(K, alpha=0.1, mu=mu, **FINE), angle, time_step=time_step)
    log = ball.run.advance_to(0.4).after(0.1)
    a = slope(log.time, log.v[:, 3:6] @ ball.along)
    expected = 5 / 7 * GRAVITY * math.sin(angle)
    row = (11, f"rolling down, tan θ = {share} · 7μ/2: a" + on(time_step))
    check(record_property, row, expected, a, 0.01)


def test_oblique_impact_in_full_slip(record_property):
    """Row 12: v_t' = v_t − μ (1 + e) v_n, ω' = 5 μ (1 + e) v_n / (2 R)."""
    mu, alpha, v_n, v_t = 0.1, 1.0, 0.1, 0.5
    contact = area_web(10 * K, alpha=alpha, mu=mu, **FINE)
    e = NonlinearDamper(1.0, alpha).restitution(v_n)
    loss = mu * (1 + e) * v_n
    expected = {
        "rebound [m/s]": e * v_n,
        "v_t lost [m/s]": loss,
        "ω [rad/s]": 2.5 * loss / RADIUS,
    }

    @functools.cache
    def after(time_step: float) -> dict[str, float]:
        ball = Ball(contact, time_step=time_step, v=(v_t, -v_n), above=1e-5, step=2e-5)
        log = ball.run.advance_to(0.012)
        w, v = log.v[-1, :3], log.v[-1, 3:]
        return dict(zip(expected, (v[2], v_t - v[0], w[1]), strict=True))

    for name, truth in expected.items():
        row = (12, f"oblique impact: {name}")
        check(record_property, row, truth, after(0.0)[name], 0.01)
        check_first_order(
            record_property, row, truth, 4e-5, lambda step, name=name: after(step)[name], 0.01
        )


@pytest.mark.slow
@ON_BOTH_PLANTS
def test_balls_on_a_pulled_box(record_property, time_step):
    """Row 22: 25 balls (1 kg) roll on a box (10 kg) that 150 N pull over the ground.

    The rolling test of SimBenchmark: the box skids on the ground, μ = 0.4; the balls do not skid on
    the box, μ = 0.8, so they accelerate 2/7 as much as it does.
    """
    pull, box_mass, radius, size = 150.0, 10.0, 0.05, (1.0, 1.0, 0.2)
    scene = Scene(time_step=time_step)
    scene.floor()
    box = scene.box("box", box_mass, size)
    balls = [scene.ball(f"ball{i}", MASS, radius) for i in range(25)]
    weight = (box_mass + 25 * MASS) * GRAVITY
    box_sink, sink = 1e-4, 0.01 * radius
    contact = area_web(
        MASS * GRAVITY / (math.pi * radius * sink**2),
        alpha=0.5,
        mu=0.8,
        resolution=0.02,
        tessellation_tolerance=4e-4,
        pairs=[["world", "box"], *(["box", ball.name()] for ball in balls)],
        overrides=[
            PairConfig(
                bodies=["world", "box"],
                k=weight / (size[0] * size[1] * box_sink),
                alpha=20.0,
                resolution=0.1,
                friction=FrictionConfig(static=0.4),
            )
        ],
    )

    def push(_time: float):
        force = np.zeros(6 * 26)
        force[3] = pull
        # At the height of the ground, so that it does not tip the box.
        force[1] = -size[2] / 2 * pull
        return force

    run = scene.build(contact, push, step=1e-3)
    run.place(box, p=(0, 0, size[2] / 2 - box_sink))
    for i, ball in enumerate(balls):
        x, y = (0.15 * (i % 5 - 2), 0.15 * (i // 5 - 2))
        run.place(ball, p=(x, y, size[2] - box_sink + radius - sink))
    log = run.advance_to(0.5).after(0.1)
    a_box = slope(log.time, log.v[:, 3])
    a_balls = np.mean([slope(log.time, log.v[:, 6 * i + 3]) for i in range(1, 26)])
    for name, expected, got in (("pulled box", 0.7385, a_box), ("balls on it", 0.2110, a_balls)):
        check(record_property, (22, f"{name}: a [m/s²]" + on(time_step)), expected, got, 0.02)
