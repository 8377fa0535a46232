"""ContactModel with the facet web: energy, symmetry, closed forms through the native springs."""

import copy
from dataclasses import replace

import contact_scenes as scenes
import mesh_shapes
import numpy as np
import poses as random_poses
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from contact_toolkit import (
    AreaWeb,
    CollisionMesh,
    ContactGeometry,
    ContactModel,
    ContactPair,
    ContactState,
    FacetWeb,
    Friction,
    NonlinearDamper,
    witness_pairs,
)
from contact_toolkit.shapes.primitives import Primitive, box

pytestmark = pytest.mark.engine

BY_FACETS = FacetWeb(0.01)
TRIPOD = ((0.1, 0.0), (-0.05, 0.09), (-0.05, -0.09))


def crowd(
    threads: int = 1, web: AreaWeb | FacetWeb = BY_FACETS
) -> tuple[ContactModel, np.ndarray, np.ndarray]:
    """Six bodies in a heap, every pair declared, one body with two geometries."""
    rng = np.random.default_rng(3)
    shapes = [mesh_shapes.doughnut(), mesh_shapes.cube(0.06), mesh_shapes.ball(1, radius=0.04)]
    meshes = [CollisionMesh(*shape) for shape in shapes]
    geometries = [
        ContactGeometry(f"g{i}", i % 6, meshes[i % 3], random_poses.random_pose(rng, 0.03))
        for i in range(7)
    ]
    damper = NonlinearDamper(k=1e3, alpha=0.4)
    pairs = [
        ContactPair(a, b, damper, web, Friction(0.4))
        for a in range(7)
        for b in range(a)
        if a % 6 != b % 6
    ]
    model = ContactModel([f"b{i}" for i in range(6)], geometries, pairs, threads=threads)
    X_FB = np.stack([random_poses.random_pose(rng, 0.05) for _ in range(6)])
    return model, X_FB, rng.normal(size=(6, 6))


def test_springs_are_the_witness_pairs_with_their_multiplicity():
    cone, doughnut = (
        CollisionMesh(*mesh_shapes.cone()),
        CollisionMesh(*mesh_shapes.doughnut()),
    )
    k, standoff = 25.0, 0.004
    X_FB = scenes.poses((0.001, 0.0, 0.177))
    pairs = witness_pairs(doughnut, cone, np.linalg.inv(X_FB[1]), standoff)
    near = pairs.distance < standoff
    for weighting, weight in (("multiplicity", pairs.multiplicity[near]), ("unit", 1.0)):
        model = scenes.facet_model(
            doughnut, cone, NonlinearDamper(k), standoff=standoff, weighting=weighting
        )
        contacts = model.evaluate(X_FB, scenes.velocities()).contacts
        assert len(contacts) == near.sum() > 20
        assert_allclose(contacts.deformation, standoff - pairs.distance[near])
        assert_allclose(contacts.normal_force, k * weight * contacts.deformation)
        assert_array_equal(contacts.multiplicity, pairs.multiplicity[near])
        assert_allclose(contacts.normal_F, pairs.normal_A[near], atol=1e-12)


def test_crossing_facets_push_with_the_full_standoff():
    model = scenes.facet_model(scenes.stool(), scenes.plane(), NonlinearDamper(1e3))
    contacts = model.evaluate(scenes.poses((0.1, 0.2, -0.01)), scenes.velocities()).contacts
    assert_allclose(contacts.deformation, 1e-3)
    assert (contacts.normal_F[:, 2] > 0).any()


@pytest.mark.parametrize("n", [1.0, 1.5])
def test_wrench_is_the_gradient_of_the_stored_energy(n):
    doughnut, cone = CollisionMesh(*mesh_shapes.doughnut()), CollisionMesh(*mesh_shapes.cone())
    model = scenes.facet_model(doughnut, cone, NonlinearDamper(1e4, n=n), standoff=0.006)
    R, p = Rotation.from_rotvec([0.03, -0.02, 0.4]), np.array([0.001, 0.0005, 0.179])

    def stored(angles, shift):
        turned = (Rotation.from_rotvec(angles) * R).as_matrix()
        return model.evaluate(scenes.poses(p + shift, turned), scenes.velocities()).energies[0]

    forces = model.evaluate(scenes.poses(p, R.as_matrix()), scenes.velocities())
    assert len(forces.loaded) > 20
    assert forces.contacts.deformation.max() < 0.006  # where facets cross, energy is at its ceiling
    step, zero = 1e-7, np.zeros(3)
    gradient = [
        (stored(step * e, zero) - stored(-step * e, zero)) / (2 * step) for e in np.eye(3)
    ] + [(stored(zero, step * e) - stored(zero, -step * e)) / (2 * step) for e in np.eye(3)]
    scale = np.abs(forces.body_wrenches[1]).max()
    assert_allclose(forces.body_wrenches[1], -np.array(gradient), atol=1e-6 * scale)


@pytest.mark.parametrize("offset", [0.0, 1e4])
def test_forces_and_moments_of_all_bodies_sum_to_zero(offset):
    model, X_FB, V_FB = crowd()
    X_FB[:, :3, 3] += [offset, -offset, offset]
    wrenches = model.evaluate(X_FB, V_FB).body_wrenches
    p = X_FB[:, :3, 3] - X_FB[0, :3, 3]
    moments = wrenches[:, :3] + np.cross(p, wrenches[:, 3:])
    scale = np.abs(wrenches).max()
    assert scale > 1
    assert_allclose(wrenches[:, 3:].sum(0), 0, atol=1e-12 * scale)
    assert_allclose(moments.sum(0), 0, atol=1e-12 * scale)


@pytest.mark.parametrize("web", [AreaWeb(0.01), FacetWeb(0.01)], ids=["area", "facet"])
def test_contacts_listed_add_up_to_the_wrenches(web):
    """Rows that tell forces, directions, points or pairs otherwise than they act."""
    model, X_FB, V_FB = crowd(web=web)
    forces = model.evaluate(X_FB, V_FB)
    contacts = forces.contacts
    assert len(contacts) > 100
    assert repr(contacts) == (
        f"ContactArrays({len(contacts)} springs of {len(forces.loaded.pairs)} pairs)"
    )
    force_on_a = contacts.normal_force[:, None] * contacts.normal_F + contacts.friction_force_F
    wrenches = np.zeros((6, 6))
    for side, sign in (("a", 1), ("b", -1)):
        geometry = np.array([getattr(pair, side) for pair in model.pairs])[contacts.pair]
        body = np.array(model.geometry_bodies)[geometry]
        moment = np.cross(contacts.p_FC - X_FB[body, :3, 3], force_on_a)
        np.add.at(wrenches, body, sign * np.hstack([moment, force_on_a]))
    assert np.abs(contacts.friction_force_F).max() > 0
    assert_allclose(wrenches, forces.body_wrenches, atol=1e-12 * np.abs(wrenches).max())


def test_contact_far_from_the_origin_is_the_same():
    model, X_FB, V_FB = crowd()
    here = model.evaluate(X_FB, V_FB)
    X_FB[:, :3, 3] = (X_FB[:, :3, 3] + 1e4) - 1e4  # what survives the shift
    here = model.evaluate(X_FB, V_FB)
    X_FB[:, :3, 3] += 1e4
    far = model.evaluate(X_FB, V_FB)
    assert_allclose(far.body_wrenches, here.body_wrenches, rtol=1e-11, atol=1e-12)


def test_a_common_motion_changes_nothing_but_the_frame():
    model, X_FB, V_FB = crowd()
    X_GF = random_poses.random_pose(np.random.default_rng(5), 1.0)
    R = X_GF[:3, :3]
    common_w, common_v = np.array([0.3, -1.0, 2.0]), np.array([5.0, 1.0, -2.0])
    turned = np.concatenate([V_FB[:, :3] @ R.T, V_FB[:, 3:] @ R.T], axis=1)
    X_GB = X_GF @ X_FB
    turned[:, :3] += common_w
    turned[:, 3:] += common_v + np.cross(common_w, X_GB[:, :3, 3])
    before = model.evaluate(X_FB, V_FB).body_wrenches
    after = model.evaluate(X_GB, turned).body_wrenches
    expected = np.concatenate([before[:, :3] @ R.T, before[:, 3:] @ R.T], axis=1)
    assert_allclose(after, expected, atol=1e-9 * np.abs(before).max())


@pytest.mark.parametrize("n", [1.0, 1.5])
@pytest.mark.parametrize("feet", [((0.0, 0.0),), TRIPOD])
def test_a_drop_meets_the_closed_forms(n, feet):
    # Rows 1, 3, 5 and 6: the springs of all feet act as one, whatever their number.
    k, alpha, mass, speed = 1e5, 0.4, 0.7, 1.1
    together = 3 * len(feet)  # three facets meet in a foot's tip
    whole = NonlinearDamper(together * k, alpha, n)
    standoff = 2 * whole.peak_deformation(mass, speed)
    model = scenes.facet_model(
        scenes.stool(feet), scenes.plane(), NonlinearDamper(k, alpha, n), standoff=standoff
    )
    body = scenes.Slider(model, mass, (0.2, 0.1, standoff), (0, 0, -speed), np.zeros(3))
    start = body.energy()
    peak = 0.0
    while body.state[2] < standoff or body.state[5] < 0:
        body.advance_to(body.time + 1e-5)
        peak = max(peak, standoff - body.state[2])
    assert body.state[5] / speed == pytest.approx(whole.restitution(speed), abs=1e-5)
    assert peak == pytest.approx(whole.peak_deformation(mass, speed), rel=1e-4)
    assert body.energy() == pytest.approx(start, rel=1e-4)


def test_an_undamped_impact_takes_the_closed_form_time():
    k, mass, speed, standoff = 1e5, 0.7, 1.1, 0.01
    model = scenes.facet_model(
        scenes.stool(), scenes.plane(), NonlinearDamper(k), standoff=standoff
    )
    body = scenes.Slider(model, mass, (0.2, 0.1, standoff), (0, 0, -speed), np.zeros(3))
    whole = NonlinearDamper(3 * k)
    body.advance_to(whole.elastic_impact_time(mass, speed))
    assert body.state[2] == pytest.approx(standoff, abs=1e-5 * whole.peak_deformation(mass, speed))
    assert body.state[5] == pytest.approx(speed, rel=1e-5)


@pytest.mark.threads
def test_any_number_of_threads_gives_the_same_bits():
    results = []
    for threads in (1, 2, 5):
        model, X_FB, V_FB = crowd(threads)
        forces = model.evaluate(X_FB, V_FB)
        results.append((forces.body_wrenches.tobytes(), forces.contacts.p_FC.tobytes()))
    assert len(set(results)) == 1


def test_two_simulations_in_turn_give_the_bits_of_each_alone():
    def start(speed, model=None):
        model = model or scenes.facet_model(
            scenes.stool(TRIPOD), scenes.plane(), NonlinearDamper(1e4, 0.3)
        )
        return scenes.Slider(model, 1.0, (0, 0, 1.2e-3), (0.1, 0, -speed), np.array([0, 0, -9.81]))

    alone = []
    for speed in (0.1, 0.2):
        body = start(speed)
        for i in range(1, 6):
            body.advance_to(0.004 * i)
        alone.append(body.state.tobytes())
    first = start(0.1)
    second = start(0.2, first.model)
    for i in range(1, 6):
        first.advance_to(0.004 * i)
        second.advance_to(0.004 * i)
    assert [first.state.tobytes(), second.state.tobytes()] == alone


def test_results_are_their_own_copies():
    model, X_FB, V_FB = crowd()
    forces = model.evaluate(X_FB, V_FB)
    state = model.advance(model.initial_state(), 0.0, forces)
    for result in (forces, forces.loaded, state):
        assert copy.copy(result) is result
        assert copy.deepcopy([result])[0] is result


def test_results_are_read_only():
    model, X_FB, V_FB = crowd()
    forces = model.evaluate(X_FB, V_FB)
    for array in (forces.body_wrenches, forces.contacts.p_FC):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_reading_an_accepted_step_again_costs_nothing():
    model, X_FB, V_FB = crowd()
    forces = model.evaluate(X_FB, V_FB)
    state = model.advance(model.initial_state(), 0.5, forces)
    assert model.find(X_FB, state) is forces.loaded
    assert model.evaluate(X_FB, V_FB, state) is model.forces(forces.loaded, V_FB, state)
    assert model.find(X_FB) is not forces.loaded
    X_FB[0, 0, 3] += 1e-12
    assert model.find(X_FB, state) is not forces.loaded


@pytest.mark.parametrize(
    "web",
    [
        FacetWeb(0.006),
        AreaWeb(),
        AreaWeb(field="exact", sampled="b"),
        AreaWeb(0.004, field="exact"),
        AreaWeb(0.002, sampled="a", fillet=2e-3),
    ],
    ids=str,
)
@pytest.mark.parametrize("ground", ["cone", "sheet"])
def test_remembering_the_last_step_changes_no_bit(web, ground):
    """Contact would depend on the past (broken: a tenth of the motion, a tenth of the margin)."""
    shape = mesh_shapes.cone() if ground == "cone" else mesh_shapes.sheet(24, wave=0.02)
    height = 0.177 if ground == "cone" else 0.02
    if ground == "sheet" and isinstance(web, AreaWeb):  # an open body can only be probed
        web = replace(web, standoff=web.standoff or 0.003, sampled="a")
    doughnut, ground_mesh = CollisionMesh(*mesh_shapes.doughnut()), CollisionMesh(*shape)
    model = scenes.model(doughnut, ground_mesh, NonlinearDamper(1e4), web=web)
    rng = np.random.default_rng(2)
    p, q, state = np.array([0.002, 0.001, height]), Rotation.identity(), model.initial_state()
    loaded = 0
    for i, stride in enumerate(np.geomspace(1e-6, 1e-2, 40)):
        forces = model.evaluate(scenes.poses(p, q.as_matrix()), scenes.velocities(), state)
        state = model.advance(state, 1e-3 * i, forces)
        for reach in (0.3, 1.0, 10.0):
            turn = Rotation.from_rotvec(10 * reach * stride * rng.normal(size=3))
            X_FB = scenes.poses(p + reach * stride * rng.normal(size=3), (turn * q).as_matrix())
            warm = model.evaluate(X_FB, scenes.velocities(), state)
            cold = model.evaluate(X_FB, scenes.velocities())
            assert warm.body_wrenches.tobytes() == cold.body_wrenches.tobytes()
            assert warm.contacts.key.tobytes() == cold.contacts.key.tobytes()
            assert warm.loaded.status.tobytes() == cold.loaded.status.tobytes()
            loaded += len(warm.loaded) > 0
        p = p + stride * rng.normal(size=3)
        q = Rotation.from_rotvec(5 * stride * rng.normal(size=3)) * q
    assert loaded > 40


HOVERING = {
    "mesh": CollisionMesh(*mesh_shapes.doughnut()),
    "sheet": CollisionMesh(*mesh_shapes.sheet(8, wave=0.02)),
    "box": CollisionMesh.from_primitive(Primitive("box", (0.2, 0.2, 0.1)), 0.02),
    "sphere": CollisionMesh.from_primitive(Primitive("sphere", (0.1,)), 0.02),
    "capsule": CollisionMesh.from_primitive(Primitive("capsule", (0.1, 0.1)), 0.02),
    "cylinder": CollisionMesh.from_primitive(Primitive("cylinder", (0.1, 0.1)), 0.02),
    "half space": CollisionMesh.from_primitive(Primitive("half_space", (1.0,)), 0.02),
}


@pytest.mark.parametrize("ground", HOVERING)
@pytest.mark.parametrize(
    "web", [AreaWeb(), AreaWeb(0.001, field="exact"), FacetWeb(0.001)], ids=str
)
def test_remembering_how_far_apart_bodies_are_changes_no_bit(web, ground):
    """A touch would be missed, or what bears nothing searched at every evaluation.

    Broken: a clearance too large by a third; the bulge of a primitive over its facets left out.
    """
    if ground == "sheet" and isinstance(web, AreaWeb):
        web = replace(web, standoff=0.001, sampled="a")
    body, below = CollisionMesh(*mesh_shapes.doughnut()), HOVERING[ground]
    model = scenes.model(body, below, NonlinearDamper(1e4), web=web)
    rng = np.random.default_rng(4)
    remembered = touched = 0
    for turn in (random_poses.random_rotation(rng) for _ in range(6)):
        # Where it just touches.
        high, low = 0.5, 0.0
        for _ in range(40):
            middle = (high + low) / 2
            bears = len(model.find(scenes.poses((0.0, 0.0, middle), turn)))
            high, low = (high, middle) if bears else (middle, low)
        for gap in np.geomspace(1e-6, 1e-2, 8):
            state = model.initial_state()
            for i, stride in enumerate((0.0, 1e-3 * gap, 1e-2 * gap)):
                X_FB = scenes.poses((stride, 0.0, high + gap), turn)
                forces = model.evaluate(X_FB, scenes.velocities(), state)
                state = model.advance(state, 1e-3 * i, forces)
            for reach in (0.1, 0.5, 0.9, 1.1, 1.5):
                X_FB = scenes.poses((stride, 0.0, high + (1 - reach) * gap), turn)
                warm = model.evaluate(X_FB, scenes.velocities(), state)
                cold = model.evaluate(X_FB, scenes.velocities())
                assert warm.body_wrenches.tobytes() == cold.body_wrenches.tobytes()
                assert warm.contacts.key.tobytes() == cold.contacts.key.tobytes()
                remembered += len(state.apart)
                touched += len(warm.loaded) > 0
    assert remembered > 20
    assert touched > 20


def test_remembering_the_last_step_changes_no_bit_at_an_edge():
    """Triangles passed over for what their parts tell, where the whole is above another field."""
    card = CollisionMesh(*box([0.002, 0.06, 0.09]))
    web = AreaWeb(resolution=0.03)
    model = scenes.model(card, card, NonlinearDamper(1e9), web=web)  # two lean on each other
    rng, state = np.random.default_rng(3), model.initial_state()
    lean = [Rotation.from_rotvec([0, np.radians(angle), 0]).as_matrix() for angle in (-20, 20)]

    def at(p):
        X_FB = scenes.poses(p, lean[1])
        X_FB[0, :3, :3], X_FB[0, :3, 3] = lean[0], [0.0163306, 0, 0.0426282]
        return X_FB

    p, loaded = np.array([-0.0163206, 0, 0.0426282]), 0
    for i in range(60):
        state = model.advance(state, 1e-3 * i, model.evaluate(at(p), scenes.velocities(), state))
        for reach in (1.0, 5.0, 25.0):
            X_FB = at(p + reach * 1e-6 * rng.normal(size=3))
            warm = model.evaluate(X_FB, scenes.velocities(), state)
            cold = model.evaluate(X_FB, scenes.velocities())
            assert warm.body_wrenches.tobytes() == cold.body_wrenches.tobytes()
            loaded += len(warm.loaded) > 0
        p[1:] += 2e-6 * rng.normal(size=2)
    assert loaded > 80


def test_remembering_the_last_step_changes_no_bit_where_an_edge_lies_across_a_face():
    """An edge between nodes bears load through none of them: it would be forgotten."""
    cube = CollisionMesh(*box([0.1, 0.1, 0.1]))
    web = AreaWeb(resolution=0.3, field="exact", sampled="a")
    model = scenes.model(cube, cube, NonlinearDamper(1e9), web=web)
    rng = np.random.default_rng(5)
    loaded = 0
    for turn in rng.uniform(-0.7, 0.7, size=40):
        on_edge = Rotation.from_euler("zx", [turn, np.pi / 4]).as_matrix()
        p = np.array([*rng.uniform(-0.01, 0.01, size=2), 0.05 * (1 + np.sqrt(2)) - 2e-5])
        state = model.initial_state()
        for i in range(4):
            forces = model.evaluate(scenes.poses(p, on_edge), scenes.velocities(), state)
            state = model.advance(state, 1e-3 * i, forces)
            for reach in (0.1, 3.0, 10.0):
                X_FB = scenes.poses(p + reach * 1e-6 * rng.normal(size=3), on_edge)
                warm = model.evaluate(X_FB, scenes.velocities(), state)
                cold = model.evaluate(X_FB, scenes.velocities())
                assert warm.body_wrenches.tobytes() == cold.body_wrenches.tobytes()
                assert warm.contacts.key.tobytes() == cold.contacts.key.tobytes()
                loaded += len(warm.loaded) > 0
            p += 1e-6 * rng.normal(size=3)
    assert loaded > 400


@pytest.mark.parametrize("mu", [0.0, 0.4])
def test_what_is_stored_lost_and_given_adds_up(mu):
    """A ledger that finds steps too long, or just right, where they are not."""
    damper, friction = NonlinearDamper(k=1e3, alpha=0.4), Friction(mu)
    model = scenes.facet_model(scenes.stool(TRIPOD), scenes.plane(), damper, friction=friction)
    X_FB, V_FB = scenes.poses((0.0, 0.0, 4e-4)), scenes.velocities((0.1, 0.2, -0.5), (1, 2, 3))
    forces = model.evaluate(X_FB, V_FB)
    assert_allclose(forces.power_given, (forces.body_wrenches * V_FB).sum(), rtol=1e-12)
    assert_allclose(forces.stored, forces.energies.sum(), rtol=1e-12)
    assert_array_equal(forces.V_FB, V_FB)
    state = model.advance(model.initial_state(), 0.0, forces)
    off = []
    for h in (1e-4, 1e-5):
        end = model.coast(state, h)
        after = model.advance(state, h, end)
        given = h / 2 * (state.forces.power_given + end.power_given)
        off.append(abs(end.stored - state.forces.stored + after.lost + given) / forces.stored)
    assert off[0] < 0.01
    assert off[1] < off[0] / 500


def test_coasting_goes_on_at_the_velocities_of_the_step():
    model, X_FB, V_FB = crowd()
    assert model.coast(model.initial_state(), 0.1) is None
    state = model.advance(model.initial_state(), 0.0, model.evaluate(X_FB, V_FB))
    moved = X_FB.copy()
    moved[:, :3, :3] = Rotation.from_rotvec(0.01 * V_FB[:, :3]).as_matrix() @ X_FB[:, :3, :3]
    moved[:, :3, 3] += 0.01 * V_FB[:, 3:]
    coasted, expected = model.coast(state, 0.01), model.evaluate(moved, V_FB, state)
    assert len(coasted.contacts) > 0
    assert_allclose(coasted.body_wrenches, expected.body_wrenches, rtol=1e-9, atol=1e-9)


def test_taking_a_step_twice_changes_nothing():
    model, X_FB, V_FB = crowd()
    state = model.advance(model.initial_state(), 0.5, model.evaluate(X_FB, V_FB))
    assert state.time == 0.5
    assert model.advance(state, 0.5, model.evaluate(X_FB, V_FB, state)) is state


def test_a_body_far_away_is_not_even_looked_at():
    model, X_FB, V_FB = crowd()
    X_FB[:, 0, 3] += 10.0 * np.arange(6)
    forces = model.evaluate(X_FB, V_FB)
    assert len(forces.loaded) == 0
    assert len(forces.loaded.pairs) == 0
    assert not forces.body_wrenches.any()


def test_bodies_without_geometries_or_pairs_feel_nothing():
    model = ContactModel(["a", "b"], [], [])
    forces = model.evaluate(np.tile(np.eye(4), (2, 1, 1)), np.zeros((2, 6)))
    assert_array_equal(forces.body_wrenches, np.zeros((2, 6)))
    assert isinstance(model.initial_state(), ContactState)


@pytest.mark.parametrize(
    ("make", "settings", "complaint"),
    [
        (FacetWeb, {"standoff": 0.0}, "the facet web needs a positive standoff, .*, not 0.0"),
        (FacetWeb, {"standoff": np.nan}, "the facet web needs a positive standoff, .*, not nan"),
        (
            FacetWeb,
            {"standoff": 0.1, "weighting": "heavy"},
            "weighting must be one of .*'unit'.*, not 'heavy'",
        ),
        (AreaWeb, {"standoff": -1.0}, "standoff must be finite and not negative, not -1.0"),
        (AreaWeb, {"standoff": np.inf}, "standoff must be finite"),
        (AreaWeb, {"field": "fuzzy"}, "field must be one of .*'smooth'.*, not 'fuzzy'"),
        (AreaWeb, {"resolution": -5}, "resolution must be .* between 1e-4 and 1, not -5"),
        (AreaWeb, {"resolution": np.nan}, "resolution must be .* between 1e-4 and 1, not nan"),
        (AreaWeb, {"sampled": "c"}, "sampled must be one of .*, not 'c'"),
        (AreaWeb, {"fillet": -1e-3}, "fillet must be finite and not negative, not -0.001"),
    ],
)
def test_impossible_webs_are_refused_when_made(make, settings, complaint):
    # A setting that makes no sense, or is another web's, must not wait for a model to be noticed.
    with pytest.raises(ValueError, match=complaint):
        make(**settings)
    with pytest.raises(TypeError, match="unexpected keyword argument"):
        make(1e-3, weights=1)


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"web": "area"}, r"pair 0 \('body', 'ground'\): web must be an AreaWeb, a FacetWeb or a"),
        ({"a": 2}, "pair 0 names geometry 2; there are 2"),
        ({"b": -1}, "pair 0 names geometry -1"),
        ({"b": 1}, "both are fixed to body 1; a body cannot touch itself"),
    ],
)
def test_impossible_pairs_are_named(changes, complaint):
    geometries = [
        ContactGeometry("ground", 0, scenes.plane()),
        ContactGeometry("body", 1, scenes.stool()),
    ]
    parameters = {"a": 1, "b": 0, "damper": NonlinearDamper(1.0), "web": FacetWeb(1e-3)}
    with pytest.raises(ValueError, match=complaint):
        ContactModel(["world", "body"], geometries, [ContactPair(**parameters | changes)])


def test_impossible_geometries_and_bodies_are_named():
    stool = scenes.stool()
    with pytest.raises(ValueError, match="geometry 'g' is fixed to 'wrold', which is none of"):
        ContactModel(["world"], [ContactGeometry("g", "wrold", stool)], [])
    with pytest.raises(ValueError, match="geometry 'g' is fixed to body 3; there are 1"):
        ContactModel(["world"], [ContactGeometry("g", 3, stool)], [])
    with pytest.raises(ValueError, match="X_BG of geometry 'g' is not a rigid transform"):
        ContactModel(["world"], [ContactGeometry("g", 0, stool, 2 * np.eye(4))], [])
    with pytest.raises(ValueError, match="body names must differ"):
        ContactModel(["world", "world"], [], [])
    with pytest.raises(ValueError, match="threads must be at least 1, not 0"):
        ContactModel(["world"], [], [], threads=0)


def test_poses_and_velocities_of_the_wrong_shape_or_value_are_named():
    model, X_FB, V_FB = crowd()
    springs = model.find(X_FB)
    with pytest.raises(ValueError, match=r"X_FB must have shape \(6, 4, 4\).* is \(5, 4, 4\)"):
        model.find(X_FB[:5])
    with pytest.raises(ValueError, match=r"V_FB must have shape \(6, 6\).* is \(36\)"):
        model.evaluate(X_FB, V_FB.ravel())
    X_FB[4, 1, 3] = np.nan
    with pytest.raises(ValueError, match="X_FB of body 4 is not finite"):
        model.find(X_FB)
    V_FB[2, 0] = np.inf
    with pytest.raises(ValueError, match="V_FB of body 2 is not finite"):
        model.forces(springs, V_FB)


def test_what_another_model_made_is_refused():
    # Its pairs and webs are others: read as one's own, they would end the process.
    model, X_FB, V_FB = crowd()
    other, _, _ = crowd(web=AreaWeb(0.01))
    springs, foreign = model.find(X_FB), other.find(X_FB)
    forces, foreign_forces = model.forces(springs, V_FB), other.forces(foreign, V_FB)
    start = model.initial_state()
    stepped = other.advance(other.initial_state(), 0.1, foreign_forces)
    with pytest.raises(ValueError, match="loaded springs must come from this ContactModel"):
        model.forces(foreign, V_FB)
    for advance in (model.advance, model.advance_implicitly):
        with pytest.raises(ValueError, match="forces must come from this ContactModel"):
            advance(start, 0.1, foreign_forces)
    for use in (
        lambda: model.find(X_FB, stepped),
        lambda: model.forces(springs, V_FB, stepped),
        lambda: model.evaluate(X_FB, V_FB, stepped),
        lambda: model.linearize(X_FB, V_FB, stepped),
        lambda: model.coast(stepped, 1e-3),
        lambda: model.advance(stepped, 0.2, forces),
        lambda: model.advance_implicitly(stepped, 0.2, forces),
    ):
        with pytest.raises(ValueError, match="state must come from this ContactModel"):
            use()
    assert model.coast(start, 1e-3) is None
