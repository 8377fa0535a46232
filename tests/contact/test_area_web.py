"""The area web's properties P1 to P8, on the web alone: no friction, no simulator.

Docstrings say what would be wrong, and what was broken on purpose to see the test fail.
"""

from concurrent.futures import ThreadPoolExecutor

import area_experiments as experiments
import mesh_shapes
import numpy as np
import pytest
from area_experiments import Web, pose
from scipy.spatial.transform import Rotation

from contact_toolkit import CollisionMesh, _core
from contact_toolkit.shapes.primitives import Primitive
from scenarios import parts

pytestmark = pytest.mark.engine

FIELDS = ("exact", "smooth")
BEYOND_CAPTURE, CROSSED = 1, 2


@pytest.fixture(scope="module", params=FIELDS)
def doughnut_on_cone(request) -> Web:
    return experiments.doughnut_on_cone(32, field=request.param)


@pytest.fixture(scope="module")
def smooth() -> Web:
    return experiments.doughnut_on_cone(32, field="smooth")


def test_p1_the_wrench_is_continuous(smooth):
    """Forces would jump (broken: triangles that are partly loaded left out)."""

    def path(s):
        return experiments.path_over_cone(0.11 + 0.02 * s)

    forces = experiments.forces_along(smooth, path, 800)
    coarse, fine = (experiments.largest_change(forces, stride) for stride in (4, 1))
    assert coarse < 2e-3
    assert fine < 0.3 * coarse


def test_p2_the_wrench_is_the_gradient_of_the_energy(doughnut_on_cone):
    """Motion would create energy (broken: gradient normalised)."""
    for s in (0.05, 0.3, 0.62):
        assert experiments.gradient_error(doughnut_on_cone, experiments.path_over_cone(s)) < 1e-7


@pytest.mark.parametrize(
    "options",
    [{"n": 1.5}, {"n": 2.0, "field": "exact"}, {"standoff": 1e-3}, {"sampled": "b"}],
    ids=str,
)
def test_p2_with_every_option(options):
    """An option's force would not belong to its energy (broken: energy not divided by n + 1)."""
    web = experiments.doughnut_on_cone(32, **options)
    assert experiments.gradient_error(web, experiments.path_over_cone(0.3)) < 1e-7


def test_p2_a_closed_tour_does_no_work(smooth):
    """The contact would pump energy (broken: gradient turned by 1 %)."""
    assert abs(experiments.closed_loop_work(smooth, experiments.path_over_cone, 1000)) < 1e-6


def test_p2_bouncing_keeps_its_energy(smooth):
    """Bounces would gain or lose energy without damping (broken: gradient turned by 1 %)."""
    drift, touch_downs = experiments.bouncing_drift(smooth, 1.6, tolerance=1e-6)
    assert touch_downs >= 5
    assert drift < 1e-4


def test_release_returns_the_energy_stored():
    """Bodies started overlapped would be shot out (broken: nodes above the surface left out)."""
    assert abs(experiments.release(field="smooth")) < 1e-7


@pytest.mark.parametrize("field", FIELDS)
def test_p3_facets_of_a_box_do_not_show(field):
    """The force would depend on the mesh (broken: triangles not weighed by area)."""
    forces = [experiments.box_on_plane(divisions, field=field) for divisions in (1, 2, 8)]
    assert forces == pytest.approx([500.5] * 3, rel=1e-9)  # 500 N and 0.1 % of the walls


@pytest.mark.parametrize("field", FIELDS)
def test_p3_nodes_finer_than_facets_stand_in_for_facets(field):
    """Coarse facets would need a finer mesh (broken: nodes at the facets' corners alone)."""
    truth = experiments.ball_on_ball(12, 1.1, cuts=3, field=field)
    for spacing, tolerance in ((0.53, 0.05), (0.25, 0.02)):
        force = experiments.ball_on_ball(12, spacing, field=field)
        assert force == pytest.approx(truth, rel=tolerance)


@pytest.mark.parametrize("field", FIELDS)
def test_p3_balls_meet_the_closed_form(field):
    """The force would not be π K R δ² (broken: loaded triangles counted 5 % too much)."""
    assert 0.96 < experiments.ball_on_ball(72, 0.25, field=field) < 1  # facets lie inside the balls


def test_p3_any_exponent():
    """Other n would integrate wrongly (broken: a weight of the rule)."""
    for n, tolerance in ((1.5, 0.003), (2.0, 0.003)):
        web = Web(parts.box(), parts.box(1, 1, 0.2), 1e9, n=n)
        force = web.wrench(pose([0.01, 0.007, -0.15 + 5e-5])).force[2]
        assert force == pytest.approx(1e9 * 0.01 * 5e-5**n, rel=tolerance)


@pytest.mark.parametrize("field", FIELDS)
def test_p4_no_ghost_forces(field):
    """A box would catch on a flat floor's facets (broken: coefficients in single precision)."""
    assert experiments.sideways(field=field) < 1e-12


@pytest.mark.parametrize("sampled", ["a", "b"])
@pytest.mark.parametrize("field", FIELDS)
def test_p4_teeth_in_gaps_are_not_in_the_material(field, sampled):
    """Gears would jam (broken: planes of a tooth's end and tip taken to go on over the gap)."""
    gears = [parts.involute_gear(teeth=teeth, backlash=1e-4, rows=2) for teeth in (16, 24)]
    web = Web(*gears, 1e10, field=field, sampled=sampled)
    for shafts, touches in ((0.0402, False), (0.0398, True)):
        X_AB = pose([shafts, 0, 0], Rotation.from_rotvec([0, 0, np.pi / 24]).as_matrix())
        assert (len(web.find(X_AB)["deformation"]) > 0) == touches


@pytest.mark.parametrize("field", FIELDS)
def test_p5_the_bodies_feel_opposite_wrenches(field):
    """Roles would change the answer (broken: the force's sign when B is sampled)."""
    doughnut = CollisionMesh(*mesh_shapes.doughnut())
    cone = CollisionMesh(*mesh_shapes.cone())
    X_AB = experiments.path_over_cone(0.3)
    X_BA = np.linalg.inv(X_AB)
    on_a = Web(doughnut, cone, 1e8, field=field, sampled="a").wrench(X_AB)
    on_b = Web(cone, doughnut, 1e8, field=field, sampled="b").wrench(X_BA)
    assert on_a.energy == pytest.approx(on_b.energy, rel=1e-12)
    scale = np.linalg.norm(on_a.force)
    assert np.abs(on_a.force + X_AB[:3, :3] @ on_b.force).max() < 1e-12 * scale
    moment = X_AB[:3, :3] @ on_b.moment + np.cross(X_AB[:3, 3], X_AB[:3, :3] @ on_b.force)
    assert np.abs(on_a.moment + moment).max() < 1e-12 * scale


@pytest.mark.parametrize("field", FIELDS)
def test_p6_a_block_is_pushed_back_out_of_a_thin_plate(field):
    """Past the plate's middle it would be pulled through (broken: the thicker body sampled)."""
    depths = np.linspace(0.1e-3, 5e-3, 25)
    forces = experiments.block_through_plate(depths, field=field)
    assert (np.diff(forces) > 0).all()
    assert forces[0] > 0


@pytest.mark.parametrize("field", FIELDS)
def test_p6_too_deep_is_told(field):
    """A node past the middle of the probed body would push on silently (broken: no status)."""
    web = Web(  # the plate probed against advice
        parts.box(0.04, 0.04, 0.04), parts.box(0.2, 0.2, 0.002), 1e9, field=field, sampled="a"
    )
    deepest = 1e-3 if field == "exact" else 1e-3 - 1.5 * web.native.cell
    assert web.native.capture_depth == pytest.approx(deepest, rel=0.03)
    assert web.find(pose([0, 0, -0.021 + 0.9 * deepest]))["status"] == 0
    assert web.find(pose([0, 0, -0.021 + 1e-3]))["status"] == BEYOND_CAPTURE


@pytest.mark.parametrize("field", FIELDS)
def test_p7_crossed_edges_bear_load(field):
    """Two edges would pass through each other (broken: no finer nodes along edges)."""
    web = Web(parts.box(), parts.box(), 1e9, field=field)
    rounding = 2 * 0.26 * web.native.cell  # of the smooth field's edge, seen along the normal
    for x, y in np.random.default_rng(0).uniform(-0.02, 0.02, (30, 2)):
        depths = np.array([0.25, 0.5, 1]) * web.native.spacing + rounding
        forces = [experiments.crossed_edges(web, depth, x, y).force for depth in depths]
        assert np.linalg.norm(forces[0]) > 0
        assert (np.diff(np.linalg.norm(forces, axis=1)) > 0).all()


@pytest.mark.parametrize("divisions", [1, 3])
def test_p7_fillets_meet_the_closed_form(divisions):
    """A fillet would bear a wrong load, or none on an edge cut in pieces (broken: none joined)."""
    r, K = 2e-3, 1e9
    web = Web(parts.box(divisions=divisions), parts.box(), K, resolution=0.005, fillet=r)
    for depth in np.array([0.1, 0.25, 0.5, 1.0]) * r:
        force = np.linalg.norm(experiments.crossed_edges(web, depth, 0.016, 0.002).force)
        assert force == pytest.approx(np.pi * K * r * depth**2 + 0.471 * K * depth**3, rel=0.01)
    deep = [experiments.crossed_edges(web, d * r, 0.016, 0.002).force for d in range(1, 9)]
    assert (np.diff(np.linalg.norm(deep, axis=1)) > 0).all()


@pytest.mark.parametrize("n", [1.0, 1.5])
def test_p7_fillets_are_conservative(n):
    """Crossing edges would create energy (broken: the windows' slopes left out)."""
    web = Web(parts.box(), parts.box(), 1e9, n=n, fillet=4e-3)
    fading = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        tilt = Rotation.from_rotvec(rng.normal(size=3) * 0.2).as_matrix()
        x, y = rng.uniform(-0.048, 0.048, 2)
        X_AB = experiments.crossed_edges_pose(rng.uniform(0.005, 0.015), x, y) @ pose(R=tilt)
        of_fillets = web.find(X_AB)["key"] >> np.uint64(63) == 1
        if of_fillets.sum() > 1:  # a force and a couple: some window is fading
            fading += 1
            assert experiments.gradient_error(web, X_AB) < 1e-6
    assert fading >= 5


def test_flat_faces_meet_without_fillets():
    """Fillets would push where edges do not cross (broken: no normal cones)."""
    X_AB = pose([0.02, 0.03, -0.1 + 1e-4], Rotation.from_rotvec([0, 0, 0.4]).as_matrix())
    with_, without = (Web(parts.box(), parts.box(), 1e9, fillet=f).wrench(X_AB) for f in (2e-3, 0))
    assert (with_.force == without.force).all()


@pytest.mark.parametrize("field", FIELDS)
def test_p8_an_open_sheet_holds_from_either_side(field):
    """A terrain without inside would not bear load, or from one side only (broken: sign kept)."""
    sheet = mesh_shapes.sheet(10, wave=0.0)
    web = Web(parts.box(), sheet, 1e8, standoff=2e-3, field=field, sampled="a")
    assert web.native.samples_a
    gap = 1.5e-3
    above = web.wrench(pose([0.01, 0.02, -0.05 - gap]))
    assert above.force == pytest.approx([0, 0, 1e8 * 0.01 * (2e-3 - gap)], rel=0.03, abs=1e-6)
    below = web.wrench(pose([0.01, 0.02, 0.05 + gap]))
    assert below.force == pytest.approx(-above.force, rel=1e-6)
    assert above.rows["status"] == below.rows["status"] == 0


@pytest.mark.parametrize("field", FIELDS)
def test_p8_passing_an_open_sheet_is_told(field):
    """A body pushed through a sheet would go unnoticed (broken: sides not compared)."""
    sheet = mesh_shapes.sheet(10, wave=0.0)
    web = Web(parts.box(), sheet, 1e8, standoff=2e-3, field=field, sampled="a")
    for depth in (1e-4, 1e-3, 2e-2):
        assert web.find(pose([0.01, 0.02, -0.05 + depth]))["status"] == CROSSED
    beside = web.find(pose([0.5, 0.02, -0.001]))  # about the rim: no side there
    assert len(beside["key"]) > 0


def test_nodes_carry_the_whole_area():
    """Area would be lost or counted twice where patches meet (broken: a triangle left out)."""
    for surface in (parts.box(0.1, 0.07, 0.03), parts.doughnut(), parts.icosphere(0.05, 3)):
        mesh = CollisionMesh(*surface)
        for around in (
            CollisionMesh.from_primitive(Primitive("sphere", (1.0,))),
            CollisionMesh(*parts.box(1, 1, 1)),
        ):
            inside = Web(mesh, around, 1.0, sampled="a", field="exact").find(pose())
            further_side = (inside["key"] >> np.uint64(31) & np.uint64(1)).astype(bool)
            share = inside["stiffness"][~further_side].sum()
            assert share == pytest.approx(mesh.area, rel=1e-12)
            assert len(np.unique(inside["key"])) == len(inside["key"])


def test_the_smaller_or_much_thinner_body_is_sampled():
    """The wrong body would carry the nodes (broken: the other one chosen)."""
    plate, ball, sheet = parts.box(0.2, 0.2, 0.002), parts.icosphere(0.05, 8), mesh_shapes.sheet()
    plate_as_thick = parts.box(1, 1, 0.04)
    cube, cut_cube = parts.box(), parts.box(divisions=3)
    options = {"stiffness": 1e8, "standoff": 1e-3}
    for A, B, samples_a in [
        (plate, ball, True), (ball, plate, False),
        (ball, plate_as_thick, True), (plate_as_thick, ball, False),
        (ball, sheet, False), (sheet, ball, True),
        (cube, cut_cube, False), (cut_cube, cube, True), (cube, cube, True),
    ]:  # fmt: skip
        assert Web(A, B, **options).native.samples_a == samples_a


def test_thickness():
    """Twice the radius of the largest ball inside would be wrong (broken: nothing grown)."""
    plate, faces = parts.box(0.2, 0.3, 0.002)
    askew = Rotation.from_rotvec([0.3, -0.5, 0.7]).as_matrix()
    (outer, f), (inner, g) = parts.icosphere(0.05, 24), parts.icosphere(0.0485, 24)
    shell = np.vstack([outer, inner]), np.vstack([f, g[:, ::-1] + len(outer)])
    for surface, thickness in [
        (shell, 0.0015),
        ((plate @ askew.T, faces), 0.002),
        (parts.box(0.1, 0.2, 0.03), 0.03),
        (parts.doughnut(major_sections=128, minor_sections=64), 0.04),
        (parts.icosphere(0.05, 16), 0.1),
        (mesh_shapes.sheet(), 0.0),
    ]:
        found = _core.AreaBody(CollisionMesh(*surface)._solid).thickness
        assert 0.985 * thickness <= found <= thickness * (1 + 1e-12)


@pytest.mark.parametrize("field", FIELDS)
@pytest.mark.threads
def test_the_past_and_other_threads_leave_no_trace(field):
    """Results would depend on what was asked before (broken: the table's tags cut short)."""
    poses = [experiments.path_over_cone(s) for s in np.linspace(0, 1, 24)]
    web = experiments.doughnut_on_cone(32, field=field)
    forwards = [web.find(X) for X in poses]
    backwards = [web.find(X) for X in reversed(poses)][::-1]
    shared = experiments.doughnut_on_cone(32, field=field)
    with ThreadPoolExecutor(4) as pool:
        threaded = list(pool.map(shared.find, poses))
    for one, two, three in zip(forwards, backwards, threaded, strict=True):
        for name in ("key", "elastic", "deformation", "gradient_A", "p_ACb"):
            assert (one[name] == two[name]).all()
            assert (one[name] == three[name]).all()


@pytest.mark.parametrize("field", FIELDS)
def test_hostile_pairs_stay_finite(field):
    """Odd scales, places or meshes would give no number."""
    (v, f), (pea, g) = parts.box(), parts.icosphere(0.005, 4)
    repeated = (v, np.vstack([f, f[:1]]))
    folded = (np.vstack([v, [v[f[0]].mean(axis=0)]]), np.vstack([f, [[f[0][0], f[0][1], 8]]]))
    on_top, far = np.array([0.01, 0.02, -0.1 + 1e-4]), np.array([1e4, -2e4, 3e4])
    for A, B, p, options in [
        ((v * 1e-6, f), (v * 1e-6, f), on_top * 1e-6, {}),
        ((v * 1e6, f), (v * 1e6, f), on_top * 1e6, {}),
        ((v, f), (v + far, f), on_top - far, {}),
        ((v, f), (v, f), [0, 0, 0], {}),
        ((v, f), (v / 8, f), [0, 0, 0], {}),
        ((v, f), (v, f), on_top, {"stiffness": 1e12}),
        ((v, f), (v, f), on_top, {"stiffness": 1}),
        ((pea, g), (v * [100, 100, 0.04], f), [0, 0, -0.0069], {}),
        (repeated, (v, f), on_top, {"standoff": 1e-3}),
        (folded, (v, f), on_top, {"standoff": 1e-3}),
        (mesh_shapes.soup(40), (v, f), [0, 0, 0.2], {"standoff": 1e-3}),
        (mesh_shapes.sheet(4), mesh_shapes.sheet(4), [0, 0, 1e-3], {"standoff": 4e-3}),
    ]:
        web = Web(A, B, **({"stiffness": 1e8, "resolution": 0.08, "field": field} | options))
        found = web.wrench(pose(p))
        assert np.isfinite(found.force).all()
        assert np.isfinite(found.moment).all()
        assert 0 <= found.energy < np.inf


def test_far_bodies_cost_nothing_and_touch_nothing():
    """Bodies apart would be probed (broken: the box test turned around)."""
    web = experiments.doughnut_on_cone(32)
    for p in ([0, 0, 5], [1e6, 0, 0], [0, 0, -1e15]):
        rows = web.find(pose(p))
        assert len(rows["key"]) == rows["probed"] == 0


def test_errors_name_the_mend():
    """A pair that cannot work would be built (broken: no check)."""
    box, sheet = parts.box(), mesh_shapes.sheet()
    inside_out = (box[0], box[1][:, ::-1])
    for A, B, options, message in [
        (box, box, {"stiffness": -1}, "stiffness must be positive"),
        (box, box, {"stiffness": np.nan}, "stiffness must be positive"),
        (box, box, {"n": 0.5}, "exponent n must be"),
        (box, box, {"standoff": -1e-3}, "standoff must not be negative"),
        (box, box, {"fillet": -1e-3}, "fillet must not be negative"),
        (box, box, {"resolution": 1e-5}, "resolution must be"),
        (box, sheet, {"sampled": "a"}, "no inside.*give the pair a standoff"),
        (sheet, sheet, {}, "no inside.*give the pair a standoff"),
        (box, inside_out, {"sampled": "a"}, "no inside"),
    ]:
        with pytest.raises(ValueError, match=message):
            Web(A, B, **({"stiffness": 1e8} | options))
