"""The solid that a nearly clean mesh bounds, against solids known in closed form.

The mesh keeps its facets; only what is inside, and how deep, is that of the healed boundary.
"""

import pickle
import re

import mesh_shapes
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from contact_toolkit import CollisionMesh, MeshError, _core, signed_distance

pytestmark = pytest.mark.engine


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(11)


V, F = mesh_shapes.cube()
TURNED = F.copy()
TURNED[3] = TURNED[3, ::-1]


def moved(*way: float) -> np.ndarray:
    return V + np.array(way)


def two(second: np.ndarray, *, inwards: bool = False) -> tuple[np.ndarray, np.ndarray]:
    faces = F[:, ::-1] if inwards else F
    return np.vstack([V, second]), np.vstack([F, faces + len(V)])


def outside_boxes(p: np.ndarray, *boxes: tuple[float, float, float]) -> np.ndarray:
    """Signed distance of the union of unit cubes about these points, exact off their edges."""
    return np.min([_box_distance(p - np.array(box)) for box in boxes], axis=0)


def _box_distance(p: np.ndarray) -> np.ndarray:
    q = np.abs(p) - 0.5
    return np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(axis=1), 0)


# name: vertices and faces, volume, what was set right
NEARLY_CLEAN = {
    "one facet doubled": ((V, np.vstack([F, F[4:5]])), "1 facet left out as duplicates"),
    "one doubled the other way": ((V, np.vstack([F, F[4:5, ::-1]])), "1 facet left out as dup"),
    "all doubled the other way": ((V, np.vstack([F, F[:, ::-1]])), "12 facets left out as dup"),
    "all doubled in between": (
        (V, np.stack([F, F[:, ::-1]], axis=1).reshape(-1, 3)),
        "12 facets left out as duplicates",
    ),
    "one facet turned": ((V, TURNED), r"1 facet turned round \(first: facet 3\)"),
    "loose vertex": (
        (np.vstack([V, (V[0] + V[1]) / 2]), np.vstack([F, [[0, 1, 8]]])),
        "1 facet left out without width",
    ),
}


@pytest.mark.parametrize("name", NEARLY_CLEAN)
@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_nearly_clean_cubes(name, turn, rng):
    """A cube refused as open, or of another volume, over one facet given twice."""
    (vertices, faces), said = NEARLY_CLEAN[name]
    R = Rotation.from_rotvec([turn, 2 * turn, -turn])
    mesh = CollisionMesh(R.apply(vertices), faces)
    assert not mesh.defects.closed
    assert len(mesh.faces) == len(faces)
    assert mesh.solid.kind == "closed"
    assert mesh.solid.volume == pytest.approx(1, rel=1e-12)
    assert re.match(said, mesh.solid.repairs)
    points = rng.uniform(-1, 1, (500, 3))
    found = signed_distance(mesh, R.apply(points))
    np.testing.assert_allclose(found.distance, outside_boxes(points, (0, 0, 0)), atol=1e-12)
    clean = signed_distance(CollisionMesh(R.apply(V), F), R.apply(points))
    np.testing.assert_allclose(found.distance, clean.distance, atol=1e-15)
    healed = mesh.repaired()
    assert healed.defects.closed
    assert str(healed.defects.duplicate_facets) == "[]"
    assert pickle.loads(pickle.dumps(mesh)).solid.kind == "closed"


TOUCHING = {
    "at a face": (moved(1, 0, 0), (1, 0, 0)),
    "at an edge": (moved(1, 1, 0), (1, 1, 0)),
    "at a vertex": (moved(1, 1, 1), (1, 1, 1)),
    "at part of a face": (moved(1, 0.3, 0.2), (1, 0.3, 0.2)),
    "overlapping": (moved(0.5, 0.3, 0.2), (0.5, 0.3, 0.2)),
    "across each other": (moved(0.0, 0.9, 0.9), (0, 0.9, 0.9)),
}


@pytest.mark.parametrize("name", TOUCHING)
def test_two_cubes_in_one_mesh(name, rng):
    """Cubes that touch refused as open, or a point within both told to be outside."""
    second, at = TOUCHING[name]
    mesh = CollisionMesh(*two(second))
    assert mesh.solid.kind == "closed"
    assert mesh.solid.volume == pytest.approx(2, rel=1e-12)
    points = np.vstack(
        [rng.uniform(-1, 2, (2000, 3)), 0.5 * np.array(at) + 0.3 * rng.normal(size=(500, 3))]
    )
    expected = outside_boxes(points, (0, 0, 0), at)
    clear = np.abs(expected) > 1e-9
    found = signed_distance(mesh, points).distance
    assert ((found < 0) == (expected < 0))[clear].all()
    outside = expected > 0
    np.testing.assert_allclose(found[outside], expected[outside], atol=1e-12)


def test_a_shared_face_bears_no_load(rng):
    """The wall between two cubes of one mesh taken for a surface to be pushed out of."""
    mesh = CollisionMesh(*two(moved(1, 0, 0)))
    assert len(mesh.solid.inner_facets) == 2
    points = rng.uniform([-0.4, -0.45, -0.45], [1.4, 0.45, 0.45], (500, 3))
    q = np.abs(points - [0.5, 0, 0]) - [1, 0.5, 0.5]
    np.testing.assert_allclose(signed_distance(mesh, points).distance, q.max(axis=1), atol=1e-12)


def test_cavities_and_parts_within():
    """A cavity filled, or a part within another made one."""
    for inwards, volume, inside in [(True, 0.875, False), (False, 1.125, True)]:
        mesh = CollisionMesh(*two(0.5 * V, inwards=inwards))
        assert mesh.solid.kind == "closed"
        assert mesh.solid.volume == pytest.approx(volume)
        assert (signed_distance(mesh, [[0.01, 0.02, 0.03]]).distance[0] < 0) == inside
        assert signed_distance(mesh, [[0.3, 0.02, 0.03]]).distance[0] < 0
    aside = CollisionMesh(*two(V + 3, inwards=True))
    assert aside.solid.volume == pytest.approx(2)
    assert signed_distance(aside, [[3.1, 3, 3]]).distance[0] < 0


def test_a_fin_does_not_cost_the_body():
    """All facets given up for the sake of one edge where three meet."""
    fin = np.array([[0, 1, 8]])
    for faces in (F, F[:-1]):  # closed, and with a hole of its own
        vertices = np.vstack([V, [[-1.0, -0.5, 0.0]]])
        mesh = CollisionMesh(vertices, np.vstack([faces, fin]))
        assert mesh.solid.has_inside
        assert mesh.solid.volume > 0.9
        assert not len(mesh.solid.inner_facets)
        found = signed_distance(mesh, [[0.1, 0, 0], [-0.7, -0.3, 0], [-0.7, -0.7, 0.01]]).distance
        assert list(found < 0) == [True, False, False]


def test_inside_out_has_no_inside():
    """All space solid but for the body."""
    mesh = CollisionMesh(V, F[:, ::-1])
    assert mesh.solid.kind == "inside out"
    assert str(mesh.defects) == "wound inside out"
    with pytest.raises(MeshError, match="wound inside out: its volume is -1 m³"):
        signed_distance(mesh, [[0, 0, 0]])


@pytest.mark.parametrize("kept", [1.0, 0.98])
def test_signs_next_to_a_hole(kept, rng):
    """A ball with a missing cap is open for everything, or its inside leaks out of the hole."""
    vertices, faces = mesh_shapes.ball(4)
    middles = vertices[faces].mean(axis=1)
    cut = faces[middles[:, 2] <= 0.5 * (2 * kept - 1)]
    mesh, whole = CollisionMesh(vertices, cut), CollisionMesh(vertices, faces)
    assert mesh.solid.kind == ("closed" if kept == 1 else "nearly closed")
    assert mesh.solid.openness <= 0.05
    points = rng.uniform(-1, 1, (2000, 3))
    found, expected = signed_distance(mesh, points), signed_distance(whole, points)
    # But for points nearest the cap that is not there: they see its rim, from the right side.
    seen = expected.p_ACa[:, 2] < 0.5 * (2 * kept - 1) - 0.03
    np.testing.assert_allclose(found.distance[seen], expected.distance[seen], atol=1e-12)
    height = np.linalg.norm(points, axis=1) - 0.5
    clear = np.abs(height) > 0.03
    assert ((found.distance < 0) == (height < 0))[clear].all()


def test_cracks_do_not_open_a_solid(rng):
    """Seams a micrometre wide, as exporters leave them, refused as open."""
    vertices, faces = mesh_shapes.ball(3)
    soup = vertices[faces].reshape(-1, 3)
    soup = soup + 1e-6 * rng.normal(size=soup.shape)
    mesh = CollisionMesh(soup, np.arange(len(soup)).reshape(-1, 3))
    assert len(mesh.defects.open_edges) == 3 * len(faces)
    assert mesh.solid.kind == "nearly closed"
    points = rng.uniform(-0.7, 0.7, (1000, 3))
    whole = signed_distance(CollisionMesh(vertices, faces), points).distance
    np.testing.assert_allclose(signed_distance(mesh, points).distance, whole, atol=1e-5)


@pytest.mark.parametrize(
    "shape",
    [
        mesh_shapes.sheet(),
        (V, F[2:]),
        (V, F[[0, 1, 4, 5]]),
        mesh_shapes.soup(60),
    ],
    ids=["sheet", "box without lid", "two walls", "soup"],
)
def test_vessels_and_sheets_stay_open(shape):
    """A bucket filled: what lies in it would be thrown out."""
    mesh = CollisionMesh(*shape)
    assert mesh.solid.kind == "open"
    with pytest.raises(MeshError, match="open edges, the first of facet"):
        signed_distance(mesh, [[0, 0, 0]])


def test_winding_numbers_are_those_of_all_facets(rng):
    """Far facets taken together give the wrong side (broken: an expansion of the wrong sign)."""
    vertices, faces = mesh_shapes.ball(4, bumps=0.1)
    points = np.vstack([rng.uniform(-1, 1, (500, 3)), 20 * rng.normal(size=(50, 3))])
    for cut in (faces, faces[: len(faces) // 3]):
        a, b, c = (vertices[cut[:, k]][None] - points[:, None] for k in range(3))
        la, lb, lc = (np.linalg.norm(x, axis=2) for x in (a, b, c))
        volume = np.einsum("pfi,pfi->pf", a, np.cross(b, c))
        dots = [np.einsum("pfi,pfi->pf", x, y) for x, y in ((a, b), (b, c), (c, a))]
        cosine = la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb
        expected = np.arctan2(volume, cosine).sum(axis=1) / (2 * np.pi)
        found = _core.winding_numbers(CollisionMesh(vertices, cut)._core, points)
        np.testing.assert_allclose(found, expected, atol=2e-2)


def test_same_signs_on_any_number_of_threads(rng):
    """A sign that depends on who asks."""
    vertices, faces = mesh_shapes.ball(3)
    mesh = CollisionMesh(vertices, faces[8:])
    points = rng.uniform(-0.7, 0.7, (5000, 3))
    one, four = (signed_distance(mesh, points, threads=n) for n in (1, 4))
    np.testing.assert_array_equal(one.distance, four.distance)
    np.testing.assert_array_equal(one.gradient_A, four.gradient_A)
