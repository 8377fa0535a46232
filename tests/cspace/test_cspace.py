"""Configurations and motions between them, against C-spaces known in closed form."""

from itertools import pairwise

import mesh_shapes
import numpy as np
import pytest
from poses import pose
from scipy.spatial.transform import Rotation

from contact_toolkit import (
    CollisionMesh,
    ConvexPieces,
    CSpaceClass,
    CSpaceGeometry,
    CSpaceModel,
    classify,
    classify_motions,
    distance,
    signed_distance,
)

pytestmark = pytest.mark.engine

FREE, NEAR, COLLIDING = CSpaceClass


def _box_points(lower, upper):
    corners = np.stack(np.meshgrid(*zip(lower, upper, strict=True), indexing="ij"), axis=-1)
    return corners.reshape(-1, 3).astype(float)


def _box_mesh(size):
    vertices, faces = mesh_shapes.cube()
    return CollisionMesh(vertices * size, faces)


def _planar(x, z, turn=None):
    """Poses (n, 2, 4, 4) of a fixed body and of one at (x, 0, z), turned about y."""
    X = np.tile(np.eye(4), (len(x), 2, 1, 1))
    X[:, 1, 0, 3], X[:, 1, 2, 3] = x, z
    if turn is not None:
        X[:, 1, :3, :3] = Rotation.from_rotvec(np.outer(turn, [0, 1, 0])).as_matrix()
    return X


# A slot of width 0.5 and depth 1 in a block from x = -1 to 1, z = -2 to 0; a peg of width 0.4.
_SLOT = [
    _box_points([-1, -1, -2], [-0.25, 1, 0]),
    _box_points([0.25, -1, -2], [1, 1, 0]),
    _box_points([-1, -1, -2], [1, 1, -1]),
]
_PEG = _box_points([-0.2, -1, -0.5], [0.2, 1, 0.5])


def _peg_distance(x, z):
    """Closed form for an upright peg: the distance of two boxes in the plane, thrice."""
    boxes = [((-1, -2), (-0.25, 0)), ((0.25, -2), (1, 0)), ((-1, -2), (1, -1))]
    least = np.full(np.shape(x), np.inf)
    for lower, upper in boxes:
        dx = np.maximum(np.maximum(lower[0] - (x + 0.2), (x - 0.2) - upper[0]), 0)
        dz = np.maximum(np.maximum(lower[1] - (z + 0.5), (z - 0.5) - upper[1]), 0)
        least = np.minimum(least, np.hypot(dx, dz))
    return least


@pytest.mark.parametrize("kind", ["pieces", "meshes"])
def test_peg_in_slot(kind):
    """A slice of the C-space that differs from the exact one anywhere off its boundary."""
    if kind == "pieces":
        model = CSpaceModel.from_shapes({"slot": ConvexPieces(_SLOT), "peg": ConvexPieces([_PEG])})
    else:
        meshes = [CollisionMesh(*ConvexPieces([points]).hull(0)) for points in (*_SLOT, _PEG)]
        model = CSpaceModel.from_shapes({"slot": meshes[:3], "peg": meshes[3]})
    x, z = (grid.ravel() for grid in np.meshgrid(np.linspace(-2, 2, 81), np.linspace(-3, 2, 101)))
    x, z = x + 0.0012, z + 0.0007
    truth = _peg_distance(x, z)
    found = classify(model, _planar(x, z), standoff=0.05)
    np.testing.assert_allclose(found.distance, truth, atol=1e-12)
    assert (
        found.kind == np.where(truth == 0, COLLIDING, np.where(truth <= 0.05, NEAR, FREE))
    ).all()
    gap = np.linalg.norm(found.p_FCa - found.p_FCb, axis=1)
    np.testing.assert_allclose(gap, truth, atol=1e-12)
    assert set(found.kind) == {FREE, NEAR, COLLIDING}


def test_motions_into_the_slot():
    """A motion called free that scrapes the rim or passes through a wall."""
    model = CSpaceModel.from_shapes({"slot": ConvexPieces(_SLOT), "peg": ConvexPieces([_PEG])})
    path = np.array([[0, 1], [0, -0.4], [0.04, -0.4], [0.04, 1], [1.5, 1], [1.5, -1], [-1.5, -1]])
    found = classify_motions(model, _planar(*path.T), standoff=0.02)
    assert found.kind.tolist() == [FREE, NEAR, NEAR, FREE, FREE, COLLIDING]
    np.testing.assert_allclose(found.distance, [0.05, 0.01, 0.01, 0.5, 0.3, 0], atol=1e-12)
    assert found.time[5] <= (1.5 - 1.2) / 3 + 1
    assert (found.pair == 0).all()


@pytest.mark.parametrize("threads", [1, 2, 8])
def test_turning_motions_are_judged_by_samples(threads):
    """A turning motion certified free in which a sample collides; rows that depend on threads."""
    rng = np.random.default_rng(0)
    model = CSpaceModel.from_shapes({"slot": ConvexPieces(_SLOT), "peg": ConvexPieces([_PEG])})
    path = rng.uniform([-2, -3, -0.7], [2, 2, 0.7], (60, 3))
    found = classify_motions(model, _planar(*path.T), tolerance=1e-4, threads=threads)
    least = []
    for start, end in pairwise(path):
        way = start + np.linspace(0, 1, 50)[:, None] * (end - start)
        least.append(classify(model, _planar(*way.T)).distance.min())
    assert (found.distance <= np.array(least) + 1e-12).all()
    free = found.kind == FREE
    assert free.any()
    assert not free.all()
    again = classify_motions(model, _planar(*path.T), tolerance=1e-4, threads=1)
    assert (again.distance == found.distance).all()


def test_the_first_body_may_be_the_one_that_turns():
    """A turning first body whose turn is mistaken for the second's flight on an arc."""
    rod = _box_mesh([2, 0.1, 0.1])
    post = CSpaceGeometry("post", "post", _box_mesh([0.1, 0.1, 0.1]), pose(p=(0, 0.9, 0)))
    bodies = ["rod", "post"]
    geometries = [CSpaceGeometry("rod", "rod", rod), post]
    turned = Rotation.from_rotvec(np.outer([0, 1.0, 2.0], [0, 0, 1])).as_matrix()
    for order in (bodies, bodies[::-1]):
        model = CSpaceModel(order, geometries, [(0, 1)])
        X = np.tile(np.eye(4), (3, 2, 1, 1))
        X[:, order.index("rod"), :3, :3] = turned
        found = classify_motions(model, X, tolerance=1e-7)
        corner = np.hypot(1, 0.05)  # of the rod, at angle 1 its nearest point to the post
        tip = corner * np.array([np.cos(1 - np.arctan(0.05)), np.sin(1 - np.arctan(0.05))])
        assert found.kind.tolist() == [FREE, COLLIDING]
        near = distance(rod, post.shape, np.linalg.inv(pose(turned[1])) @ post.X_BG).distance
        assert found.distance[0] == pytest.approx(near, abs=1e-6)
        assert near < np.hypot(tip[0] - 0.05, tip[1] - 0.85) + 1e-12


def test_solids_within_solids_collide():
    """A body swallowed whole by another, whose surfaces are apart."""
    large, small = _box_mesh([1, 1, 1]), _box_mesh([0.1, 0.1, 0.1])
    two = CollisionMesh(
        np.vstack([small.vertices, small.vertices + np.array([5, 0, 0])]),
        np.vstack([small.faces, small.faces + 8]),
    )
    lid = np.isclose(large.face_normals, large.face_normals[0]).all(axis=1)
    open_box = CollisionMesh(large.vertices, large.faces[~lid])
    cracked = CollisionMesh(large.vertices, large.faces[1:])  # a facet short of closed: solid still
    poses = _planar(np.array([0.0, -5.0, 2.0]), np.zeros(3))
    for A, B, kinds in (
        (large, small, [COLLIDING, FREE, FREE]),
        (small, large, [COLLIDING, FREE, FREE]),
        (large, two, [COLLIDING, COLLIDING, FREE]),
        (large, ConvexPieces([small.vertices]), [COLLIDING, FREE, FREE]),
        (ConvexPieces([large.vertices]), two, [COLLIDING, COLLIDING, FREE]),
        (cracked, small, [COLLIDING, FREE, FREE]),
        (open_box, small, [FREE, FREE, FREE]),
    ):
        found = classify(CSpaceModel.from_shapes({"A": A, "B": B}), poses)
        assert found.kind.tolist() == kinds
        inside = found.kind == COLLIDING
        assert (found.distance[inside] == 0).all()
        assert (found.p_FCa[inside] == found.p_FCb[inside]).all()
        assert (np.abs(found.p_FCa[inside]) <= 0.5).all()  # of two parts, the one that is inside
    model = CSpaceModel.from_shapes({"A": large, "B": small})
    moves = _planar(np.array([-0.1, 0.1, 2.0]), np.zeros(3))
    assert classify_motions(model, moves).kind.tolist() == [COLLIDING, COLLIDING]


@pytest.mark.parametrize("order", [["large", "small"], ["small", "large"]])
def test_the_witness_of_a_swallowed_body_is_a_point_of_it(order):
    """A point in the wrong frame, or of the wrong body, where one is wholly inside the other."""
    shapes = {"large": _box_mesh([1, 1, 1]), "small": _box_mesh([0.1, 0.1, 0.1])}
    model = CSpaceModel.from_shapes({name: shapes[name] for name in order})
    turn = Rotation.from_rotvec([0.3, -0.5, 0.8]).as_matrix()
    X = {
        "large": pose(turn, (3, -2, 1)),
        "small": pose(turn.T, turn @ (0.2, 0.1, -0.3) + (3, -2, 1)),
    }
    found = classify(model, np.array([[X[name] for name in order]]))
    assert found.kind.tolist() == [COLLIDING]
    for p_F in (found.p_FCa[0], found.p_FCb[0]):
        p = {name: X[name][:3, :3].T @ (p_F - X[name][:3, 3]) for name in order}
        assert signed_distance(shapes["large"], [p["large"]]).distance[0] < -0.1
        assert signed_distance(shapes["small"], [p["small"]]).distance[0] == pytest.approx(
            0, abs=1e-12
        )


def test_closest_pair_and_allowed_pairs():
    """The wrong pair named, or a pair checked that may touch."""
    cube = _box_mesh([1, 1, 1])
    shapes = {"table": cube, "cup": cube, "robot": cube}
    X = np.tile(np.eye(4), (2, 3, 1, 1))
    X[:, 1, 2, 3] = 1.0  # the cup stands on the table
    X[:, 2, 0, 3] = [1.5, 4]
    everything = CSpaceModel.from_shapes(shapes)
    assert everything.pairs == ((0, 1), (0, 2), (1, 2))
    assert classify(everything, X).kind.tolist() == [COLLIDING, COLLIDING]
    model = CSpaceModel.from_shapes(shapes, [("table", "robot"), ("cup", "robot")])
    found = classify(model, X, standoff=0.6)
    assert found.kind.tolist() == [NEAR, FREE]
    np.testing.assert_allclose(found.distance, [0.5, 3])
    assert found.pair.tolist() == [0, 0]
    beyond = classify(model, X, standoff=0.6, upper_bound=1)
    assert beyond.kind.tolist() == [NEAR, FREE]
    assert beyond.distance.tolist() == [0.5, np.inf]
    assert beyond.pair.tolist() == [0, -1]


def test_bad_arguments_are_named():
    """An error that does not say which argument is wrong."""
    cube = _box_mesh([1, 1, 1])
    a, b = (CSpaceGeometry(name, name, cube) for name in "ab")
    with pytest.raises(ValueError, match="two body names are 'a'"):
        CSpaceModel(["a", "a"], [a])
    with pytest.raises(ValueError, match="'b'"):
        CSpaceModel(["a"], [a, b])
    with pytest.raises(ValueError, match="no pair"):
        CSpaceModel(["a"], [a])
    with pytest.raises(ValueError, match="2 geometries"):
        CSpaceModel(["a", "b"], [a, b], [(0, 2)])
    with pytest.raises(ValueError, match="both on 'a'"):
        CSpaceModel(["a"], [a, CSpaceGeometry("b", "a", cube)], [(0, 1)])
    with pytest.raises(ValueError, match="no body 'c'"):
        CSpaceModel.from_shapes({"a": cube, "b": cube}, [("a", "c")])
    with pytest.raises(ValueError, match="X_BG of 'b'"):
        CSpaceModel(["a", "b"], [a, CSpaceGeometry("b", "b", cube, 2 * np.eye(4))])
    model = CSpaceModel.from_shapes({"a": cube, "b": cube})
    X = _planar(np.array([2.0]), np.array([0.0]))
    with pytest.raises(ValueError, match="X_FB"):
        classify(model, X[:, :1])
    with pytest.raises(ValueError, match="standoff"):
        classify(model, X, standoff=-1)
    with pytest.raises(ValueError, match="upper_bound"):
        classify(model, X, standoff=1, upper_bound=0.5)
