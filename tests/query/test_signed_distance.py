"""Signed distance of points: against every facet tried in extended precision, sign by winding."""

import itertools

import mesh_shapes
import numpy as np
import oracle_brute_force
import pytest
from scipy.spatial.transform import Rotation

from contact_toolkit import CollisionMesh, MeshError, signed_distance

pytestmark = pytest.mark.engine


def wedge(cuts: int, turned: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """A blade of 11°; below, its edge is cut, and facets without area join it to the edge above."""
    middle = [[0, y, 0] for y in np.linspace(-1, 1, cuts + 2)[1:-1] ** 3 + 0.1]
    vertices = [[0, -1, 0], [0, 1, 0], [-1, -1, 0.1], [-1, 1, 0.1], [-1, -1, -0.1], [-1, 1, -0.1]]
    chain = [0, *range(6, 6 + cuts), 1]
    faces = [[0, 1, 3], [0, 3, 2], [1, 4, 5], [2, 3, 5], [2, 5, 4], [0, 2, 4], [1, 5, 3]]
    for a, b in itertools.pairwise(chain):
        faces.append([b, a, 4])
        if a != 0:
            faces.append([0, a, b])
    points = np.array([*vertices, *middle], dtype=float)
    if turned:  # the corners on the edge are then in line to rounding only
        points = points @ Rotation.from_rotvec([0.3, -0.5, 0.7]).as_matrix().T
    return points, np.array(faces)


SHAPES = {
    "cube": mesh_shapes.cube(),
    "doughnut": mesh_shapes.doughnut(),
    "cone": mesh_shapes.cone(),
    "bumpy ball": mesh_shapes.ball(2, bumps=0.3),
    "single precision's worst": (mesh_shapes.ball(2)[0] + [3e4, -7e4, 1e5], mesh_shapes.ball(2)[1]),
    "edge cut in two": wedge(1),
    "edge cut in four": wedge(3),
    "edge cut in four, turned": wedge(3, turned=True),
}


def _points(mesh: CollisionMesh, count: int, seed: int = 0) -> np.ndarray:
    """Points around and inside, close to the surface, on it, and far away."""
    rng = np.random.default_rng(seed)
    middle, size = (mesh.lower + mesh.upper) / 2, mesh.diagonal
    around = middle + rng.uniform(-0.6, 0.6, (count, 3)) * size
    corners = mesh.vertices[mesh.faces[rng.integers(len(mesh.faces), size=count)]]
    on = np.einsum("ij,ijk->ik", rng.dirichlet(np.ones(3), count), corners)
    near = on + 1e-5 * size * rng.normal(size=on.shape)
    beside = corners[:, 0] + 1e-3 * size * rng.normal(size=on.shape)
    far = middle + 1e3 * size * rng.normal(size=(count, 3))
    return np.vstack([around, near, beside, far])


@pytest.mark.parametrize("shape", SHAPES)
def test_equals_brute_force(shape):
    """The hierarchy would skip a closer facet, or take an outside point for an inside one."""
    mesh = CollisionMesh(*SHAPES[shape])
    points = _points(mesh, 60)
    found = signed_distance(mesh, points)
    expected = oracle_brute_force.signed_distance(mesh, points)
    scale = np.abs(points).max(axis=1) + np.abs(mesh.vertices).max()
    assert np.abs(found.distance - expected).max() <= 1e-15 * scale.max()
    assert (np.abs(found.distance - expected) <= 2e-15 * scale).all()


@pytest.mark.parametrize("shape", ["cube", "doughnut", "bumpy ball"])
def test_closest_point_distance_and_gradient_agree(shape):
    """Closest point, facet, distance and gradient would speak of different points."""
    mesh = CollisionMesh(*SHAPES[shape])
    points = _points(mesh, 500)
    found = signed_distance(mesh, points)
    scale = np.abs(points).max(axis=1, keepdims=True)
    foot = points - found.distance[:, None] * found.gradient_A
    assert (np.abs(foot - found.p_ACa) <= 1e-14 * (scale + mesh.diagonal)).all()
    assert np.linalg.norm(found.gradient_A, axis=1) == pytest.approx(1, abs=1e-12)
    corners = mesh.vertices[mesh.faces[found.facet]]
    to_facet, _, _ = oracle_brute_force.triangle_distances(
        corners, np.repeat(found.p_ACa[:, None], 3, axis=1)
    )
    assert to_facet.max() < 1e-15 * mesh.diagonal


def test_pseudonormals_on_vertices_and_edges():
    """Points over a sharp vertex or edge, on the back of one of its facets, would change sign."""
    vertices, faces = mesh_shapes.cube()
    mesh = CollisionMesh(vertices, faces)
    found = signed_distance(mesh, vertices)  # on the vertices themselves
    assert found.distance == pytest.approx(0, abs=1e-16)
    assert found.gradient_A == pytest.approx(vertices / np.linalg.norm(vertices, axis=1)[:, None])
    spike = CollisionMesh(  # a needle: facets of the tip look almost everywhere
        [[0.01, 0, 0], [-0.005, 0.009, 0], [-0.005, -0.009, 0], [0.3, 0.2, 1]],
        [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    )
    directions = np.random.default_rng(1).normal(size=(2000, 3))
    around_tip = spike.vertices[3] + 1e-3 * directions
    expected = oracle_brute_force.signed_distance(spike, around_tip)
    assert signed_distance(spike, around_tip).distance == pytest.approx(
        expected.astype(float), abs=1e-15
    )


def test_cavity_is_outside():
    """The hollow of a shell would count as material."""
    outer, faces = mesh_shapes.ball(2, radius=1.0)
    inner, _ = mesh_shapes.ball(2, radius=0.5)
    shell = CollisionMesh(
        np.vstack([outer, inner]), np.vstack([faces, faces[:, ::-1] + len(outer)])
    )
    found = signed_distance(shell, [[0, 0, 0], [0.75, 0, 0], [1.25, 0, 0]])
    assert np.sign(found.distance).tolist() == [1, -1, 1]


def test_lowest_facet_where_several_are_closest():
    """The facet reported would depend on the order of the points or on their number."""
    mesh = CollisionMesh(*SHAPES["doughnut"])
    points = mesh.vertices[np.random.default_rng(2).permutation(len(mesh.vertices))]
    facet = signed_distance(mesh, points).facet
    touching = [
        np.flatnonzero((mesh.vertices[mesh.faces] == point).all(axis=2).any(axis=1))[0]
        for point in points
    ]
    assert facet.tolist() == touching


@pytest.mark.threads
def test_same_bits_whatever_the_threads_and_the_order():
    """The answer would depend on the neighbouring points through the hint, or on the threads."""
    mesh = CollisionMesh(*SHAPES["bumpy ball"])
    points = _points(mesh, 1000)
    shuffle = np.random.default_rng(3).permutation(len(points))
    one, many = signed_distance(mesh, points), signed_distance(mesh, points, threads=3)
    mixed = signed_distance(mesh, points[shuffle])
    for name in ("distance", "p_ACa", "gradient_A", "facet"):
        assert (getattr(one, name) == getattr(many, name)).all()
        assert (getattr(one, name)[shuffle] == getattr(mixed, name)).all()


def test_no_points():
    """An empty batch would raise."""
    assert len(signed_distance(CollisionMesh(*mesh_shapes.cube()), np.empty((0, 3)))) == 0


def test_errors_name_the_mend():
    """A caller's mistake would pass, or be reported without saying what to do."""
    cube = CollisionMesh(*mesh_shapes.cube())
    with pytest.raises(MeshError, match=r"an inside.*open edges.*fill the holes"):
        signed_distance(CollisionMesh(*mesh_shapes.sheet()), [[0, 0, 0]])
    with pytest.raises(ValueError, match=r"\(n, 3\), not \(3,\)"):
        signed_distance(cube, [0, 0, 0])
    with pytest.raises(ValueError, match=r"point 1 is .*nan.*finite"):
        signed_distance(cube, [[0, 0, 0], [0, np.nan, 0]])
    with pytest.raises(ValueError, match="threads must be at least 1"):
        signed_distance(cube, [[0, 0, 0]], threads=0)
