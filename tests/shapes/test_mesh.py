"""CollisionMesh from arrays: tables, welding, adjacency, defects, and every kind of bad input."""

import subprocess
import sys

import mesh_shapes
import numpy as np
import pytest

from contact_toolkit import CollisionMesh, MeshError

pytestmark = pytest.mark.engine

_CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
_TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def _mesh(shape):
    return CollisionMesh(*shape)


# --- tables --------------------------------------------------------------------------------------


def test_tables_of_a_tetrahedron():
    """Edges, their order, or a facet's edges numbered wrongly."""
    mesh = CollisionMesh(_CORNERS, _TETRAHEDRON)
    np.testing.assert_array_equal(mesh.vertices, _CORNERS)
    np.testing.assert_array_equal(mesh.faces, _TETRAHEDRON)
    np.testing.assert_array_equal(mesh.edges, [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]])
    for face, edges in zip(mesh.faces, mesh.face_edges, strict=True):
        for k in range(3):
            assert set(mesh.edges[edges[k]]) == {face[k], face[(k + 1) % 3]}
    np.testing.assert_allclose(mesh.face_normals[0], [0, 0, -1])
    np.testing.assert_allclose(mesh.face_normals[3], np.full(3, 1 / np.sqrt(3)))
    assert mesh.volume == pytest.approx(1 / 6)
    assert mesh.area == pytest.approx(1.5 + np.sqrt(3) / 2)
    np.testing.assert_array_equal([mesh.lower, mesh.upper], [[0, 0, 0], [1, 1, 1]])
    assert mesh.diagonal == pytest.approx(np.sqrt(3))
    assert mesh.defects.closed


def test_dtypes_and_immutability():
    """A caller could change a mesh under a query that runs without the GIL."""
    vertices = _CORNERS.copy()
    mesh = CollisionMesh(vertices, _TETRAHEDRON[:3])
    vertices[:] = 7
    assert mesh.vertices.max() == 1
    for table, dtype in [
        (mesh.vertices, np.float64),
        (mesh.faces, np.int32),
        (mesh.edges, np.int32),
        (mesh.face_edges, np.int32),
        (mesh.face_normals, np.float64),
        (mesh.welded, np.int32),
        (mesh.defects.open_edges, np.int32),
    ]:
        assert table.dtype == dtype
        assert not table.flags.writeable
    with pytest.raises(AttributeError):
        mesh.vertices = vertices


def test_tables_outlive_the_mesh():
    """A table that points into freed memory."""
    vertices = CollisionMesh(_CORNERS, _TETRAHEDRON).vertices
    trash = [CollisionMesh(_CORNERS + k, _TETRAHEDRON) for k in range(50)]
    np.testing.assert_array_equal(vertices, _CORNERS)
    assert len(trash) == 50


@pytest.mark.parametrize(
    ("shape", "volume"),
    [
        (mesh_shapes.cube(), 1.0),
        (mesh_shapes.doughnut(96, 96), 2 * np.pi**2 * 0.05 * 0.02**2),
        (mesh_shapes.ball(4), np.pi / 6),
    ],
    ids=["cube", "doughnut", "ball"],
)
def test_volume_and_closure(shape, volume):
    """The sign of the winding, or the divergence theorem, got wrong."""
    mesh = _mesh(shape)
    assert mesh.defects.closed
    assert str(mesh.defects) == "none"
    assert mesh.volume == pytest.approx(volume, rel=1e-2)
    assert _mesh((shape[0] + 1e3, shape[1])).volume == pytest.approx(mesh.volume, rel=1e-6)
    vertices, edges, facets = len(mesh.vertices), len(mesh.edges), len(mesh.faces)
    assert vertices - edges + facets == (0 if volume < 0.01 else 2)  # Euler


# --- welding -------------------------------------------------------------------------------------


def test_soup_gets_its_adjacency_back():
    """An STL's triangles know nothing of each other; unwelded, every edge would be a boundary."""
    vertices, faces = mesh_shapes.doughnut(8, 6)
    soup = CollisionMesh(vertices[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3))
    assert soup.defects.closed
    assert len(soup.vertices) == len(vertices)
    np.testing.assert_array_equal(soup.vertices[soup.faces], vertices[faces])
    np.testing.assert_array_equal(soup.vertices[soup.welded], vertices[faces].reshape(-1, 3))


def test_welding_is_exact():
    """Vertices a hair apart are different; zeros of either sign are the same."""
    apart = _CORNERS[[0, 0, 1, 2]] + [[0, 0, 0], [1e-300, 0, 0], [0, 0, 0], [0, 0, 0]]
    assert len(CollisionMesh(apart, [[0, 2, 3], [1, 3, 2]]).vertices) == 4
    signed = np.array([[0.0, 0, 0], [-0.0, 0, -0.0], [1, 0, 0], [0, 1, 0]])
    assert len(CollisionMesh(signed, [[0, 2, 3], [1, 3, 2]]).vertices) == 3


# --- tolerated defects ---------------------------------------------------------------------------


def test_open_boundary():
    """A hole not seen: an inside would be claimed that is none."""
    mesh = CollisionMesh(_CORNERS, _TETRAHEDRON[:3])
    np.testing.assert_array_equal(mesh.edges[mesh.defects.open_edges], [[1, 2], [1, 3], [2, 3]])
    assert not mesh.defects.closed
    assert "3 open edges" in str(mesh.defects)


def test_non_manifold_edge():
    """Three leaves on one spine."""
    vertices = np.array([[0.0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0]])
    mesh = CollisionMesh(vertices, [[0, 1, 2], [0, 1, 3], [0, 1, 4]])
    np.testing.assert_array_equal(mesh.edges[mesh.defects.non_manifold_edges], [[0, 1]])
    assert not mesh.defects.closed


def test_inconsistent_winding():
    """One facet of a closed surface turned over."""
    faces = _TETRAHEDRON.copy()
    faces[3] = faces[3, ::-1]
    mesh = CollisionMesh(_CORNERS, faces)
    np.testing.assert_array_equal(
        mesh.edges[mesh.defects.inconsistent_edges], [[1, 2], [1, 3], [2, 3]]
    )
    assert not mesh.defects.closed


def test_inside_out_is_closed_with_negative_volume():
    """Consistently inverted winding is no defect of adjacency, but must show."""
    mesh = CollisionMesh(_CORNERS, _TETRAHEDRON[:, ::-1])
    assert mesh.defects.closed
    assert mesh.volume == pytest.approx(-1 / 6)


def test_zero_area_and_duplicate_facets_are_kept():
    """Facets dropped silently would shift every facet index after them."""
    faces = [*_TETRAHEDRON, [0, 0, 1], [1, 3, 0], [2, 2, 2]]
    mesh = CollisionMesh(_CORNERS, faces)
    np.testing.assert_array_equal(mesh.faces, faces)
    np.testing.assert_array_equal(mesh.defects.zero_area_facets, [4, 6])
    np.testing.assert_array_equal(mesh.defects.duplicate_facets, [5])
    np.testing.assert_array_equal(mesh.face_normals[[4, 6]], np.zeros((2, 3)))
    assert np.isfinite(mesh.face_normals).all()


def test_collinear_facet_has_zero_area():
    """Three different corners on a line."""
    mesh = CollisionMesh([[0, 0, 0], [1, 1, 1], [2, 2, 2], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    np.testing.assert_array_equal(mesh.defects.zero_area_facets, [0])


def test_unused_vertices_are_listed():
    """A stray vertex must neither move the bounding box nor vanish from the table."""
    mesh = CollisionMesh([*_CORNERS, [50, 50, 50]], _TETRAHEDRON)
    np.testing.assert_array_equal(mesh.defects.unused_vertices, [4])
    np.testing.assert_array_equal(mesh.upper, [1, 1, 1])


# --- accepted forms of arrays --------------------------------------------------------------------


@pytest.mark.parametrize("dtype", [np.float32, np.float16, ">f8", ">f4", np.int64, np.uint8])
def test_any_real_dtype_of_vertices(dtype):
    """Bytes taken for doubles as they lie."""
    np.testing.assert_array_equal(
        CollisionMesh(_CORNERS.astype(dtype), _TETRAHEDRON).vertices, _CORNERS
    )


@pytest.mark.parametrize("dtype", [np.int64, np.uint32, np.uint64, np.int8, ">i4", ">i8"])
def test_any_integer_dtype_of_faces(dtype):
    """Bytes taken for 32-bit indices as they lie."""
    np.testing.assert_array_equal(
        CollisionMesh(_CORNERS, _TETRAHEDRON.astype(dtype)).faces, _TETRAHEDRON
    )


@pytest.mark.parametrize(
    "form",
    [
        np.asfortranarray,
        lambda a: np.repeat(a, 2, axis=0)[::2],
        lambda a: np.pad(a, ((0, 0), (2, 3)))[:, 2:-3],
        lambda a: a[::-1][::-1],
        lambda a: np.frombuffer(a.tobytes(), a.dtype).reshape(a.shape),  # read-only
        np.ndarray.tolist,
    ],
    ids=["fortran", "strided", "columns", "reversed", "read-only", "lists"],
)
def test_any_memory_layout(form):
    """Strides or writeability assumed."""
    mesh = CollisionMesh(form(_CORNERS), form(_TETRAHEDRON))
    np.testing.assert_array_equal(mesh.vertices, _CORNERS)
    np.testing.assert_array_equal(mesh.faces, _TETRAHEDRON)


# --- rejected ------------------------------------------------------------------------------------


def _with(index, value):
    vertices = _CORNERS.copy()
    vertices[index] = value
    return vertices


@pytest.mark.parametrize(
    ("vertices", "message"),
    [
        (_with((2, 1), np.nan), r"vertex 2 of facet 0 .*NaN"),
        (_with((3, 0), np.inf), r"vertex 3 of facet 1 .*infinite"),
        (_with((3, 2), -np.inf), r"vertex 3 of facet 1 .*infinite"),
        (_with((1, 1), 1e30), r"vertex 1 of facet 0 .*1e\+?15"),
        (_with((1, 1), -1e300), r"vertex 1 of facet 0 .*1e\+?15"),
        (_CORNERS * 1e-310, r"across.*scale"),
        (_CORNERS[[0, 0, 0, 0]], r"one point"),
        (_CORNERS[:3], r"facet 1 .*vertex 3"),
        (_CORNERS[:1], r"facet 0 .*vertex 2"),
        (np.empty((0, 3)), r"facet 0 .*no vert"),
        (_CORNERS[:, :2], r"vertices .*\(n, 3\).*\(4, 2\)"),
        (_CORNERS.ravel(), r"vertices .*\(n, 3\).*\(12,\)"),
        (_CORNERS[None], r"vertices .*\(n, 3\).*\(1, 4, 3\)"),
        (5.0, r"vertices .*\(n, 3\)"),
        (None, r"vertices .*object"),
        (_CORNERS.astype(complex), r"vertices .*real.*complex"),
        (_CORNERS.astype(str), r"vertices .*real"),
        (_CORNERS.astype(object), r"vertices .*real.*object"),
        (_CORNERS > 0, r"vertices .*real.*bool"),
        ([[0, 0, 0], [1, 0], [0, 1, 0]], r"vertices .*rectangular"),
    ],
)
def test_bad_vertices(vertices, message):
    """An error that does not say what is wrong and where, or none."""
    with pytest.raises(MeshError, match=message):
        CollisionMesh(vertices, _TETRAHEDRON)


@pytest.mark.parametrize(
    ("faces", "message"),
    [
        ([[0, 1, 2], [0, 1, 4]], r"facet 1 .*vertex 4.*0 to 3"),
        ([[0, 1, 2], [0, -1, 2]], r"facet 1 .*-1.*from 0"),
        (np.array([[0, 1, 2], [0, 1, 2**31]]), r"facet 1 .*2147483648"),
        (np.array([[0, 1, 2**63]], np.uint64), r"facet 0 .*9223372036854775808"),
        (np.array([[0, 1, -(2**63)]]), r"facet 0 .*-9223372036854775808"),
        ([], "no facet"),
        (np.empty((0, 3), np.int32), "no facet"),
        (np.empty((0, 3), float), "no facet"),
        ([[0, 1]], r"faces .*\(n, 3\).*\(1, 2\)"),
        ([[0, 1, 2, 3]], r"faces .*\(n, 3\).*\(1, 4\)"),
        ([0, 1, 2], r"faces .*\(n, 3\).*\(3,\)"),
        (np.empty((0, 3, 3), np.int32), r"faces .*\(n, 3\)"),
        (_TETRAHEDRON.astype(float), r"faces .*integer.*float64"),
        (_TETRAHEDRON > 0, r"faces .*integer.*bool"),
        (_TETRAHEDRON.astype(object), r"faces .*integer.*object"),
        ([["a", "b", "c"]], r"faces .*integer"),
        (None, r"faces .*object"),
        ([[0, 1, 2], [0, 1]], r"faces .*rectangular"),
    ],
)
def test_bad_faces(faces, message):
    """An error that does not say what is wrong and where, or none."""
    with pytest.raises(MeshError, match=message):
        CollisionMesh(_CORNERS, faces)


def test_mesh_error_is_a_value_error():
    """Callers who know nothing of us catch ValueError."""
    assert issubclass(MeshError, ValueError)


# --- hierarchies that could recurse without end ---------------------------------------------------


@pytest.mark.parametrize(
    "corners",
    [
        np.zeros((3000, 1)),
        2.0 ** -np.arange(1000.0)[:, None],
        np.repeat([[0.0], [1.0]], 1500, axis=0),
        np.linspace(0, 1, 3000)[:, None],
    ],
    ids=["all in one place", "halving", "two places", "a row"],
)
def test_awkward_hierarchies(corners):
    """A builder that never splits, or splits off one facet at a time until the stack ends."""
    triangle = np.array([[0.0, 0, 0], [0, 1, 0], [0, 0, 1]])
    vertices = triangle + np.pad(corners, ((0, 0), (0, 2)))[:, None]
    mesh = CollisionMesh(vertices.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
    assert len(mesh.faces) == len(corners)


_FUZZ = """
import numpy as np
from contact_toolkit import CollisionMesh, MeshError

rng = np.random.default_rng(0)
values = [0.0, 1.0, -1.0, 1e-310, 1e300, np.nan, np.inf, -np.inf, 1e15, 1e-16, 0.5]
indices = [0, 1, 2, 3, 4, -1, 7, 2**31 - 1, 2**31, -(2**31), 2**40]
outcome = {"mesh": 0, "error": 0}
for trial in range(3000):
    wild = trial % 2
    nv, nf = rng.integers(0, 6, 2)
    shapes = [(nv, 3), (nf, 3)] if rng.random() < 0.9 else [(nv, 2), (nf, 3, 1)]
    vertices = rng.choice(values, shapes[0]) if wild else rng.integers(0, 3, shapes[0]) * 1.0
    faces = rng.choice(indices[: 11 if wild else 5], shapes[1])
    if rng.random() < 0.3:
        vertices = vertices.astype(rng.choice(["f4", ">f8", "f2", "O", "i1"]), casting="unsafe")
    try:
        mesh = CollisionMesh(vertices, faces)
        assert len(mesh.faces) == nf and np.isfinite(mesh.face_normals).all()
        outcome["mesh"] += 1
    except MeshError as error:
        assert len(str(error)) > 20
        outcome["error"] += 1
assert min(outcome.values()) > 200, outcome
"""


def test_fuzzed_arrays_never_crash_the_interpreter():
    """In a process of its own: anything but a mesh or a MeshError."""
    run = subprocess.run(
        [sys.executable, "-W", "ignore::RuntimeWarning", "-X", "faulthandler", "-c", _FUZZ],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert run.returncode == 0, run.stderr
