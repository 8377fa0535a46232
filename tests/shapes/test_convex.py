"""Convex pieces: queries against brute force over pieces, and decomposition in a child process."""

import pickle
from pathlib import Path

import mesh_shapes
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from poses import pose, random_pose, random_rotation
from scipy.spatial.transform import Rotation

from contact_toolkit import (
    CollisionMesh,
    ConvexPieces,
    DecompositionError,
    FeatureKind,
    ImpactStatus,
    MeshError,
    _core,
    decompose,
    distance,
    distance_batch,
    intersects,
    intersects_batch,
    swept_distance,
    swept_intersects,
    time_of_impact,
)
from contact_toolkit.shapes import decomposition

rngs = st.integers(0, 2**32 - 1).map(np.random.default_rng)


def _random_pieces(rng, count, size=0.3):
    return ConvexPieces(
        [
            rng.uniform(-1, 1, 3) + rng.uniform(-size, size, (rng.integers(1, 12), 3))
            for _ in range(count)
        ]
    )


def _least_of_all_pairs(A, B, X):
    moved = [np.ascontiguousarray(b @ X[:3, :3].T + X[:3, 3]) for b in B]
    return min(_core.gjk(np.array(a), b, np.inf)["distance"] for a in A for b in moved)


def _least_of_all_sweeps(A, B, X0, X1):
    """In a pure translation: every piece sweeps over the hull of its two end positions."""
    ends = [[b @ X[:3, :3].T + X[:3, 3] for X in (X0, X1)] for b in B]
    swept = [np.ascontiguousarray(np.concatenate(pair)) for pair in ends]
    return min(_core.gjk(np.array(a), b, np.inf)["distance"] for a in A for b in swept)


def _box(lower, upper):
    corners = np.stack(np.meshgrid(*zip(lower, upper, strict=True), indexing="ij"), axis=-1)
    return corners.reshape(-1, 3).astype(float)


@pytest.mark.engine
@given(rngs, st.integers(1, 40), st.integers(1, 40))
def test_distance_is_that_of_the_closest_pieces(rng, count_a, count_b):
    """A pair of pieces that the hierarchy overlooked."""
    A, B = _random_pieces(rng, count_a), _random_pieces(rng, count_b)
    X = random_pose(rng, 4)
    found = distance(A, B, X)
    truth = _least_of_all_pairs(A.pieces, B.pieces, X)
    assert abs(found.distance - truth) < 1e-13
    assert intersects(A, B, X) == (truth == 0)
    assert found.feature_a == (FeatureKind.PIECE, found.facet_a)
    assert abs(np.linalg.norm(found.p_ACa - found.p_ACb) - truth) < 1e-13
    if truth > 0:
        assert np.linalg.norm(found.normal_A) == pytest.approx(1)


@pytest.mark.engine
@given(rngs)
def test_mesh_against_pieces(rng):
    """A mix of the two kinds of shape, whose facets meet solids."""
    vertices, faces = mesh_shapes.doughnut(10, 6, major=0.5, minor=0.2)
    A, B = CollisionMesh(vertices, faces), _random_pieces(rng, 10)
    X = random_pose(rng, 2)
    found = distance(A, B, X)
    truth = _least_of_all_pairs(vertices[faces], B.pieces, X)
    assert abs(found.distance - truth) < 1e-13
    assert found.feature_a == (FeatureKind.FACET, found.facet_a)
    assert found.feature_b == (FeatureKind.PIECE, found.facet_b)
    other = distance(B, A, np.linalg.inv(X))
    assert abs(other.distance - truth) < 1e-12


@pytest.mark.engine
@given(rngs, st.sampled_from([0, 0.5]))
def test_swept_pieces(rng, turn):
    """A motion of pieces in which a distance occurs below the one certified."""
    A, B = _random_pieces(rng, 8), _random_pieces(rng, 8)
    X0 = random_pose(rng, 4)
    X1 = X0.copy()
    X1[:3, 3] += rng.normal(size=3)
    spin = rng.normal(size=3) * turn
    X1[:3, :3] = Rotation.from_rotvec(spin).as_matrix() @ X0[:3, :3]
    found = swept_distance(A, B, X0, X1, tolerance=1e-4)
    samples = []
    for s in np.linspace(0, 1, 31):
        R = Rotation.from_rotvec(s * spin).as_matrix() @ X0[:3, :3]
        X = pose(R, tuple((1 - s) * X0[:3, 3] + s * X1[:3, 3]))
        samples.append(distance(A, B, X).distance)
    assert found.distance <= min(samples) + 1e-12
    assert found.error <= 1.01e-4
    if turn == 0:
        truth = _least_of_all_sweeps(A.pieces, B.pieces, X0, X1)
        assert found.error == 0
        assert abs(found.distance - truth) < 1e-12
    impact = time_of_impact(A, B, X0, X1, tolerance=1e-4)
    assert impact.status == ImpactStatus.FREE or impact.distance <= 1e-4
    assert impact.status != ImpactStatus.ITERATION_LIMIT
    before = np.linspace(0, 1, 31) < impact.time
    assert (np.array(samples)[before] > 0).all()
    assert impact.status != ImpactStatus.FREE or min(samples) > 0
    assert swept_intersects(A, B, X0, X1) or min(samples) > 0


@pytest.mark.engine
@given(rngs)
def test_pieces_at_rest(rng):
    """Two answers to one question: no motion, and none asked about."""
    A, B = _random_pieces(rng, 8), _random_pieces(rng, 8)
    X = random_pose(rng, 4)
    static, swept = distance(A, B, X), swept_distance(A, B, X, X)
    assert (swept.distance, swept.error) == (static.distance, 0)
    assert swept_intersects(A, B, X, X) == intersects(A, B, X)
    impact = time_of_impact(A, B, X, X)
    assert (impact.status == ImpactStatus.INITIAL_CONTACT) == (static.distance == 0)


@pytest.mark.engine
@pytest.mark.parametrize("spin", [0.0, 3.0])
def test_bullet_of_pieces_through_a_plate(spin):
    """A piece that is on the other side at the next step, seen on neither side."""
    plate = ConvexPieces([_box([-1, -1, -5e-7], [1, 1, 5e-7])])
    bullet = ConvexPieces([_box([-0.01, -0.01, 0], [0.01, 0.01, 0.01]), [[0.0, 0.0, -0.01]]])
    rng = np.random.default_rng(3)
    for _ in range(20):
        X0, X1 = random_pose(rng, 0.4), random_pose(rng, 0.4)
        X0[2, 3], X1[2, 3] = rng.uniform(0.1, 50), -rng.uniform(0.1, 50)
        if spin == 0:
            X1[:3, :3] = X0[:3, :3]
        assert swept_intersects(plate, bullet, X0, X1)
        assert swept_distance(plate, bullet, X0, X1).distance == 0
        assert time_of_impact(plate, bullet, X0, X1).status == ImpactStatus.IMPACT


@pytest.mark.engine
def test_pieces_are_solid():
    """A small body deep inside a large one, which surfaces alone would call free."""
    A = ConvexPieces([_box([-1, -1, -1], [1, 1, 1])])
    mote = ConvexPieces([[[0.1, 0.2, 0.3]]])
    assert intersects(A, mote, pose())
    found = distance(A, mote, pose())
    assert found.distance == 0
    assert (found.p_ACa == found.p_ACb).all()
    assert intersects(A, CollisionMesh(*mesh_shapes.cube(0.1)), pose())


@pytest.mark.engine
@pytest.mark.threads
def test_batches_equal_single_queries():
    """Rows mixed up or answers changed by sharing them between threads."""
    rng = np.random.default_rng(0)
    meshes = [
        CollisionMesh(*shape) for shape in (mesh_shapes.doughnut(), mesh_shapes.cone(height=0.1))
    ]
    for A, B in (meshes, [_random_pieces(rng, 20), _random_pieces(rng, 5)]):
        reach = A.diagonal + B.diagonal
        poses = np.array([random_pose(rng, reach) for _ in range(40)])
        for threads in (1, 3):
            found = distance_batch(A, B, poses, threads=threads)
            touch = intersects_batch(A, B, poses, threads=threads)
            for i, X in enumerate(poses):
                one = distance(A, B, X)
                assert found.distance[i] == one.distance
                assert (found.p_ACa[i] == one.p_ACa).all()
                assert (found.facet_a[i], found.facet_b[i]) == (one.facet_a, one.facet_b)
                assert touch[i] == intersects(A, B, X)


def test_to_another_process_and_back():
    rng = np.random.default_rng(0)
    pieces = ConvexPieces([rng.normal(size=(12, 3)), rng.normal(size=(1, 3))])
    copy = pickle.loads(pickle.dumps(pieces))
    assert all(np.array_equal(a, b) for a, b in zip(pieces.pieces, copy.pieces, strict=True))


def test_hulls_are_closed_and_outward():
    """Pieces that cannot be drawn or weighed."""
    rng = np.random.default_rng(0)
    pieces = ConvexPieces([rng.normal(size=(50, 3)), _box([0, 0, 0], [1, 2, 3])])
    meshes = [CollisionMesh(*pieces.hull(i)) for i in range(2)]
    assert all(mesh.defects.closed for mesh in meshes)
    assert meshes[1].volume == pytest.approx(6)
    assert meshes[0].volume > 0
    assert len(pieces.pieces[1]) == 8
    flat = ConvexPieces([_box([0, 0, 0], [1, 1, 0])])
    with pytest.raises(ValueError, match="flat"):
        flat.hull(0)


@pytest.mark.parametrize(
    ("pieces", "named"),
    [
        ([], "at least one piece"),
        ([np.zeros((1, 3)), np.zeros((0, 3))], "piece 1"),
        ([np.zeros((4, 2))], "piece 0"),
        ([np.zeros((4, 3)), np.full((4, 3), np.nan)], "piece 1"),
        ([np.full((5, 3), 1e16)], "piece 0"),
    ],
    ids=["none", "empty", "shape", "nan", "huge"],
)
def test_bad_pieces_are_named(pieces, named):
    """An error that does not say which piece is wrong."""
    with pytest.raises(ValueError, match=named):
        ConvexPieces(pieces)


def _l_bracket():
    outline = np.array([[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]], float)
    n = len(outline)
    vertices = np.vstack([np.c_[outline, np.zeros(n)], np.c_[outline, np.ones(n)]])
    cap = [[0, 2, 1], [0, 3, 2], [0, 4, 3], [0, 5, 4]]
    around = [(i, (i + 1) % n) for i in range(n)]
    walls = [f for i, k in around for f in ([i, k, n + k], [i, n + k, n + i])]
    faces = [*cap, *([a + n, c + n, b + n] for a, b, c in cap), *walls]
    return CollisionMesh(vertices, faces)


@pytest.fixture
def cache(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "contact-toolkit" / "decompositions"


def test_decomposition_follows_the_solid(cache):
    """Pieces that leave part of the solid out, or fill its notch in."""
    mesh = _l_bracket()
    pieces = decompose(mesh)
    assert 2 <= len(pieces) <= 4
    assert len(list(cache.iterdir())) == 1
    rng = np.random.default_rng(0)
    ball = CollisionMesh(*mesh_shapes.ball(1, bumps=0))
    size = mesh.diagonal
    for _ in range(50):
        X = pose(random_rotation(rng), tuple(rng.uniform(-3, 6, 3)))
        exact, quick = distance(mesh, ball, X).distance, distance(pieces, ball, X).distance
        assert quick <= exact + 0.01 * size
        assert quick >= exact - 0.05 * size or exact == 0 or intersects(pieces, ball, X)
    notch = CollisionMesh(*mesh_shapes.cube(0.5))
    assert distance(pieces, notch, pose(p=(2, 2, 0.5))).distance > 0.5


def test_cache_is_used_and_survives_damage(cache, monkeypatch):
    """A cache that is not read, that mixes parameters up, or that a broken file can poison."""
    mesh = _l_bracket()
    first = decompose(mesh)
    monkeypatch.setattr(decomposition, "_run", lambda *_: pytest.fail("not cached"))
    again = decompose(mesh)
    assert all((a == b).all() for a, b in zip(first.pieces, again.pieces, strict=True))
    for other in ({"threshold": 0.5}, {"seed": 1}, {"max_pieces": 2}, {"cache": False}):
        with pytest.raises(pytest.fail.Exception):
            decompose(mesh, **other)
    (stored,) = cache.iterdir()
    stored.write_bytes(stored.read_bytes()[:100])
    with pytest.raises(pytest.fail.Exception):
        decompose(mesh)


def test_unwritable_cache_is_said(monkeypatch, tmp_path):
    """A result lost, or a failure kept quiet, because there is no room to cache it."""
    blocked = tmp_path / "file"
    blocked.write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(blocked))
    with pytest.warns(UserWarning, match="could not be cached"):
        assert len(decompose(_l_bracket())) >= 2


@pytest.mark.parametrize(
    ("script", "said"),
    [
        ("import time; time.sleep(60)", "did not end within 1 s"),
        ("import os; os.abort()", "SIGABRT"),
        ("import sys; sys.exit('no such luck')", "code 1: no such luck"),
        ("pass", "it said nothing"),
    ],
    ids=["hang", "abort", "error", "silence"],
)
def test_child_process_failures(script, said, cache, monkeypatch, tmp_path):
    """A crash or a hang of CoACD that takes the caller along."""
    worker = tmp_path / "worker.py"
    worker.write_text(script)
    monkeypatch.setattr(decomposition.decomposition_worker, "__file__", str(worker))
    with pytest.raises(DecompositionError, match=said):
        decompose(_l_bracket(), timeout=1 if "sleep" in script else 60)
    assert not cache.exists()


def test_what_coacd_cannot_take_is_refused():
    """Input on which CoACD would end the process or run away."""
    with pytest.raises(MeshError, match="closed mesh"):
        decompose(CollisionMesh(*mesh_shapes.sheet()))
    vertices, faces = mesh_shapes.cube()
    with pytest.raises(MeshError, match="inside out"):
        decompose(CollisionMesh(vertices, faces[:, ::-1]))
    cube = CollisionMesh(vertices, faces)
    for bad in ({"threshold": 0.001}, {"seed": -1}, {"max_pieces": 0}, {"timeout": 0}):
        with pytest.raises(ValueError, match=next(iter(bad))):
            decompose(cube, **bad)


def test_worker_stands_alone():
    """A child that pays for, or fails on, imports it does not need."""
    source = Path(decomposition.decomposition_worker.__file__).read_text()
    assert "contact_toolkit" not in source
