"""WitnessCache: along any motion, the rows of the cold query, bit for bit."""

import mesh_shapes
import numpy as np
import pytest
from poses import pose, random_pose, random_rotation
from scipy.spatial.transform import Rotation

from benchmarks.mesh_pairs import peg_in_hole
from contact_toolkit import CollisionMesh, WitnessCache, _core, witness_pairs

pytestmark = pytest.mark.engine

SHAPE_PAIRS = {
    "doughnut-cone": (mesh_shapes.doughnut(), mesh_shapes.cone()),
    "cube-ball": (mesh_shapes.cube(0.1), mesh_shapes.ball(2, radius=0.05, bumps=0.2)),
    "soup-sheet": (mesh_shapes.soup(80), mesh_shapes.sheet()),
    "sliver-sliver": (mesh_shapes.sliver(), mesh_shapes.sliver(width=1e-6)),
}


def _same(cached, cold):
    for name, column in cold.columns().items():
        found = getattr(cached, name)
        np.testing.assert_array_equal(found, column, err_msg=name)
        assert found.tobytes() == column.tobytes(), f"{name}: zeros of unlike sign"


def _stepped(X_AB, rng, *, turn, shift):
    """The pose after a random small turn [rad] about any axis and shift [m]."""
    step = Rotation.from_rotvec(turn * rng.normal(size=3)).as_matrix()
    return pose(step @ X_AB[:3, :3], tuple(X_AB[:3, 3] + shift * rng.normal(size=3)))


@pytest.mark.parametrize("merge", [True, False])
@pytest.mark.parametrize("shapes", SHAPE_PAIRS.values(), ids=SHAPE_PAIRS)
def test_random_walk(shapes, merge):
    """A candidate dropped too early, or kept in another order."""
    A, B = (CollisionMesh(*shape) for shape in shapes)
    rng = np.random.default_rng(0)
    cache = WitnessCache(A, B)
    rows = steps = 0
    for _ in range(6):
        X_AB = random_pose(rng, 0.4 * (A.diagonal + B.diagonal))
        standoff = 0.05 * A.diagonal
        for _ in range(40):
            X_AB = _stepped(X_AB, rng, turn=1e-3, shift=1e-3 * A.diagonal)
            cached = cache.witness_pairs(X_AB, standoff, merge=merge)
            _same(cached, witness_pairs(A, B, X_AB, standoff, merge=merge))
            rows, steps = rows + len(cached), steps + 1
    assert rows > 100
    assert 6 <= cache.gathered < steps


@pytest.mark.parametrize("slack", [1e-9, 1e-4, 1e-2, 1e3])
def test_any_slack(slack):
    """Slack decides how often facet pairs are gathered, and nothing else; too little is no use."""
    A, B = (CollisionMesh(*shape) for shape in SHAPE_PAIRS["doughnut-cone"])
    rng = np.random.default_rng(1)
    cache = WitnessCache(A, B, slack=slack)
    X_AB = pose(p=(0, 0, -0.17))
    for _ in range(60):
        X_AB = _stepped(X_AB, rng, turn=1e-3, shift=1e-4)
        _same(cache.witness_pairs(X_AB, 0.005), witness_pairs(A, B, X_AB, 0.005))
    expected = {1e-9: 0, 1e3: 1}
    assert cache.gathered == expected.get(slack, cache.gathered)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_turning_in_place(axis):
    """Rotation alone moves the far ends of a body: its size counts, not its origin."""
    A, B = (CollisionMesh(*shape) for shape in SHAPE_PAIRS["doughnut-cone"])
    cache = WitnessCache(A, B)
    for angle in np.linspace(0, 0.1, 150):
        R = Rotation.from_rotvec(angle * np.eye(3)[axis]).as_matrix()
        X_AB = pose(R, (0.01, 0, 0))
        _same(cache.witness_pairs(X_AB, 0.004), witness_pairs(A, B, X_AB, 0.004))
    assert cache.gathered > 1


def test_creeping_away_from_where_it_gathered():
    """Steps each far below the slack must add up."""
    A = CollisionMesh(*mesh_shapes.cube())
    cache = WitnessCache(A, A, slack=0.01)
    for z in np.linspace(1.2, 0.9, 400):
        X_AB = pose(p=(0.3, 0.2, z))
        _same(cache.witness_pairs(X_AB, 0.05), witness_pairs(A, A, X_AB, 0.05))
    assert 400 > cache.gathered >= 15


def test_there_and_back():
    """A body that returns to where it was has not moved."""
    A, B = (CollisionMesh(*shape) for shape in SHAPE_PAIRS["cube-ball"])
    X_AB = pose(p=(0, 0, 0.1))
    cache = WitnessCache(A, B)
    for _ in range(20):
        for shift in (0, 1e-4):
            X = pose(p=tuple(X_AB[:3, 3] + [0, shift, 0]))
            _same(cache.witness_pairs(X, 0.02), witness_pairs(A, B, X, 0.02))
    assert cache.gathered == 1


def test_jumps():
    """A pose that has nothing to do with the last one."""
    A, B = (CollisionMesh(*shape) for shape in SHAPE_PAIRS["cube-ball"])
    rng = np.random.default_rng(2)
    cache = WitnessCache(A, B)
    for _ in range(60):
        X_AB = pose(random_rotation(rng), tuple(rng.uniform(-0.1, 0.1, 3)))
        _same(cache.witness_pairs(X_AB, 0.01), witness_pairs(A, B, X_AB, 0.01))


def test_changing_standoff():
    """What was gathered for a small standoff does not serve a larger one."""
    A, B = (CollisionMesh(*shape) for shape in SHAPE_PAIRS["doughnut-cone"])
    rng = np.random.default_rng(3)
    cache = WitnessCache(A, B)
    X_AB = pose(p=(0, 0, -0.17))
    for standoff in [*rng.uniform(0, 0.02, 30), 0, 0.1, 0, 1e-12, 0.02, 1e6]:
        _same(cache.witness_pairs(X_AB, standoff), witness_pairs(A, B, X_AB, standoff))


def test_merging_now_and_then():
    """Rows of the other kind left over."""
    A, B = (CollisionMesh(*shape) for shape in SHAPE_PAIRS["doughnut-cone"])
    cache = WitnessCache(A, B)
    for merge in (True, False, False, True, True, False):
        X_AB = pose(p=(0, 0, -0.17))
        cached = cache.witness_pairs(X_AB, 0.01, merge=merge)
        _same(cached, witness_pairs(A, B, X_AB, 0.01, merge=merge))
    assert cache.gathered == 1


def test_results_survive_the_next_query():
    """Rows that point into the cache's own buffers."""
    A, B = (CollisionMesh(*shape) for shape in SHAPE_PAIRS["doughnut-cone"])
    cache = WitnessCache(A, B)
    first = cache.witness_pairs(pose(p=(0, 0, -0.17)), 0.01)
    copy = {name: column.copy() for name, column in first.columns().items()}
    cache.witness_pairs(pose(p=(0, 0, -0.1701)), 0.012)
    del cache
    for name, column in copy.items():
        np.testing.assert_array_equal(getattr(first, name), column)


@pytest.fixture
def restore_simd():
    widest = _core.simd()
    yield
    _core.select_simd(widest)


@pytest.mark.usefixtures("restore_simd")
@pytest.mark.parametrize("path", ["scalar", "vector", "avx2", "avx512"])
@pytest.mark.parametrize("shapes", SHAPE_PAIRS.values(), ids=SHAPE_PAIRS)
def test_all_instruction_sets(shapes, path):
    """Features rechecked by other operations than those that found them."""
    try:
        _core.select_simd(path)
    except ValueError:
        pytest.skip(f"this processor has no {path}")
    A, B = (CollisionMesh(*shape) for shape in shapes)
    rng = np.random.default_rng(4)
    cache = WitnessCache(A, B)
    for _ in range(4):
        X_AB = random_pose(rng, 0.4 * (A.diagonal + B.diagonal))
        for merge in [True, False] * 5:
            X_AB = _stepped(X_AB, rng, turn=1e-4, shift=1e-5 * A.diagonal)
            cached = cache.witness_pairs(X_AB, 0.05 * A.diagonal, merge=merge)
            _same(cached, witness_pairs(A, B, X_AB, 0.05 * A.diagonal, merge=merge))


@pytest.mark.parametrize("tilt", [0.0, 1e-15, 1e-9, 1e-6, 1e-4, 1e-2])
def test_flat_on_flat(tilt):
    """Ties and near ties: parallel edges and faces, where a hair decides which features win."""
    A = CollisionMesh(*mesh_shapes.cube())
    B = CollisionMesh(*mesh_shapes.sheet(6, size=1.5, wave=0.0))
    rng = np.random.default_rng(5)
    for gap in (0.02, 1e-6, 0.0, -0.01):
        cache = WitnessCache(A, B)
        for _ in range(20):
            R = Rotation.from_rotvec(tilt * rng.normal(size=3)).as_matrix()
            X_AB = pose(R, (0.25, 0, 0.5 + gap + 1e-3 * tilt * rng.normal()))
            _same(cache.witness_pairs(X_AB, 0.05), witness_pairs(A, B, X_AB, 0.05))


def test_most_features_are_rechecked_only():
    """A recheck that never trusts itself would be right, and slow."""
    A, B = CollisionMesh(*mesh_shapes.doughnut(32, 24)), CollisionMesh(*mesh_shapes.cone(32, 12))
    rng = np.random.default_rng(6)
    cache = WitnessCache(A, B)
    X_AB = pose(Rotation.from_rotvec([0.1, 0.2, 0.3]).as_matrix(), (0.001, 0, -0.178))
    pairs = measured = 0
    for _ in range(50):
        X_AB = _stepped(X_AB, rng, turn=1e-5, shift=1e-6)
        pairs += cache.witness_pairs(X_AB, 0.01).multiplicity.sum()
        measured += cache.measured
    assert cache.gathered == 1
    assert pairs > 50_000
    assert measured < 0.05 * pairs


def test_new_features_are_learnt():
    """Within the slack, but on other features than were remembered: right, and ever slower."""
    A, B = CollisionMesh(*mesh_shapes.doughnut(32, 24)), CollisionMesh(*mesh_shapes.cone(32, 12))
    cache = WitnessCache(A, B, slack=0.02)
    pairs = measured = 0
    for i, angle in enumerate(np.linspace(0, 0.05, 120)):
        X_AB = pose(Rotation.from_rotvec([0, 0, angle]).as_matrix(), (0.001, 0, -0.178))
        merge = i % 3 > 0
        cached = cache.witness_pairs(X_AB, 0.005, merge=merge)
        _same(cached, witness_pairs(A, B, X_AB, 0.005, merge=merge))
        pairs, measured = pairs + cached.multiplicity.sum(), measured + cache.measured
    assert cache.gathered == 1
    assert measured < 0.15 * pairs


def test_nearly_parallel_edges_are_rechecked_only():
    """A peg in its hole, tilted by a hair: heights too small to tell apart by a distance's error.

    And gathered where all edges are parallel: what is not certain there must become so.
    """
    pair = peg_in_hole(4)
    A, B = pair.meshes()
    cache = WitnessCache(A, B, slack=1e-4)
    counts = []
    for tilt in [0.0, *np.linspace(0, 2e-4, 40)]:
        X_AB = pair.poses["turned"] @ pose(Rotation.from_rotvec([tilt, 0, 0]).as_matrix())
        cached = cache.witness_pairs(X_AB, 5e-4, merge=False)
        _same(cached, witness_pairs(A, B, X_AB, 5e-4, merge=False))
        counts.append((cache.measured, len(cached)))
    assert cache.gathered == 1
    assert counts[1][0] > 0.3 * counts[1][1]
    measured, pairs = np.sum(counts[10:], axis=0)
    assert measured < 0.1 * pairs


@pytest.mark.parametrize(("shift", "growth"), [(3e-4, 1.0), (0.0, 1.1)])
def test_too_fast_to_gather(shift, growth):
    """Gathering at every query costs three times as much as having no cache."""
    A, B = (CollisionMesh(*shape) for shape in SHAPE_PAIRS["doughnut-cone"])
    cache = WitnessCache(A, B)
    for i in range(30):
        X_AB, standoff = pose(p=(0, 0, -0.17 - shift * i)), 0.004 * growth**i
        _same(cache.witness_pairs(X_AB, standoff), witness_pairs(A, B, X_AB, standoff))
    assert cache.gathered == 0
    for _ in range(3):
        _same(cache.witness_pairs(X_AB, standoff), witness_pairs(A, B, X_AB, standoff))
    assert cache.gathered == 1


@pytest.mark.parametrize(("steps", "gathered"), [(200, 5), (8000, 33)])
def test_slack_follows_the_motion(steps, gathered):
    """A slack too wide for slow motion drags candidates along; one too narrow is soon left.

    On a way of w in steps of s, with the widest slack W: w/W times, or w/(6 sqrt(W s)) if more.
    """
    A = CollisionMesh(*mesh_shapes.cube())
    cache = WitnessCache(A, A)
    for z in np.linspace(1.0, 1.1, steps):
        cache.witness_pairs(pose(p=(0.3, 0.2, z)), 0.08)
    assert gathered <= cache.gathered <= 1.2 * gathered + 1


def test_slack_narrows_once_the_motion_slows_down():
    """Gathered in flight, kept at rest: candidates far out of reach dragged along for good."""
    A, B = (CollisionMesh(*shape) for shape in SHAPE_PAIRS["doughnut-cone"])
    cache = WitnessCache(A, B)
    gathered = []
    for z in [*np.linspace(-0.18, -0.17, 30), *np.linspace(-0.17, -0.16999, 500)]:
        X_AB = pose(p=(0, 0, z))
        _same(cache.witness_pairs(X_AB, 0.01), witness_pairs(A, B, X_AB, 0.01))
        gathered.append(cache.gathered)
    assert gathered[30] > 1
    assert gathered[-1] == gathered[300] == gathered[30] + 1


@pytest.mark.parametrize("slack", [0.0, -1.0, np.nan, np.inf])
def test_bad_slack(slack):
    A = CollisionMesh(*mesh_shapes.cube())
    with pytest.raises(ValueError, match="slack"):
        WitnessCache(A, A, slack=slack)


def test_bad_queries():
    """The checks of the cold query hold here too."""
    A = CollisionMesh(*mesh_shapes.cube())
    cache = WitnessCache(A, A)
    with pytest.raises(ValueError, match="standoff"):
        cache.witness_pairs(np.eye(4), -1.0)
    with pytest.raises(ValueError, match="X_AB"):
        cache.witness_pairs(2 * np.eye(4), 0.1)
