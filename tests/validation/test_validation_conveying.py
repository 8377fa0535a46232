"""Row 21 of the validation, and the truth of `bowl_feeder`: parts conveyed by vibration.

In the frame of a track that swings by A sin ω t at an angle ψ above its slope θ, gravity is joined
by A ω² sin ω t: a part is pushed along the track and pressed on it by turns.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from pydrake.math import RotationMatrix
from validation_scenes import GRAVITY, Scene, area_web, judge

from scenarios.format.loading import load

FREQUENCY = 25.0  # [Hz]
OMEGA = 2 * math.pi * FREQUENCY
SLOPE, ANGLE, MU = math.radians(2.0), math.radians(30.0), 0.3
CYCLES = 5
SINK = 1e-6  # of the block at rest [m]
MASS, SIZE = 0.5, (0.1, 0.08, 0.02)


def swung(acceleration: float):
    """Swing a block on a slope, A ω² [m/s²]; its ways along and off the track, by time [m]."""
    scene = Scene(time_step=2e-4)
    R_WF = scene.floor(SLOPE)  # its x axis leads downhill
    body = scene.box("block", MASS, SIZE)

    def push(time: float):
        along = np.array([-math.cos(ANGLE), 0, math.sin(ANGLE)])
        force = np.zeros(6)
        # Gently at first: the block, which stands on springs, would hop from a blow.
        grown = min(1.0, time * FREQUENCY)
        force[3:] = MASS * acceleration * grown * math.sin(OMEGA * time) * (R_WF.matrix() @ along)
        return force

    k = MASS * GRAVITY * math.cos(SLOPE) / (SIZE[0] * SIZE[1] * SINK)
    run = scene.build(area_web(k, alpha=1.0, mu=MU, resolution=0.3), push)
    start = R_WF.matrix() @ np.array([0, 0, SIZE[2] / 2 - SINK])
    run.place(body, RotationMatrix(R_WF), start)
    log = run.advance_to(CYCLES / FREQUENCY)
    way = (log.q[:, 4:7] - start) @ R_WF.matrix()
    return -way[:, 0], way[:, 2]


@pytest.mark.parametrize(("share", "expected"), [(0.97, "stays"), (1.03, "climbs")])
def test_it_slides_forward_above_the_threshold(record_property, share, expected):
    """Row 21: forward once A ω² / g > (μ cos θ + sin θ) / (cos ψ + μ sin ψ)."""
    threshold = (MU * math.cos(SLOPE) + math.sin(SLOPE)) / (math.cos(ANGLE) + MU * math.sin(ANGLE))
    climbed, _ = swung(share * threshold * GRAVITY)
    cycle = len(climbed) // CYCLES
    told = "climbs" if climbed[-1] - climbed[2 * cycle] > 1e-6 else "stays"
    judge(record_property, (21, f"vibrated block, {share} of what slides it"), expected, told)


@pytest.mark.parametrize(("share", "expected"), [(0.97, "stays down"), (1.03, "hops")])
def test_it_hops_above_the_threshold(record_property, share, expected):
    """Row 21: off the track once A ω² sin ψ > g cos θ."""
    threshold = math.cos(SLOPE) / math.sin(ANGLE)
    _, risen = swung(share * threshold * GRAVITY)
    told = "hops" if risen.max() > SINK else "stays down"
    judge(record_property, (21, f"vibrated block, {share} of what lifts it"), expected, told)


def test_the_bowl_feeders_truth_is_coulombs():
    """The scenario would be judged by a number that no theory gives."""
    acceptance = load("bowl_feeder")[1].acceptance
    limits = acceptance.limits
    radius = 0.11485
    slope = math.atan(limits["climb [mm a turn]"].near / 1e3 / (2 * math.pi * radius))
    up = limits["lift of the bowl [mm]"].near / 1e3
    along = limits["twist of the bowl [mrad]"].near / 1e3 * radius
    omega = 2 * math.pi * load("bowl_feeder")[1].drives["lift"].frequency
    push = omega**2 * (along * math.cos(slope) + up * math.sin(slope))
    lift = omega**2 * (up * math.cos(slope) - along * math.sin(slope))
    speed = sliding_speed(push, lift, slope, load("bowl_feeder")[1].contact.friction.static, omega)
    assert limits["velocity [mm/s]"].near == pytest.approx(1e3 * speed, rel=0.003)


def sliding_speed(push: float, lift: float, slope: float, mu: float, omega: float) -> float:
    """Return the mean of u over a period [m/s], once it has become periodic.

    u' = −g sin θ + push sin ω t − sign(u) μ N with N = g cos θ − lift sin ω t; or u = 0.
    """
    count = 4000
    dt = 2 * math.pi / omega / count
    phase = 2 * math.pi * (np.arange(count) + 0.5) / count
    drive = -GRAVITY * math.sin(slope) + push * np.sin(phase)
    rubbing = mu * (GRAVITY * math.cos(slope) - lift * np.sin(phase))
    assert rubbing.min() > 0  # no hops
    u, mean = 0.0, 0.0
    for _ in range(6):
        mean = 0.0
        for pushed, rubbed in zip(drive, rubbing, strict=True):
            free = u + pushed * dt
            u = math.copysign(max(0.0, abs(free) - rubbed * dt), free)
            mean += u / count
    return mean
