"""Every facet pair within the standoff: against brute force, and against counts known by hand."""

import mesh_shapes
import numpy as np
import oracle_brute_force as brute
import pytest
from poses import inverse, pose, random_pose, random_rotation

from contact_toolkit import CollisionMesh, witness_pairs

pytestmark = pytest.mark.engine

_TOLERANCE = 1e-12  # of the coordinates' size
_ON_SLIVER = 1e-9  # the same, of points on slivers, whose planes are ill-defined
_POSES = 300
VERTEX, EDGE, FACET = 0, 1, 2

SHAPE_PAIRS = {
    "doughnut-cone": (mesh_shapes.doughnut(10, 6), mesh_shapes.cone(10, 3)),
    "cube-cube": (mesh_shapes.cube(), mesh_shapes.cube(0.7)),
    "sheet-ball": (mesh_shapes.sheet(6), mesh_shapes.ball(1, bumps=0.3)),
    "soup-soup": (mesh_shapes.soup(60, seed=1), mesh_shapes.soup(60, seed=2)),
    "sliver-sliver": (mesh_shapes.sliver(), mesh_shapes.sliver(width=1e-6)),
    "ball-ball": (mesh_shapes.ball(2), mesh_shapes.ball(1, radius=0.2)),
}


def _size(A, B, X_AB):
    return max(np.abs(A.vertices).max(), np.abs(B.vertices @ X_AB[:3, :3].T + X_AB[:3, 3]).max())


def _columns(pairs):
    return {name: np.asarray(column) for name, column in vars(pairs).items()}


def _same(p, q):
    for name, column in _columns(p).items():
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


@pytest.mark.parametrize("shapes", SHAPE_PAIRS.values(), ids=SHAPE_PAIRS)
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


@pytest.mark.parametrize("shapes", SHAPE_PAIRS.values(), ids=SHAPE_PAIRS)
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


# --- merging -------------------------------------------------------------------------------------


@pytest.mark.parametrize("shapes", SHAPE_PAIRS.values(), ids=SHAPE_PAIRS)
def test_merging_groups_by_features(shapes):
    """Merging that loses a facet pair, or joins what lies on different features."""
    A, B = (CollisionMesh(*shape) for shape in shapes)
    rng = np.random.default_rng(3)
    for _ in range(20):
        X_AB = random_pose(rng, A.diagonal / 2 + B.diagonal / 2)
        single = witness_pairs(A, B, X_AB, 0.1 * A.diagonal, merge=False)
        merged = witness_pairs(A, B, X_AB, 0.1 * A.diagonal)
        assert (single.multiplicity == 1).all()
        assert merged.multiplicity.sum() == len(single.distance)
        counts = {}
        for row in np.hstack([single.feature_a, single.feature_b]):
            counts[tuple(row.tolist())] = counts.get(tuple(row.tolist()), 0) + 1
        rows = [tuple(row) for row in np.hstack([merged.feature_a, merged.feature_b]).tolist()]
        assert len(set(rows)) == len(rows)
        assert dict(zip(rows, merged.multiplicity.tolist(), strict=True)) == counts


def _upright_cube(size=1.0):
    return CollisionMesh(*mesh_shapes.cube(size))


def _on_corner():
    """The rotation that stands a cube on the corner 0."""
    z = np.ones(3) / np.sqrt(3)
    x = np.array([1, -1, 0]) / np.sqrt(2)
    return np.stack([x, np.cross(z, x), z])


def _on_edge():
    """The rotation that stands a cube on the edge between corners 0 and 4, along x."""
    c = np.sqrt(0.5)
    return np.array([[1, 0, 0], [0, c, -c], [0, c, c]])


def _rows(found):
    return sorted(
        (tuple(a), tuple(b), m)
        for a, b, m in zip(
            found.feature_a.tolist(),
            found.feature_b.tolist(),
            found.multiplicity.tolist(),
            strict=True,
        )
    )


def test_cube_corner_over_a_facet():
    """One contact, behind it the corner's facets each against the facet below."""
    A, B = _upright_cube(10), _upright_cube()
    X_AB = pose(_on_corner(), (1, 2.1, 5 + np.sqrt(3) / 2 + 0.01))
    found = witness_pairs(A, B, X_AB, 0.011)
    at_corner = np.count_nonzero((B.faces == 0).any(axis=1))
    (top,) = _facets_under(A, [1, 2.1, 5])
    assert _rows(found) == [((FACET, top), (VERTEX, 0), at_corner)]
    assert found.distance[0] == pytest.approx(0.01, abs=1e-14)
    np.testing.assert_allclose(found.p_ACa[0], [1, 2.1, 5], atol=1e-14)
    np.testing.assert_allclose(found.normal_A[0], [0, 0, -1], atol=1e-13)


def test_cube_edge_over_a_facet():
    """The two facets of the edge see the same closest points: one row where they agree."""
    A, B = _upright_cube(10), _upright_cube()
    X_AB = pose(_on_edge(), (1, 3, 5 + np.sqrt(0.5) + 0.01))
    single = witness_pairs(A, B, X_AB, 0.011, merge=False)
    at_edge = np.nonzero(np.isin(B.faces, [0, 4]).any(axis=1))[0]
    (top,) = _facets_under(A, [1, 3, 5])
    assert set(single.facet_b.tolist()) == set(at_edge.tolist())
    assert set(single.facet_a.tolist()) == {top}
    merged = witness_pairs(A, B, X_AB, 0.011)
    assert merged.multiplicity.sum() == len(at_edge)
    np.testing.assert_allclose(merged.distance, 0.01, atol=1e-14)
    np.testing.assert_allclose(merged.normal_A, [[0, 0, -1]] * len(merged.distance), atol=1e-13)


def test_corner_over_corner():
    """Every facet at one corner with every facet at the other: one row."""
    A, B = _upright_cube(), _upright_cube(0.5)
    X_AB = pose(p=(0.75 + 0.01,) * 3)
    found = witness_pairs(A, B, X_AB, 0.02)
    at_a = np.count_nonzero((A.faces == 7).any(axis=1))
    at_b = np.count_nonzero((B.faces == 0).any(axis=1))
    assert _rows(found) == [((VERTEX, 7), (VERTEX, 0), at_a * at_b)]
    assert found.distance[0] == pytest.approx(0.01 * np.sqrt(3), abs=1e-15)


def test_edge_over_crossed_edge():
    """Two facets at one edge with two at the other: one row of four."""
    ridge = np.array([[-1.0, 0, 0], [1, 0, 0], [0, 1, -1], [0, -1, -1]])
    roof = CollisionMesh(ridge, [[0, 1, 2], [1, 0, 3]])
    turn = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]])
    X_AB = pose(turn, (0.1, 0.2, 0.05))
    found = witness_pairs(roof, roof, X_AB, 0.06)
    edge = np.nonzero((roof.edges == [0, 1]).all(axis=1))[0][0]
    assert _rows(found) == [((EDGE, edge), (EDGE, edge), 4)]
    np.testing.assert_allclose(found.p_ACa[0], [0.1, 0, 0], atol=1e-15)
    np.testing.assert_allclose(found.p_ACb[0], [0.1, 0, 0.05], atol=1e-15)
    np.testing.assert_allclose(found.normal_A[0], [0, 0, -1], atol=1e-13)


def _facets_under(mesh, point):
    """The facets whose inside holds a point."""
    corners = mesh.vertices[mesh.faces]
    off, _, _ = brute.triangle_distances(
        corners, np.broadcast_to(np.array(point, float), corners.shape)
    )
    return np.nonzero(off < 1e-12)[0].tolist()


# --- touching, crossing, nested ------------------------------------------------------------------


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
    A, B = (CollisionMesh(*shape) for shape in SHAPE_PAIRS["doughnut-cone"])
    X_AB = pose(p=(0.001, 0, -0.17))
    first = witness_pairs(A, B, X_AB, 0.01, merge=merge)
    witness_pairs(B, A, X_AB, 0.05, merge=not merge)
    again = [CollisionMesh(*shape) for shape in SHAPE_PAIRS["doughnut-cone"]]
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


@pytest.mark.parametrize("shapes", SHAPE_PAIRS.values(), ids=SHAPE_PAIRS)
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
