"""Distance and collision over a motion.

Translations are judged by the prisms that facets sweep, in extended precision; rotations by dense
sampling of the static query, which can only prove a lower bound too high.
"""

import pickle

import mesh_shapes
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracle_prisms import swept_by_prisms
from poses import pose, random_pose, random_rotation
from scipy.spatial.transform import Rotation, Slerp

from contact_toolkit import (
    CollisionMesh,
    ConvexPieces,
    ImpactStatus,
    _core,
    distance,
    intersects,
    swept_distance,
    swept_distance_batch,
    swept_intersects,
    swept_intersects_batch,
    time_of_impact,
    time_of_impact_batch,
)

pytestmark = pytest.mark.engine

rngs = st.integers(0, 2**32 - 1).map(np.random.default_rng)
_MESHES = {
    "doughnut": CollisionMesh(*mesh_shapes.doughnut(10, 6, major=0.5, minor=0.2)),
    "cone": CollisionMesh(*mesh_shapes.cone(10, 2, bottom=0.5, top=0.2, height=1.0)),
    "cube": CollisionMesh(*mesh_shapes.cube()),
    "sheet": CollisionMesh(*mesh_shapes.sheet(5)),
    "soup": CollisionMesh(*mesh_shapes.soup(40)),
    "sliver": CollisionMesh(*mesh_shapes.sliver(width=1e-5)),
}
names = st.sampled_from(sorted(_MESHES))


def _interpolate(X0, X1, s):
    turn = Slerp([0, 1], Rotation.from_matrix([X0[:3, :3], X1[:3, :3]]))
    return pose(turn(s).as_matrix(), (1 - s) * X0[:3, 3] + s * X1[:3, 3])


def _random_motion(rng, *, turn, way=1.5):
    X0 = random_pose(rng, 1.5)
    X1 = X0.copy()
    X1[:3, 3] += rng.normal(size=3) * rng.choice([0.01, 0.3, way])
    angle = rng.normal(size=3) * turn
    X1[:3, :3] = Rotation.from_rotvec(angle).as_matrix() @ X0[:3, :3]
    return X0, X1


@settings(max_examples=25)
@given(names, names, rngs)
def test_translation_is_exact(name_a, name_b, rng):
    """A least distance over a translation that is not the brute-force one."""
    A, B = _MESHES[name_a], _MESHES[name_b]
    X0, X1 = _random_motion(rng, turn=0)
    found = swept_distance(A, B, X0, X1)
    truth = swept_by_prisms(A, B, X0, X1)
    assert found.error == 0
    assert found.converged
    assert abs(found.distance - truth) < 1e-13
    at = distance(A, B, _interpolate(X0, X1, found.time))
    assert abs(at.distance - truth) < 1e-12
    assert abs(np.linalg.norm(found.p_ACa - found.p_ACb) - truth) < 1e-13


@pytest.mark.parametrize("name_b", sorted(_MESHES))
@pytest.mark.parametrize("name_a", sorted(_MESHES))
def test_no_pair_of_facets_is_overlooked(name_a, name_b):
    """A pair that is put off because another seems closer, and then forgotten: one in seventy."""
    A, B = _MESHES[name_a], _MESHES[name_b]
    for seed in range(10):
        X0, X1 = _random_motion(np.random.default_rng(seed), turn=0)
        found = swept_distance(A, B, X0, X1).distance
        assert abs(found - swept_by_prisms(A, B, X0, X1)) < 1e-13


@given(names, names, rngs, st.sampled_from([1e-3, 0.3, 1.5]))
def test_rotation_is_certified(name_a, name_b, rng, turn):
    """A lower bound above a distance that does occur, or an error above the tolerance."""
    A, B = _MESHES[name_a], _MESHES[name_b]
    X0, X1 = _random_motion(rng, turn=turn)
    tolerance = 10 ** rng.uniform(-6, -2)
    found = swept_distance(A, B, X0, X1, tolerance=tolerance)
    samples = [distance(A, B, _interpolate(X0, X1, s)).distance for s in np.linspace(0, 1, 41)]
    assert found.distance <= min(samples) + 1e-12
    assert found.converged
    assert found.error <= tolerance * (1 + 1e-9)
    at = distance(A, B, _interpolate(X0, X1, found.time)).distance
    assert found.distance - 1e-12 <= at <= found.distance + found.error + 1e-12
    gap = np.linalg.norm(found.p_ACa - found.p_ACb)
    assert abs(gap - found.distance - found.error) < 1e-12


@given(names, names, rngs, st.sampled_from([0, 1e-3, 0.3, 1.5]), st.sampled_from([0.0, 0.1]))
def test_impact_is_never_late(name_a, name_b, rng, turn, separation):
    """A collision missed or reported late; or a report too early."""
    A, B = _MESHES[name_a], _MESHES[name_b]
    X0, X1 = _random_motion(rng, turn=turn)
    tolerance = 1e-5
    found = time_of_impact(A, B, X0, X1, separation=separation, tolerance=tolerance)
    times = np.linspace(0, 1, 41)
    samples = np.array([distance(A, B, _interpolate(X0, X1, s)).distance for s in times])
    assert found.status != ImpactStatus.ITERATION_LIMIT
    assert (samples[times < found.time] > separation - 1e-12).all()
    if found.status == ImpactStatus.FREE:
        assert found.time == 1
        assert samples.min() > separation - 1e-12
    else:
        at = distance(A, B, _interpolate(X0, X1, found.time)).distance
        assert at <= found.distance + 1e-12
        assert found.distance <= separation + tolerance + 1e-12
        assert (found.status == ImpactStatus.INITIAL_CONTACT) == (found.time == 0)
    if separation == 0:
        touches = swept_intersects(A, B, X0, X1, tolerance=tolerance)
        assert touches or samples.min() > 0
        assert touches == (found.status != ImpactStatus.FREE) or turn == 0


@given(names, names, rngs)
def test_no_motion_is_the_static_query(name_a, name_b, rng):
    """Two answers to one question."""
    A, B = _MESHES[name_a], _MESHES[name_b]
    X = random_pose(rng, 1.5)
    static = distance(A, B, X)
    swept = swept_distance(A, B, X, X)
    assert (swept.distance, swept.error, swept.time) == (static.distance, 0, 0)
    assert (swept.p_ACa == static.p_ACa).all()
    assert (swept.p_ACb == static.p_ACb).all()
    assert swept_intersects(A, B, X, X) == intersects(A, B, X)
    impact = time_of_impact(A, B, X, X)
    assert (impact.status == ImpactStatus.FREE) == (static.distance > 0)


@given(names, names, rngs)
def test_swapping_and_reversing(name_a, name_b, rng):
    """An answer that depends on who moves, or on the direction of time."""
    A, B = _MESHES[name_a], _MESHES[name_b]
    X0, X1 = _random_motion(rng, turn=0)
    forth = swept_distance(A, B, X0, X1).distance
    assert abs(swept_distance(A, B, X1, X0).distance - forth) < 1e-13
    R = X0[:3, :3]  # seen from B: the same translation, turned round
    Y0, Y1 = (pose(R.T, tuple(-R.T @ X[:3, 3])) for X in (X0, X1))
    assert abs(swept_distance(B, A, Y0, Y1).distance - forth) < 1e-12


def _plate(thickness):
    vertices, faces = mesh_shapes.cube()
    return CollisionMesh(vertices * [1, 1, thickness], faces)


@pytest.mark.parametrize("spin", [0.0, 3.0])
@pytest.mark.parametrize("thickness", [1e-3, 1e-6])
def test_bullet_through_a_plate(thickness, spin):
    """A body that is on the other side at the next step, seen on neither side."""
    plate = _plate(thickness)
    bullet = CollisionMesh(*mesh_shapes.cube(0.01))
    rng = np.random.default_rng(0)
    for _ in range(20):
        X0 = pose(random_rotation(rng), (*rng.uniform(-0.4, 0.4, 2), rng.uniform(0.1, 50)))
        X1 = pose(random_rotation(rng), (*rng.uniform(-0.4, 0.4, 2), -rng.uniform(0.1, 50)))
        if spin == 0:
            X1[:3, :3] = X0[:3, :3]
        assert not intersects(plate, bullet, X0)
        assert not intersects(plate, bullet, X1)
        assert swept_intersects(plate, bullet, X0, X1)
        assert swept_distance(plate, bullet, X0, X1).distance == 0
        found = time_of_impact(plate, bullet, X0, X1)
        assert found.status == ImpactStatus.IMPACT
        at = _interpolate(X0, X1, found.time)
        low = (at[2, :3] @ bullet.vertices.T).min() + at[2, 3]
        assert low == pytest.approx(thickness / 2, abs=1e-6)


def test_impact_time_of_a_falling_cube():
    """A time that is off by more than the tolerance where the truth is plain."""
    A, B = _MESHES["cube"], CollisionMesh(*mesh_shapes.cube())
    found = time_of_impact(A, B, pose(p=(0.2, 0.1, 3)), pose(p=(0.2, 0.1, 1)), separation=0.5)
    assert found.time == pytest.approx(0.75, abs=1e-6)
    assert found.distance == pytest.approx(0.5, abs=2e-6)
    np.testing.assert_allclose(found.normal_A, [0, 0, -1], atol=1e-9)


def test_swinging_rod_meets_a_wall():
    """A rotation whose ends say nothing: the closed form of a rod's tip."""
    rod = CollisionMesh([[0, 0, 0], [2, 0, 0], [0, 0, 1e-3]], [[0, 1, 2]])
    wall = CollisionMesh([[1.5, -3, -3], [1.5, 3, -3], [1.5, 0, 5]], [[0, 1, 2]])
    X0, X1 = (pose(Rotation.from_euler("z", a).as_matrix()) for a in (-1.5, 1.4))
    found = time_of_impact(wall, rod, X0, X1, tolerance=1e-9)
    assert found.time == pytest.approx((1.5 - np.arccos(0.75)) / 2.9, abs=1e-8)
    nearest = swept_distance(wall, rod, X0, pose(Rotation.from_euler("z", -1.0).as_matrix()))
    assert nearest.distance == pytest.approx(1.5 - 2 * np.cos(1.0), abs=1e-5)
    assert nearest.time == pytest.approx(1, abs=1e-5)


def test_grazing_rotation_ends():
    """A disc's rim sliding along a wall for the whole motion: no endless advancement."""
    u = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    rim = np.stack([np.cos(u), np.sin(u), 0 * u], axis=1)
    faces = [[0, i, i + 1] for i in range(1, 199)]
    disc = CollisionMesh(rim, faces)
    X1 = pose(Rotation.from_euler("z", 3).as_matrix())
    for gap in (0, 1e-12, 1e-6):
        x = 1 + gap
        wall = CollisionMesh([[x, -3, -3], [x, 3, -3], [x, 0, 5]], [[0, 1, 2]])
        found = time_of_impact(wall, disc, pose(), X1, tolerance=1e-6)
        assert found.status in (ImpactStatus.IMPACT, ImpactStatus.INITIAL_CONTACT)
        nearest = swept_distance(wall, disc, pose(), X1, tolerance=1e-6)
        assert nearest.distance <= gap
        assert nearest.error <= 1e-6


def test_answers_are_pickled():
    """An answer that is lost on its way from another process."""
    found = swept_distance(_MESHES["cube"], _MESHES["sheet"], pose(p=(0, 0, 2)), pose(p=(1, 0, 1)))
    again = pickle.loads(pickle.dumps(found))
    assert repr(again) == repr(found)
    assert again.distance == found.distance > 0


def test_upper_bound():
    """An answer below the bound changed by it, or one above it invented."""
    A, B = _MESHES["doughnut"], _MESHES["cone"]
    for turn in (0.0, 0.2):
        X0 = pose(p=(0, 0, 1.5))
        X1 = pose(Rotation.from_rotvec([turn, 0, 0]).as_matrix(), (0.3, 0, 1.6))
        free = swept_distance(A, B, X0, X1, tolerance=1e-5)
        assert free.distance > 0
        for share in (2, 1 + 1e-7):
            bounded = swept_distance(
                A, B, X0, X1, tolerance=1e-5, upper_bound=share * (free.distance + free.error)
            )
            assert bounded.distance == pytest.approx(free.distance, abs=1e-5)
        below = swept_distance(A, B, X0, X1, upper_bound=0.5 * free.distance)
        assert below.distance == np.inf


@pytest.mark.parametrize("offset", [0.0, 1e6])
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_scale_and_offset(scale, offset):
    """Tolerances that are lengths in disguise."""
    shapes = [mesh_shapes.doughnut(10, 6, major=0.5, minor=0.2), mesh_shapes.cube(0.3)]
    A, B = (CollisionMesh(v * scale + [scale * offset, 0, 0], f) for v, f in shapes)
    X0, X1 = pose(p=(-1.5 * scale, 0, 0)), pose(p=(1.5 * scale, 0, 0.2 * scale))
    rounding = 1e-9 * max(offset / 1e3, 1) * scale
    found = time_of_impact(A, B, X0, X1)
    assert found.status == ImpactStatus.IMPACT
    # The tube's outermost vertex is at 0.7, the cube's half width 0.15.
    assert found.time == pytest.approx((1.5 - 0.85) / 3, abs=1e-3)
    high = pose(p=(-1.5 * scale, 0, scale)), pose(p=(1.5 * scale, 0, scale))
    top = swept_distance(A, B, *high).distance
    assert top == pytest.approx(scale * (0.85 - 0.2 * np.sin(np.pi / 3)), abs=rounding)


@pytest.mark.parametrize("far", [0.0, 1e6])
def test_facets_are_pieces(far):
    """Pieces culled by what is known of facets only, or all of them measured far away."""
    meshes = [_MESHES[name] for name in ("doughnut", "soup")]
    pieces = [ConvexPieces(list(mesh.vertices[mesh.faces])) for mesh in meshes]
    for seed in range(20):
        X0, X1 = _random_motion(np.random.default_rng(seed), turn=0)
        X0[0, 3] += far
        X1[0, 3] += far
        of_facets = swept_distance(*meshes, X0, X1)
        of_pieces = swept_distance(*pieces, X0, X1)
        assert of_pieces.distance == pytest.approx(of_facets.distance, abs=1e-13 + 1e-15 * far)
        assert of_pieces.converged


@pytest.mark.parametrize("far", [1e3, 1e6])
def test_far_apart(far):
    """Shapes so far apart that single precision tells none of their facets from another."""
    A, B = (CollisionMesh(*mesh_shapes.doughnut(60, 40, major=0.5, minor=0.2)) for _ in range(2))
    X0, X1 = pose(p=(far, 0.3, 0.1)), pose(p=(far, -0.2, 0.3))
    assert swept_distance(A, B, X0, X1).distance == pytest.approx(far - 1.4, rel=1e-6)
    X1[:3, :3] = Rotation.from_rotvec([0.1, 0.2, 0.3]).as_matrix()
    turning = swept_distance(A, B, X0, X1, tolerance=1e-4)
    assert turning.converged
    assert turning.distance == pytest.approx(far - 1.4, rel=1e-5, abs=1e-2)
    assert time_of_impact(A, B, X0, X1).status == ImpactStatus.FREE


def test_sliding_between_walls():
    """A gap that is everywhere the same, and so of thousands of facets, is lost among them."""
    channel, slider = (mesh_shapes.cube() for _ in range(2))
    for _ in range(3):
        channel, slider = (mesh_shapes.subdivided(*shape) for shape in (channel, slider))
    A = CollisionMesh(channel[0] * [1, 1, 8], channel[1])
    R = Rotation.from_rotvec([0.4, 0.8, -0.5]).as_matrix()  # B's frame, askew to its faces
    B = CollisionMesh(slider[0] * 0.9 @ R, slider[1])
    for offset in (0.0, 0.01):
        X0, X1 = pose(R, (offset, 0, -2.02)), pose(R, (offset, 0, 1.03))
        found = swept_distance(A, B, X0, X1)
        assert found.distance == pytest.approx(0.05 - offset, abs=1e-15)
        assert found.converged


def test_degenerate_facets():
    """Zero-area and duplicate facets are still points and edges to run into."""
    needle = CollisionMesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2], [0, 1, 2]])
    cube = _MESHES["cube"]
    X0, X1 = pose(p=(-0.2, 0.1, 3)), pose(p=(-0.2, 0.1, -3))
    assert swept_intersects(cube, needle, X0, X1)
    assert swept_distance(cube, needle, X0, X1).distance == 0
    assert time_of_impact(cube, needle, X0, X1).time == pytest.approx(2.5 / 6, abs=1e-6)
    beside = pose(p=(0.7, 0.1, 3)), pose(p=(0.7, 0.1, -3))
    assert swept_distance(cube, needle, *beside).distance == pytest.approx(0.2, abs=1e-15)


@pytest.mark.threads
@pytest.mark.parametrize("pieces", [False, True], ids=["meshes", "pieces"])
def test_batches_equal_single_queries(pieces):
    """Rows mixed up or answers changed by sharing them between threads."""
    A, B = _MESHES["doughnut"], _MESHES["soup"]
    if pieces:
        A, B = (ConvexPieces(list(mesh.vertices[mesh.faces])) for mesh in (A, B))
    rng = np.random.default_rng(1)
    motions = [_random_motion(rng, turn=rng.choice([0, 0.3])) for _ in range(30)]
    start, end = (np.array(poses) for poses in zip(*motions, strict=True))
    for threads in (1, 2, 8):
        distances = swept_distance_batch(A, B, start, end, threads=threads)
        impacts = time_of_impact_batch(A, B, start, end, threads=threads)
        touches = swept_intersects_batch(A, B, start, end, threads=threads)
        for i, motion in enumerate(motions):
            one = swept_distance(A, B, *motion)
            assert (distances.distance[i], distances.time[i]) == (one.distance, one.time)
            assert (distances.p_ACa[i] == one.p_ACa).all()
            hit = time_of_impact(A, B, *motion)
            assert (impacts.time[i], impacts.status[i]) == (hit.time, hit.status)
            assert touches[i] == swept_intersects(A, B, *motion)


def test_bad_arguments_are_named():
    """An error that does not say which argument is wrong."""
    A = B = _MESHES["cube"]
    X = pose()
    with pytest.raises(ValueError, match="X_AB_end"):
        swept_distance(A, B, X, np.ones((4, 4)))
    with pytest.raises(ValueError, match="tolerance"):
        swept_distance(A, B, X, X, tolerance=0)
    with pytest.raises(ValueError, match="separation"):
        time_of_impact(A, B, X, X, separation=-1)
    with pytest.raises(ValueError, match=r"X_AB_start\[1\]"):
        swept_distance_batch(A, B, [X, 2 * X], [X, X])
    with pytest.raises(ValueError, match="as many end poses"):
        swept_distance_batch(A, B, [X, X], [X])
    with pytest.raises(ValueError, match="threads"):
        swept_distance_batch(A, B, [X], [X], threads=0)


def test_same_bits_on_every_instruction_set():
    """Culling that depends on the width of the vectors."""
    A, B = _MESHES["doughnut"], _MESHES["soup"]
    rng = np.random.default_rng(2)
    motions = [_random_motion(rng, turn=rng.choice([0, 0.3])) for _ in range(40)]
    start, end = (np.array(poses) for poses in zip(*motions, strict=True))
    chosen = _core.simd()
    answers = []
    for name in ("scalar", "vector", "avx2", "avx512"):
        try:
            _core.select_simd(name)
        except ValueError:
            continue  # not on this processor
        found = swept_distance_batch(A, B, start, end), time_of_impact_batch(A, B, start, end)
        answers.append(b"".join(column.tobytes() for f in found for column in vars(f).values()))
    _core.select_simd(chosen)
    assert len(set(answers)) == 1
