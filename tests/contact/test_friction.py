"""Anchored friction: the state rule, step by step, and what holding and sliding must come to."""

import contact_scenes as scenes
import numpy as np
import pytest
from contact_scenes import GRAVITY
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from contact_toolkit import CollisionMesh, Friction, NonlinearDamper

pytestmark = pytest.mark.engine

K = 1e4  # [N/m] of one facet pair
STANDOFF = 1e-3
DEPTH = 4e-4
RATIO = 2 / 3
TRIPOD = ((0.1, 0.0), (-0.05, 0.09), (-0.05, -0.09))


class Hand:
    """Moves a one-footed body over a plane by hand, one accepted step at a time."""

    def __init__(
        self, friction: Friction, *, alpha: float = 0.0, ground: CollisionMesh | None = None
    ):
        self.model = scenes.facet_model(
            scenes.stool(),
            ground or scenes.plane(),
            NonlinearDamper(K, alpha),
            standoff=STANDOFF,
            friction=friction,
        )
        self.state = self.model.initial_state()
        self.time = 0.0

    def look(self, x, depth=DEPTH, *, v=(0.0, 0.0, 0.0), y=0.1):
        """Forces at a position, without taking the step."""
        return self.model.evaluate(
            scenes.poses((x, y, STANDOFF - depth)), scenes.velocities(v), self.state
        )

    def step(self, x, depth=DEPTH, *, v=(0.0, 0.0, 0.0), y=0.1):
        """Take the step; return the friction force on the body [N] along x."""
        forces = self.look(x, depth, v=v, y=y)
        self.time += 1e-3
        self.state = self.model.advance(self.state, self.time, forces)
        return forces.body_wrenches[1, 3]

    def held(self):
        return self.look(0.2).contacts.anchored.all()


def load(depth=DEPTH):
    return 3 * K * depth  # three facets meet in the tip


KT = 3 * RATIO * K


def test_a_held_contact_is_a_spring():
    hand = Hand(Friction(0.5))
    hand.step(0.2)
    for x in (1e-5, -3e-5, 5e-5, 0.0, 2e-5):
        assert hand.step(0.2 + x) == pytest.approx(-KT * x, rel=1e-9, abs=1e-9)
    assert hand.held()


def test_the_anchor_of_a_held_contact_stays_to_the_bit():
    hand = Hand(Friction(0.5))
    hand.step(0.2)
    first = hand.look(0.2 + 1e-5).body_wrenches.tobytes()
    for i in range(500):
        hand.step(
            0.2 + 5e-5 * np.sin(i), DEPTH * (1 + 0.3 * np.sin(1.7 * i)), y=0.1 + 1e-5 * (i % 2)
        )
    assert hand.look(0.2 + 1e-5).body_wrenches.tobytes() == first


def test_slipping_drags_the_anchor_and_turning_back_unloads_it():
    mu = 0.4
    hand = Hand(Friction(mu))
    hand.step(0.2)
    limit = mu * load()
    for x in (3e-4, 5e-4, 1e-3):
        assert hand.step(0.2 + x, v=(0.1, 0, 0)) == pytest.approx(-limit)
    assert not hand.held()
    # Back by 1 %, then by twice the stretch of the cone: it slips the other way.
    back = 0.01 * limit / KT
    assert hand.step(0.2 + 1e-3 - back, v=(-0.1, 0, 0)) == pytest.approx(-0.99 * limit)
    assert hand.held()
    assert hand.step(0.2 + 1e-3 - 3 * limit / KT, v=(-0.1, 0, 0)) == pytest.approx(limit)


def test_a_falling_load_lets_a_held_contact_slip():
    hand = Hand(Friction(0.4))
    hand.step(0.2)
    x = 0.9 * 0.4 * load() / KT
    hand.step(0.2 + x)
    assert hand.step(0.2 + x, 0.5 * DEPTH) == pytest.approx(-0.4 * load(0.5 * DEPTH))
    # The stretch that slipped does not come back with the load.
    assert hand.step(0.2 + x) == pytest.approx(-0.4 * load(0.5 * DEPTH))


def test_static_friction_holds_more_than_dynamic():
    hand = Hand(Friction(0.5, 0.3))
    hand.step(0.2)
    x = 0.45 * load() / KT
    assert hand.step(0.2 + x, v=(0.1, 0, 0)) == pytest.approx(-0.45 * load())
    assert hand.held()
    slip = 0.51 * load() / KT
    hand.step(0.2 + slip, v=(0.1, 0, 0))
    assert not hand.held()
    assert hand.step(0.2 + 1.1 * slip, v=(0.1, 0, 0)) == pytest.approx(-0.3 * load())
    hand.step(0.2 + 1.09 * slip, v=(-0.1, 0, 0))  # turns back: holds again
    assert hand.held()
    x = 0.2 + 1.09 * slip + 0.1 * load() / KT
    assert abs(hand.step(x, v=(0.1, 0, 0))) > 0.3 * load()


def test_a_growing_load_does_not_stop_what_slides_on():
    hand = Hand(Friction(0.5, 0.2))
    hand.step(0.2)
    hand.step(0.2 + 0.6 * load() / KT, v=(0.1, 0, 0))
    assert not hand.held()
    x = 0.2 + 0.65 * load() / KT
    hand.step(x, 1.5 * DEPTH, v=(0.1, 0, 0))  # within the cone, but only because that grew
    assert not hand.held()
    hand.step(x, 1.5 * DEPTH, v=(-1e-9, 0, 0))
    assert hand.held()


@pytest.mark.parametrize("leaning", ["body", "ground"])
def test_leaning_about_the_contact_does_not_change_a_held_force(leaning):
    # The body tilts about the middle of its gap to the ground, or everything else does.
    hand = Hand(Friction(0.8))
    half_gap = np.array([0, 0, (STANDOFF - DEPTH) / 2])
    hand.step(0.2)
    for tilt in np.linspace(0, 0.4, 9):
        R = Rotation.from_rotvec([0.3 * tilt, tilt, 0.2 * tilt]).as_matrix()
        X_FB = scenes.poses(np.array([0.2 + 5e-5, 0.1, 0]) + half_gap + R @ half_gap, R)
        to_ground = np.eye(3)
        if leaning == "ground":
            to_ground = R
            X_FB[:, :3] = R.T @ X_FB[:, :3]
        forces = hand.model.evaluate(X_FB, scenes.velocities(), hand.state)
        friction = (to_ground @ forces.body_wrenches[1, 3:])[:2]
        assert_allclose(friction, [-KT * 5e-5, 0], rtol=1e-9, atol=1e-9)
        hand.time += 1e-3
        hand.state = hand.model.advance(hand.state, hand.time, forces)


def test_a_new_contact_slides_from_no_force():
    hand = Hand(Friction(0.5))
    hand.step(0.2, -1e-4)
    forces = hand.look(0.2001, 1e-9, v=(1.0, 0, 0)).contacts
    assert not forces.anchored.any()
    assert abs(forces.friction_force_F[0, 0]) <= 0.5 * load(1e-9) * (1 + 1e-12)


def test_contact_within_a_step_is_stretched_since_touching():
    # A straight oblique approach, taken as one step or as many: the same force.
    slope = 0.2  # tangential over normal motion: within the cone
    coarse, fine = Hand(Friction(0.5)), Hand(Friction(0.5))
    coarse.step(0.2, -DEPTH)
    for depth in np.linspace(-DEPTH, DEPTH, 200):
        gentle = fine.step(0.2 + slope * (depth + DEPTH), depth)
    sudden = coarse.step(0.2 + slope * 2 * DEPTH, DEPTH)
    assert sudden == pytest.approx(-KT * slope * DEPTH)
    assert gentle == pytest.approx(sudden, rel=1e-9)


def test_bodies_that_start_in_contact_start_without_stretch():
    hand = Hand(Friction(0.5))
    assert hand.look(0.2).body_wrenches[1, 3] == 0
    assert hand.look(0.3).body_wrenches[1, 3] == 0  # there is no step yet to be stretched since
    hand.step(0.2)
    assert hand.look(0.2).body_wrenches[1, 3] == pytest.approx(0, abs=1e-12)


def test_an_opened_contact_forgets_its_anchor():
    hand = Hand(Friction(0.5))
    hand.step(0.2)
    assert hand.step(0.2 + 5e-5) < 0
    hand.step(0.2 + 5e-5, -DEPTH)
    hand.step(0.2 + 5e-5, 0.0)
    assert hand.step(0.2 + 5e-5) == pytest.approx(0, abs=1e-12)


def test_evaluations_change_nothing():
    hand = Hand(Friction(0.5), alpha=0.5)
    hand.step(0.2)
    before = hand.look(0.2 + 3e-5, v=(0.2, 0.1, -0.1)).body_wrenches.tobytes()
    for x in np.linspace(-1e-3, 1e-3, 20):
        hand.look(0.2 + x, v=(1.0, 0, 0))
    assert hand.look(0.2 + 3e-5, v=(0.2, 0.1, -0.1)).body_wrenches.tobytes() == before


def test_a_time_before_the_last_step_starts_afresh():
    hand = Hand(Friction(0.5))
    hand.step(0.2)
    hand.step(0.2 + 5e-5)
    fresh = hand.model.advance(hand.state, 0.0, hand.look(0.2 + 5e-5))
    forces = hand.model.evaluate(
        scenes.poses((0.2 + 5e-5, 0.1, STANDOFF - DEPTH)), scenes.velocities(), fresh
    )
    assert forces.body_wrenches[1, 3] == pytest.approx(0, abs=1e-12)
    assert_allclose(fresh.losses, 0)


def across_edge(x):
    """Where the foot stands on its way over the diagonal edge x = y of a plane."""
    return {"x": 0.2 + x, "y": 0.2001}


def test_stretch_passes_to_the_neighbouring_facet():
    # Within a step: a tip held back by friction is drawn over an edge. Nothing jumps, although the
    # springs that held it are replaced by others.
    hand = Hand(Friction(1.5))
    hand.step(**across_edge(0.0))
    hand.step(**across_edge(5e-5))
    path = np.linspace(5e-5, 1.5e-4, 2001)
    looks = [hand.look(**across_edge(x)) for x in path]
    assert len({tuple(look.contacts.key) for look in looks}) > 1
    forces = np.array([look.body_wrenches[1, 3:] for look in looks])
    steepest = 2 * KT * (path[1] - path[0])  # both facets hold
    assert np.abs(np.diff(forces, axis=0)).max() < 1.02 * steepest


@pytest.mark.parametrize("y", [0.1007, 0.1 + 1e-7, 0.1])
def test_a_contact_dragged_over_many_edges_keeps_its_force(y):
    # Step after step over a fine plane, always held: each adds what the springs' stiffness says.
    hand = Hand(Friction(3.0), ground=scenes.plane(800))
    x = np.linspace(0.2001, 0.2031, 600)
    seen, forces, stiffness = set(), [], []
    for p in x:
        contacts = hand.look(p, y=y).contacts
        seen |= set(contacts.key.tolist())
        stiffness.append(RATIO * K * contacts.multiplicity.sum())
        forces.append(hand.step(p, y=y))
    assert len(seen) > 2
    jumps = np.abs(np.diff(forces)) / (np.maximum(stiffness[1:], stiffness[:-1]) * np.diff(x))
    assert jumps.max() < 1.5


def test_passing_stretch_on_makes_no_energy():
    # A figure of eight about a vertex where six facets meet, its stretch passed to and fro.
    hand = Hand(Friction(3.0, damping=0.0), ground=scenes.plane(800))
    size, speed, losses = 2e-4, 7.0, []
    for i in range(4001):
        a = speed * 1e-3 * i
        hand.step(
            0.20501 + size * np.cos(a),
            y=0.105 + size * np.sin(2 * a),
            v=(-size * speed * np.sin(a), 2 * size * speed * np.cos(2 * a), 0),
        )
        losses.append(hand.state.losses[1])
    assert np.diff(losses).min() > -1e-5  # what the quadrature is off
    assert losses[-1] < 5e-3  # of some 0.05 J that went in and out each round


def test_forces_are_continuous_from_touch_to_stick():
    hand = Hand(Friction(0.5), alpha=0.5)
    hand.step(0.2, -DEPTH, v=(0.3, 0, -1.0))
    path = np.linspace(0, 1, 4001)
    forces = np.array(
        [
            hand.look(0.2 + 2e-4 * s, DEPTH * (2 * s - 1), v=(0.3 - 0.6 * s, 0, -1 + 2 * s))
            .body_wrenches[1, 3:]
            for s in path
        ]
    )  # fmt: skip
    steps = np.abs(np.diff(forces, axis=0)).max(axis=0)
    assert steps[0] < 2e-3 * np.abs(forces[:, 0]).max()
    assert steps[2] < 2e-3 * np.abs(forces[:, 2]).max()


def test_the_friction_loop_loses_what_coulomb_says():
    # Row 13: amplitude X over the elastic range: 4 μ N (X − μ N/k_t) a cycle; below it nothing.
    mu, n = 0.3, 400
    limit = mu * load()
    for amplitude, lost in (
        (3 * limit / KT, 4 * limit * (3 - 1) * limit / KT),
        (0.9 * limit / KT, 0),
    ):
        hand = Hand(Friction(mu))
        work, last = 0.0, None
        losses = []
        for i in range(3 * n + 1):
            angle = 2 * np.pi * i / n
            x = 0.2 + amplitude * np.sin(angle)
            force = hand.step(x, v=(amplitude * 2 * np.pi / n * 1e3 * np.cos(angle), 0, 0))
            if last is not None and i > n:
                work -= 0.5 * (force + last[1]) * (x - last[0])
            if i in (n, 3 * n):
                losses.append(hand.state.losses[1])
            last = (x, force)
        assert work / 2 == pytest.approx(lost, rel=0.01, abs=1e-9)
        assert (losses[1] - losses[0]) / 2 == pytest.approx(lost, rel=0.01, abs=1e-7)


def test_media_that_only_resist_have_no_memory():
    damping = 0.05
    hand = Hand(Friction(5.0, stiffness_ratio=0.0, damping=damping))
    hand.step(0.2)
    for x, v in ((1e-4, 0.0), (3e-4, 1e-3), (-2e-4, -2e-3)):
        assert hand.step(0.2 + x, v=(v, 0, 0)) == pytest.approx(-damping * 3 * K * v, abs=1e-12)
    assert not hand.look(0.2).contacts.anchored.any()


def test_tangential_damping_follows_the_normal_spring_unless_given():
    speed, alpha = 1e-3, 0.8
    like_normal, given = Hand(Friction(5.0), alpha=alpha), Hand(Friction(5.0, damping=1e-4))
    like_normal.step(0.2)
    given.step(0.2)
    assert like_normal.look(0.2, v=(speed, 0, 0)).body_wrenches[1, 3] == pytest.approx(
        -1.5 * alpha * RATIO * load() * speed
    )
    assert given.look(0.2, v=(speed, 0, 0)).body_wrenches[1, 3] == pytest.approx(
        -1e-4 * 3 * K * speed
    )


def slider(friction, *, k=2e4, alpha=5.0, v=(0.0, 0.0, 0.0), force=(0.0, 0.0, -GRAVITY)):
    """A tripod of 1 kg at the depth where the plane carries it."""
    model = scenes.facet_model(
        scenes.stool(TRIPOD), scenes.plane(), NonlinearDamper(k, alpha), friction=friction
    )
    depth = -force[2] / (9 * k)
    return scenes.Slider(model, 1.0, (0.15, 0.2, STANDOFF - depth), v, np.array(force), 1e-7)


def incline(angle):
    return GRAVITY * np.sin(angle), 0.0, -GRAVITY * np.cos(angle)


def test_a_block_held_at_one_percent_margin_does_not_creep():
    # Row 8.
    mu, k = 0.5, 2e4
    force = incline(np.arctan(0.99 * mu))
    body = slider(Friction(mu), k=k, force=force)
    body.advance_to(3.0)
    settled = body.state[:3].copy()
    body.advance_to(5.0)
    assert np.abs(body.state[:2] - settled[:2]).max() < 1e-15
    assert body.state[2] == pytest.approx(settled[2], abs=1e-11)
    assert body.forces().body_wrenches[1, 3:] == pytest.approx(-np.array(force), abs=1e-5)


def test_a_held_block_leans_on_its_tangential_springs():
    # Row 8: the offset while stuck is the load over the stiffness, once nothing has slipped.
    mu, k = 0.5, 2e4
    force = incline(np.arctan(0.4 * mu))
    body = slider(Friction(mu), k=k, force=force)
    body.advance_to(4.0)
    assert body.state[0] - 0.15 == pytest.approx(force[0] / (9 * RATIO * k), rel=0.005)


def test_a_block_on_too_steep_an_incline_slides_as_coulomb_says():
    mu, angle = 0.3, np.arctan(0.5)
    body = slider(Friction(mu), force=incline(angle))
    body.advance_to(0.1)
    start = body.state[3]
    body.advance_to(0.3)
    expected = GRAVITY * (np.sin(angle) - mu * np.cos(angle))
    assert (body.state[3] - start) / 0.2 == pytest.approx(expected, rel=0.005)


def test_a_sliding_block_stops_where_coulomb_says():
    # Row 9.
    mu, speed = 0.3, 0.5
    body = slider(Friction(mu), v=(speed, 0.0, 0.0))
    start = body.energy()
    body.advance_to(0.3)
    assert body.state[0] - 0.15 == pytest.approx(speed**2 / (2 * mu * GRAVITY), rel=0.005)
    assert body.energy() == pytest.approx(start, abs=1e-4 * 0.5 * speed**2)


def test_an_oblique_hit_in_full_slip_loses_what_coulomb_says():
    # Row 12, for a body that cannot turn.
    mu, alpha, speed = 0.2, 1.0, 0.3
    body = slider(Friction(mu), alpha=alpha, v=(0.6, 0.0, -speed), force=(0.0, 0.0, -1e-9))
    body.advance_to(0.03)
    e = NonlinearDamper(1.0, alpha).restitution(speed)
    assert body.state[5] == pytest.approx(e * speed, rel=1e-3)
    assert body.state[3] == pytest.approx(0.6 - mu * (1 + e) * speed, rel=0.01)


def test_a_grasp_does_not_creep():
    # Row 14 in one direction: squeezed with a swinging force, pulled at 90 % of the cone.
    mu = 0.7
    hand = Hand(Friction(mu))
    x, depth = 0.2, DEPTH
    hand.step(x, depth)
    low = 0.6
    pull = 0.9 * mu * load(low * depth)
    x += pull / KT
    ends = []
    for i in range(3000):
        squeeze = depth * (low + (1 - low) * np.sin(0.37 * i) ** 2)
        force = hand.step(x, squeeze)
        x += (pull + force) / KT  # quasi-static: rests where the spring carries the pull
        ends.append(x)
    assert ends[-1] == ends[0] == pytest.approx(0.2 + pull / KT, abs=1e-15)


@pytest.mark.parametrize(
    ("parameters", "complaint"),
    [
        ({"static": -0.1}, "static must be finite and not negative"),
        ({"static": np.nan}, "static must be finite"),
        (
            {"static": 0.3, "dynamic": 0.4},
            "dynamic must be between 0 and the static coefficient 0.3",
        ),
        ({"static": 0.3, "stiffness_ratio": 0.5}, "stiffness_ratio must be 0 or between 2/3 and 1"),
        ({"static": 0.3, "damping": -1.0}, "damping must be finite and not negative"),
    ],
)
def test_impossible_parameters_are_named(parameters, complaint):
    with pytest.raises(ValueError, match=complaint):
        Friction(**parameters)


def test_coefficients_combine_as_in_drake():
    assert Friction.combined_coefficient(0.3, 0.6) == pytest.approx(0.4)
    assert Friction.combined_coefficient(0.0, 0.0) == 0.0
    assert Friction.combined_coefficient(0.0, 1.0) == 0.0
    with pytest.raises(ValueError, match="must not be negative"):
        Friction.combined_coefficient(-0.1, 1.0)
