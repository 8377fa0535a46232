"""Every facet pair within the standoff, against brute force: none missed, none invented."""

import pickle

import mesh_shapes
import numpy as np
import oracle_brute_force as brute
import pytest
from mesh_shapes import WITNESS_PAIRS
from poses import inverse, pose, random_pose, random_rotation

from contact_toolkit import CollisionMesh, FeatureKind, witness_pairs

pytestmark = pytest.mark.engine

_TOLERANCE = 1e-12  # of the coordinates' size
_ON_SLIVER = 1e-9  # the same, of points on slivers, whose planes are ill-defined
_POSES = 300
VERTEX, EDGE, FACET, _ = FeatureKind


def _size(A, B, X_AB):
    return max(np.abs(A.vertices).max(), np.abs(B.vertices @ X_AB[:3, :3].T + X_AB[:3, 3]).max())


def _same(p, q):
    for name, column in p.columns().items():
        np.testing.assert_array_equal(column, getattr(q, name), err_msg=name)


# --- against brute force -------------------------------------------------------------------------


def _poses(A, B, rng):
    """Apart, crossing and nested as chance has it; every fifth pose drawn up until they touch."""
    reach = A.diagonal / 2 + B.diagonal / 2
    for k in range(_POSES):
        X_AB = random_pose(rng, reach * (1, 0.5, 0.1)[k % 3])
        if k % 5 == 0:
            closest = brute.closest_facet_pair(A, B, X_AB)
            X_AB[:3, 3] += (closest.p_ACa - closest.p_ACb)[0].astype(float)
        yield X_AB


@pytest.mark.parametrize("shapes", WITNESS_PAIRS.values(), ids=WITNESS_PAIRS)
def test_equals_brute_force(shapes):
    """A pair missed by culling, a pair too many, a wrong distance or witness point."""
    A, B = (CollisionMesh(*shape) for shape in shapes)
    rng = np.random.default_rng(1)
    crossings = pairs_seen = 0
    for X_AB in _poses(A, B, rng):
        size = _size(A, B, X_AB)
        standoff = 10.0 ** rng.uniform(-3, -1) * min(A.diagonal, B.diagonal)
        found = witness_pairs(A, B, X_AB, standoff, merge=False)
        expected = brute.facet_pairs(A, B, X_AB, standoff + _TOLERANCE * size)
        _check_same_set(found, expected, standoff, _TOLERANCE * size)
        on_facet = _TOLERANCE if len(A.faces) > 1 else _ON_SLIVER
        _check_witnesses(A, B, X_AB, found, tolerance=_TOLERANCE * size, on_facet=on_facet * size)
        crossings += np.count_nonzero(expected.distance == 0)
        pairs_seen += len(expected)
    assert pairs_seen > _POSES / 10
    assert crossings > _POSES / 10 or len(A.faces) == 1


def _check_same_set(found, expected, standoff, tolerance):
    order = np.lexsort((found.facet_b, found.facet_a))
    keys = list(zip(found.facet_a[order].tolist(), found.facet_b[order].tolist(), strict=True))
    assert len(set(keys)) == len(keys)
    distances = dict(
        zip(
            zip(expected.facet_a.tolist(), expected.facet_b.tolist(), strict=True),
            expected.distance,
            strict=True,
        )
    )
    assert set(keys) <= set(distances)
    missed = set(distances) - set(keys)
    assert all(distances[key] > standoff - tolerance for key in missed), missed
    judged = np.array([distances[key] for key in keys])
    assert np.abs(found.distance[order] - judged).max(initial=0) < tolerance
    assert found.distance.max(initial=0) <= standoff


def _check_witnesses(A, B, X_AB, found, *, tolerance, on_facet):
    between = found.p_ACa - found.p_ACb
    gaps = np.linalg.norm(between, axis=1)
    assert np.abs(gaps - found.distance).max(initial=0) < tolerance
    p_BCb = found.p_ACb @ X_AB[:3, :3] - X_AB[:3, 3] @ X_AB[:3, :3]
    for mesh, points, facets in ((A, found.p_ACa, found.facet_a), (B, p_BCb, found.facet_b)):
        corners = mesh.vertices[mesh.faces[facets]]
        off, _, _ = brute.triangle_distances(corners, np.repeat(points[:, None], 3, axis=1))
        assert off.max(initial=0) < on_facet
    assert np.abs(np.linalg.norm(found.normal_A, axis=1) - 1).max(initial=0) < 1e-14
    clear = found.distance > 1e3 * tolerance
    from_b_to_a = between[clear] / gaps[clear, None]
    assert np.abs(found.normal_A[clear] - from_b_to_a).max(initial=0) < 1e-2


def test_everything_at_the_standoff():
    """Culling in single precision that rounds away what lies a millionth inside of it."""
    vertices, faces = mesh_shapes.sheet(6, wave=0)
    rng = np.random.default_rng(7)
    for _ in range(40):
        tilt, gap, angle = random_rotation(rng), 10.0 ** rng.uniform(-6, 0), rng.uniform(0, 7)
        turn = np.array(
            [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
        )
        A = CollisionMesh(vertices @ tilt.T, faces)
        B = CollisionMesh(vertices, faces)
        shift = np.append(rng.uniform(-0.3, 0.3, 2), gap)
        X_AB = pose(tilt @ turn, tuple(tilt @ shift))
        standoff = gap + 1e-14
        found = witness_pairs(A, B, X_AB, standoff, merge=False)
        expected = brute.facet_pairs(A, B, X_AB, standoff)
        assert len(found) == len(expected) > 100


@pytest.mark.parametrize("shapes", WITNESS_PAIRS.values(), ids=WITNESS_PAIRS)
def test_features_carry_the_witness_points(shapes):
    """A feature that is not the facet's, or that the witness point does not lie on."""
    A, B = (CollisionMesh(*shape) for shape in shapes)
    rng = np.random.default_rng(2)
    for _ in range(20):
        X_AB = random_pose(rng, A.diagonal / 2 + B.diagonal / 2)
        found = witness_pairs(A, B, X_AB, 0.1 * A.diagonal, merge=False)
        p_BCb = found.p_ACb @ X_AB[:3, :3] - X_AB[:3, 3] @ X_AB[:3, :3]
        tolerance = 1e-8 * _size(A, B, X_AB)
        for mesh, points, facets, features in (
            (A, found.p_ACa, found.facet_a, found.feature_a),
            (B, p_BCb, found.facet_b, found.feature_b),
        ):
            assert features.dtype == np.int32
            corners = _corners_of_features(mesh, facets, features)
            off, _, _ = brute.triangle_distances(corners, np.repeat(points[:, None], 3, axis=1))
            assert off.max(initial=0) < tolerance


def _corners_of_features(mesh, facets, features):
    """The features as triangles (n,3,3), degenerate for vertices and edges."""
    kind, index = features.T
    at_vertex, on_edge, in_facet = kind == VERTEX, kind == EDGE, kind == FACET
    assert (at_vertex | on_edge | in_facet).all()
    assert (mesh.faces[facets] == index[:, None]).any(axis=1)[at_vertex].all()
    assert (mesh.face_edges[facets] == index[:, None]).any(axis=1)[on_edge].all()
    assert (index == facets)[in_facet].all()
    vertices = mesh.faces[facets].copy()
    vertices[at_vertex] = index[at_vertex, None]
    vertices[on_edge] = mesh.edges[index[on_edge]][:, [0, 1, 1]]
    return mesh.vertices[vertices]


# --- touching, crossing, nested ------------------------------------------------------------------


def _upright_cube(size=1.0):
    return CollisionMesh(*mesh_shapes.cube(size))


def test_crossing_points_coincide():
    """FCL and coal report points up to 11 m apart on crossing facets."""
    A, B = _upright_cube(), _upright_cube()
    rng = np.random.default_rng(4)
    for _ in range(50):
        X_AB = random_pose(rng, 0.8)
        found = witness_pairs(A, B, X_AB, 1e-3, merge=False)
        crossing = found.distance == 0
        assert crossing.any()
        apart = np.linalg.norm(found.p_ACa[crossing] - found.p_ACb[crossing], axis=1)
        assert apart.max() <= 1e-12


def test_touching_faces():
    """Exactly touching: distance 0, and nothing lost for being on the border."""
    A = _upright_cube()
    found = witness_pairs(A, A, pose(p=(1, 0, 0)), 1e-6, merge=False)
    assert (found.distance == 0).all()
    assert len(found.distance) == len(brute.facet_pairs(A, A, pose(p=(1, 0, 0)), 1e-9))
    facing = (A.face_normals[found.facet_a] == [1, 0, 0]).all(axis=1)
    facing &= (A.face_normals[found.facet_b] == [-1, 0, 0]).all(axis=1)
    assert np.count_nonzero(facing) == 4
    np.testing.assert_array_equal(found.normal_A[facing], [[-1, 0, 0]] * 4)


def test_crossing_normals_push_out():
    """Without a distance to point along, the windings tell where out of B and into A is."""
    A, B = _upright_cube(), _upright_cube()
    found = witness_pairs(A, B, pose(p=(0.99, 0.02, 0.01)), 1e-6, merge=False)
    crossing = found.distance == 0
    assert crossing.sum() > 4
    assert (found.normal_A[crossing, 0] <= 0).all()
    assert found.normal_A[crossing].mean(axis=0)[0] < -0.1


def test_nested_far_inside_finds_nothing():
    """Surfaces, not solids: a small cube in the middle of a large one is far from it."""
    found = witness_pairs(_upright_cube(10), _upright_cube(), np.eye(4), 1.0)
    assert len(found.distance) == 0
    assert found.p_ACa.shape == (0, 3)
    assert found.feature_a.shape == (0, 2)


def test_coincident_meshes():
    """Every facet on top of its twin."""
    A = _upright_cube()
    found = witness_pairs(A, A, np.eye(4), 1e-3, merge=False)
    twins = found.facet_a == found.facet_b
    assert np.count_nonzero(twins) == len(A.faces)
    assert (found.distance[twins] == 0).all()


# --- determinism and symmetry --------------------------------------------------------------------


@pytest.mark.parametrize("merge", [True, False])
def test_same_call_same_bits(merge):
    """Order or values that depend on addresses or on what was asked before."""
    A, B = (CollisionMesh(*shape) for shape in WITNESS_PAIRS["doughnut-cone"])
    X_AB = pose(p=(0.001, 0, -0.17))
    first = witness_pairs(A, B, X_AB, 0.01, merge=merge)
    witness_pairs(B, A, X_AB, 0.05, merge=not merge)
    again = [CollisionMesh(*shape) for shape in WITNESS_PAIRS["doughnut-cone"]]
    _same(first, witness_pairs(*again, X_AB, 0.01, merge=merge))
    assert len(first.distance) > 20


@pytest.mark.threads
@pytest.mark.parametrize("merge", [True, False])
@pytest.mark.parametrize("threads", [2, 8])
def test_same_bits_on_any_number_of_threads(threads, merge):
    """A simulation that depends on the machine's load."""
    A = CollisionMesh(*mesh_shapes.doughnut(48, 24))
    B = CollisionMesh(*mesh_shapes.cone(48, 8))
    rng = np.random.default_rng(5)
    for _ in range(5):
        X_AB = pose(random_rotation(rng), (0.04, 0, 0))
        one = witness_pairs(A, B, X_AB, 0.01, merge=merge, threads=1)
        _same(one, witness_pairs(A, B, X_AB, 0.01, merge=merge, threads=threads))
        assert len(one.distance) > 50


@pytest.mark.parametrize("shapes", WITNESS_PAIRS.values(), ids=WITNESS_PAIRS)
def test_swap(shapes):
    """A and B treated differently: forces that do not sum to zero."""
    A, B = (CollisionMesh(*shape) for shape in shapes)
    rng = np.random.default_rng(6)
    for _ in range(20):
        X_AB = random_pose(rng, A.diagonal / 2 + B.diagonal / 2)
        size = _size(A, B, X_AB)
        one = witness_pairs(A, B, X_AB, 0.1 * A.diagonal, merge=False)
        two = witness_pairs(B, A, inverse(X_AB), 0.1 * A.diagonal, merge=False)
        order = np.lexsort((one.facet_b, one.facet_a))
        swapped = np.lexsort((two.facet_a, two.facet_b))
        np.testing.assert_array_equal(one.facet_a[order], two.facet_b[swapped])
        np.testing.assert_array_equal(one.facet_b[order], two.facet_a[swapped])
        np.testing.assert_allclose(
            one.distance[order], two.distance[swapped], rtol=0, atol=_TOLERANCE * size
        )


# --- arguments -----------------------------------------------------------------------------------


@pytest.mark.parametrize("standoff", [-1e-3, np.nan, np.inf])
def test_bad_standoff(standoff):
    """A comparison with NaN finds nothing, silently."""
    A = _upright_cube()
    with pytest.raises(ValueError, match="standoff"):
        witness_pairs(A, A, np.eye(4), standoff)


@pytest.mark.parametrize("threads", [0, -1])
def test_bad_threads(threads):
    """No thread at all finds nothing, silently."""
    A = _upright_cube()
    with pytest.raises(ValueError, match="threads"):
        witness_pairs(A, A, np.eye(4), 0.1, threads=threads)


@pytest.mark.parametrize(
    "X_AB",
    [
        np.eye(3),
        np.full((4, 4), np.nan),
        pose(p=(np.inf, 0, 0)),
        2 * np.eye(4),
        np.diag([1.0, 1, -1, 1]),
        pose(np.array([[1.0, 0.1, 0], [0, 1, 0], [0, 0, 1]])),
        np.zeros((4, 4)),
        None,
    ],
    ids=["3x3", "NaN", "infinite", "scaled", "mirrored", "sheared", "zeros", "None"],
)
def test_bad_pose(X_AB):
    """A transform that is no pose gives distances that are no distances."""
    A = _upright_cube()
    with pytest.raises(ValueError, match="X_AB"):
        witness_pairs(A, A, X_AB, 0.1)


@pytest.mark.parametrize("mesh", [None, mesh_shapes.cube(), "cube.obj"])
def test_not_a_mesh(mesh):
    """Something else than a mesh must not reach the native code."""
    with pytest.raises((TypeError, AttributeError)):
        witness_pairs(_upright_cube(), mesh, np.eye(4), 0.1)


def test_to_another_process_and_back():
    """Results and meshes are sent between processes in sweeps; the copies are as good."""
    A, B = (CollisionMesh(*shape) for shape in WITNESS_PAIRS["doughnut-cone"])
    X_AB = pose(p=(0, 0, -0.17))
    pairs = witness_pairs(A, B, X_AB, 0.01)
    A, B, copy = pickle.loads(pickle.dumps((A, B, pairs)))
    assert len(pairs) == len(copy) > 0
    _same(pairs, copy)
    _same(pairs, witness_pairs(A, B, X_AB, 0.01))
    assert "rows: distance" in repr(copy)
