"""Rows 7 to 9, 13 and 23 of the validation: a box that rests, slides, sticks, rubs and tips."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pydrake.geometry import Box
from pydrake.math import RigidTransform
from scipy.interpolate import CubicSpline
from validation_scenes import (
    GRAVITY,
    ON_BOTH_PLANTS,
    Scene,
    area_web,
    check,
    check_first_order,
    judge,
    on,
    slope,
)

from systems import ContactConfig

MASS = 1.0
WEIGHT = MASS * GRAVITY
SIZE = (0.1, 0.08, 0.04)
AREA = SIZE[0] * SIZE[1]
SINK = 1e-4  # of the box at rest on level ground [m]
K = WEIGHT / (AREA * SINK)
KT = 2 / 3 * K * AREA  # [N/m], with the usual ratio of stiffnesses


def foundation(*, k=K, alpha=20.0, mu=0.0, resolution=0.3, **settings) -> ContactConfig:
    """A web of few nodes: under a flat face its forces are exact. Swings soon die."""
    return area_web(k, alpha=alpha, mu=mu, resolution=resolution, **settings)


class BoxOnIncline:
    """A box at its resting depth, sliding down at `speed` [m/s]; contact None: Drake's own."""

    def __init__(
        self,
        contact: ContactConfig | None,
        slope_angle=0.0,
        *,
        time_step=0.0,
        speed=0.0,
        friction=0.0,
    ):
        scene = Scene(time_step=time_step)
        R_WF = scene.floor(slope_angle, friction)
        self.body = scene.box("box", MASS, SIZE, friction)
        self.run = scene.build(contact, step=1e-3)
        self.downhill, up = R_WF.matrix()[:, 0], R_WF.matrix()[:, 2]
        sink = SINK * K / contact.k if contact else SINK
        height = SIZE[2] / 2 - sink * math.cos(slope_angle)
        self.run.place(self.body, R_WF, height * up, v=speed * self.downhill)

    def base(self) -> float:
        """How far down the middle of the bottom face is [m]."""
        return float(self.run.point(self.body, [0, 0, -SIZE[2] / 2]) @ self.downhill)

    def slide(self, seconds: float) -> float:
        """Run for so long; return how far the bottom has moved down [m]."""
        start = self.base()
        self.run.advance_to(self.run.context.get_time() + seconds)
        return self.base() - start


class SettlingBox:
    """A box that swings on its face: 2 % above where it rests, hardly damped at first.

    The law is the published one: without the settling speed, which makes ζ 1/2 here.
    """

    ALPHA = 2.0
    ZETA = 1.5 * ALPHA * GRAVITY / 2 * math.sqrt(SINK / GRAVITY)  # for n = 1: (a g / 2) √(m/k)

    def __init__(self, n: float, time_step: float) -> None:
        scene = Scene(time_step=time_step)
        scene.floor()
        self.body = scene.box("box", MASS, SIZE)
        law = foundation(k=WEIGHT / AREA / SINK**n, alpha=self.ALPHA, n=n, settling=0.0)
        self.run = scene.build(law, step=2.5e-4)
        self.run.place(self.body, p=(0, 0, SIZE[2] / 2 - 0.98 * SINK))

    def zeta(self) -> float:
        """Swing; return the damping ratio, from the heights where it turns."""
        log = self.run.advance_to(0.1)
        height = CubicSpline(log.time, log.q[:, 6])
        swings = np.abs(np.diff(height(height.derivative().roots(extrapolate=False))))
        decrement = np.log(swings[1:7] / swings[2:8]).mean()
        return decrement / math.hypot(decrement, math.pi)


@ON_BOTH_PLANTS
@pytest.mark.parametrize("n", [1.0, 1.5])
def test_settling(record_property, n, time_step):
    """Row 7: a box rests at (m g / k)^(1/n) on its face."""
    box = SettlingBox(n, time_step)
    box.run.advance_to(0.5)
    sunk = SIZE[2] / 2 - box.run.point(box.body)[2]
    row = (7, f"settling, n = {n:g}: depth [m]" + on(time_step))
    check(record_property, row, SINK, sunk, 0.01)


def test_damping_of_settling(record_property):
    """Row 7: ζ = (a g / 2) √(m/k) for n = 1; discrete plants add to it what their steps take."""
    box, row = SettlingBox, (7, "settling, n = 1: ζ")
    check(record_property, row, box.ZETA, box(1.0, 0.0).zeta(), 0.01)
    check_first_order(
        record_property, row, box.ZETA, 1e-4, lambda step: box(1.0, step).zeta(), 0.01
    )


@ON_BOTH_PLANTS
def test_a_box_sticks_up_to_the_friction_angle(record_property, time_step):
    """Row 8: holds at tan θ = 0.99 μ, slides off at 1.01 μ."""
    mu = 0.5
    verdicts = []
    for share in (0.99, 1.01):
        box = BoxOnIncline(foundation(mu=mu), math.atan(share * mu), time_step=time_step)
        box.run.advance_to(1.0)
        way = box.slide(0.5)
        verdicts.append("sticks" if way < 1e-9 else "slides" if way > 1e-3 else "creeps")
    row = (8, "tan θ = 0.99 μ, 1.01 μ" + on(time_step))
    judge(record_property, row, "sticks, slides", ", ".join(verdicts))


@ON_BOTH_PLANTS
def test_a_box_slides_down_as_coulomb_says(record_property, time_step):
    """Row 8: a = g (sin θ − μ cos θ)."""
    mu, angle = 0.3, math.atan(0.5)
    box = BoxOnIncline(foundation(mu=mu), angle, time_step=time_step)
    log = box.run.advance_to(0.6).after(0.2)
    a = slope(log.time, log.v[:, 3:6] @ box.downhill)
    expected = GRAVITY * (math.sin(angle) - mu * math.cos(angle))
    check(record_property, (8, "sliding down: a [m/s²]" + on(time_step)), expected, a, 0.005)


@ON_BOTH_PLANTS
@pytest.mark.parametrize(
    "resolution",
    [
        pytest.param(
            0.3,
            marks=pytest.mark.xfail(
                strict=True,
                reason="3 % too soft: where nodes of two levels meet at a face's rim, shares of the"
                " lattice do not sum to its area",
            ),
        ),
        0.1,
        0.05,
    ],
)
def test_a_held_box_leans_on_its_tangential_springs(record_property, resolution, time_step):
    """Row 8: the offset while stuck is m g sin θ / K_t, where nothing has slipped.

    Also where most nodes lie on the edges of the face, whose springs must not hang on the walls.
    """
    mu, k = 0.5, 5 * K
    angle = math.atan(0.2 * mu)
    contact = foundation(k=k, mu=mu, resolution=resolution)
    offset = BoxOnIncline(contact, angle, time_step=time_step).slide(0.25)
    expected = WEIGHT * math.sin(angle) / (KT * k / K)
    row = (8, "offset while stuck [m]" + on(time_step))
    check(record_property, row, expected, offset, 0.005)


@pytest.mark.parametrize(
    ("k", "alpha", "share", "drop"),
    [
        (1e9, 0.07, 0.9, 1e-4),
        (None, None, 0.9, 1e-4),
        (1e7, 0.07, 0.9, 1e-4),
        (1e8, 0.2, 0.99, 0.0),
    ],
)
def test_a_box_put_down_on_a_slope_comes_to_rest(k, alpha, share, drop):
    """Row 8: lightly damped, near its friction's limit, it would rock for ever and walk down."""
    scene = Scene()
    R_WF = scene.floor(math.atan(share * 0.5), 0.5)
    body = scene.box("box", 1.0, (0.1, 0.1, 0.1), 0.5)
    config = ContactConfig(k=k, alpha=alpha, half_space_reach=10.0)
    run = scene.build(config, step=1e-4)
    start = (0.05 + drop) * R_WF.matrix()[:, 2]
    run.place(body, R_WF, start)
    places = []
    for time in (1.0, 1.5):
        run.advance_to(time)
        places.append(run.point(body))
    assert np.abs(places[1] - places[0]).max() < 1e-8
    assert np.linalg.norm(places[0] - start) < 0.03


def test_a_box_does_not_walk_when_its_load_pulsates():
    """A ratchet: weight and push swing together by half, at 0.9 of what friction bears."""
    mu, share, period = 0.5, 0.9, 0.5
    scene = Scene()
    scene.floor()
    body = scene.box("box", MASS, SIZE)

    def push(t: float) -> np.ndarray:
        lift = 0.5 * WEIGHT * math.sin(2 * math.pi * t / period) * (t > 1)
        along = share * mu * (WEIGHT - lift) * min(1.0, t)
        return np.array([0, -SIZE[2] / 2 * along, 0, along, 0, lift])  # at the face's height

    run = scene.build(foundation(mu=mu), push)
    run.place(body, p=(0, 0, SIZE[2] / 2 - SINK))
    where = []
    for cycle in range(8):
        run.advance_to(1 + cycle * period)
        where.append(run.point(body, [0, 0, -SIZE[2] / 2])[0])
    steps = np.abs(np.diff(where))
    assert steps[0] > 1e-9  # it settles in the first
    assert steps[2:].max() < 1e-11


@pytest.mark.slow
def test_a_box_held_for_a_minute_does_not_creep(record_property):
    """Row 8: at tan θ = 0.99 μ, where the same model under Drake's own contact creeps."""
    mu = 0.5
    angle = math.atan(0.99 * mu)
    drift = []
    for contact, time_step in ((foundation(mu=mu), 0.0), (foundation(mu=mu), 1e-3), (None, 1e-3)):
        box = BoxOnIncline(contact, angle, time_step=time_step, friction=mu)
        box.run.advance_to(2.0)
        drift.append(abs(box.slide(60.0)))
    *ours, drakes = drift
    for got, time_step in zip(ours, (0.0, 1e-3), strict=True):
        row = (8, "drift in 60 s [m]" + on(time_step))
        check(record_property, row, 0.0, got, 1e-9, relative=False)
    beside = (8, "drift in 60 s under Drake's own contact [m]", "", drakes, "", "")
    record_property("validation", beside)
    assert drakes > 1e-9  # else the comparison shows nothing


def test_sliding_to_a_stop(record_property):
    """Row 9: x = v²/(2 μ g); a plant that moves as its steps end lacks h v/2, 0.7 % at 1 ms."""
    mu, speed, row = 0.3, 0.5, (9, "way to a stop [m]")

    def way(time_step: float) -> float:
        box = BoxOnIncline(foundation(mu=mu), time_step=time_step, speed=speed)
        found = box.slide(0.5)
        assert abs(box.slide(0.5)) < 1e-9
        return found

    expected = speed**2 / (2 * mu * GRAVITY)
    check(record_property, row, expected, way(0.0), 0.005)
    check_first_order(record_property, row, expected, 1e-3, way, 0.005)


@ON_BOTH_PLANTS
def test_friction_loop(record_property, time_step):
    """Row 13: a cycle of amplitude X loses 4 μ N (X − μ N / k_t)."""
    mu, frequency = 0.4, 10.0
    limit = mu * WEIGHT
    amplitude = 4 * limit / KT
    scene = Scene(time_step=time_step)
    scene.floor()
    carriage = scene.swing("carriage", frequency)
    scene.shape(scene.slider("box", MASS, SIZE, carriage, [0, 0, 1]), Box(*SIZE))
    # Hardly damped: that would lose energy too.
    run = scene.build(foundation(alpha=0.2, mu=mu, damping=0.0, resolution=0.1), step=1e-3)
    run.plant.SetPositions(run.plant_context, [0.0, SIZE[2] / 2 - SINK])
    run.plant.SetVelocities(run.plant_context, [amplitude * frequency, 0.0])
    cycle = 2 * math.pi / frequency
    run.advance_to(cycle)
    start = run.energies()[3]
    log = run.advance_to(4 * cycle)
    reached = np.abs(log.q[:, 0]).max()
    lost = (run.energies()[3] - start) / 3
    expected = 4 * limit * (reached - limit / KT)
    row = (13, "lost in a friction loop [J]" + on(time_step))
    check(record_property, row, expected, lost, 0.01)


@ON_BOTH_PLANTS
def test_no_drift_below_the_cone(record_property, time_step):
    """Row 13: a force that swings within ± 0.9 μ N returns the box to the same point for ever."""
    mu, cycle = 0.4, 0.314  # whole steps
    scene = Scene(time_step=time_step)
    scene.floor()
    body = scene.box("box", MASS, SIZE)
    swing = 0.9 * mu * WEIGHT * np.array([0, 0, 0, 1, 0, 0])

    def push(time: float):
        # Grows slowly, so that no swing of the box about its anchors adds to it. Applied at the
        # middle of the bottom, so that it does not tip the box.
        force = swing * math.sin(2 * math.pi * time / cycle) * min(1.0, time)
        return force + np.array([0, -SIZE[2] / 2 * force[3], 0, 0, 0, 0])

    run = scene.build(foundation(mu=mu), push, step=1e-3)
    run.place(body, p=(0, 0, SIZE[2] / 2 - SINK))
    base = []
    for cycles in (8, 24):
        run.advance_to(cycles * cycle)
        base.append(run.point(body, [0, 0, -SIZE[2] / 2])[0])
    drift = abs(base[1] - base[0]) / 16
    row = (13, "drift a cycle below μ N [m]" + on(time_step))
    check(record_property, row, 0.0, drift, 1e-9, relative=False)


@ON_BOTH_PLANTS
@pytest.mark.parametrize(("share", "verdict"), [(0.9, "slides"), (1.1, "tips")])
def test_tipping(record_property, share, verdict, time_step):
    """Row 23: pushed at its centre ever harder, a box tips before it slides if μ > b/h."""
    b, h = 0.04, 0.1
    sink = 1e-5 * b  # so stiff that the edge it tips about is the edge of the box
    mu = share * b / h
    scene = Scene(time_step=time_step)
    scene.floor()
    body = scene.box("box", MASS, (b, 0.1, h))

    def push(time: float):
        return WEIGHT * b / h * (0.5 + time) * np.array([0, 0, 0, 1, 0, 0])

    run = scene.build(foundation(k=WEIGHT / (0.1 * b * sink), mu=mu), push, step=2e-4)
    run.place(body, p=(0, 0, h / 2 - sink))
    got = "stays"
    while got == "stays":
        run.advance_to(run.context.get_time() + 0.01)
        if run.tilt(body) > 0.2:
            got = "tips"
        elif run.point(body, [b / 2, 0, -h / 2])[0] > b / 2 + 0.01:
            got = "slides"
        assert run.context.get_time() < 2
    judge(record_property, (23, f"pushed box, μ = {share:g} b/h" + on(time_step)), verdict, got)


@pytest.mark.slow
@ON_BOTH_PLANTS
def test_vibrating_table(record_property, time_step):
    """Row 20: pushed by F, a box moves over a shaking table at v = A ω sin(π F / 2 μ N)."""
    mu, frequency, amplitude, share = 0.3, 300.0, 0.003, 0.5
    sink = 1e-6  # so stiff that friction turns round in no time
    scene = Scene(time_step=time_step)
    table = scene.swing("table", frequency)
    scene.shape(table, Box(8, 0.5, 0.2), RigidTransform([0, 0, -0.1]))
    body = scene.box("box", MASS, SIZE)
    pull = share * mu * WEIGHT

    def push(_time: float):
        force = np.zeros(7)
        # Applied at the middle of the bottom, so that it does not tip the box.
        force[start + 1] = -SIZE[2] / 2 * pull
        force[start + 3] = pull
        return force

    run = scene.build(foundation(k=WEIGHT / AREA / sink, mu=mu), push, step=2.5e-4)
    start = body.floating_velocities_start_in_v()
    run.place(body, p=(0, 0, SIZE[2] / 2 - sink))
    joint = run.plant.GetJointByName("table")
    joint.set_translation_rate(run.plant_context, amplitude * frequency)
    cycle = 2 * math.pi / frequency
    run.advance_to(100 * cycle)
    x, t = run.point(body)[0], run.context.get_time()
    run.advance_to(150 * cycle)
    v = (run.point(body)[0] - x) / (run.context.get_time() - t)
    expected = amplitude * frequency * math.sin(math.pi / 2 * share)
    row = (20, "mean speed over a vibrating table [m/s]" + on(time_step))
    check(record_property, row, expected, v, 0.02)
