"""CollisionMesh.from_file: every format, and files that are broken in every way we have met."""

import struct

import mesh_shapes
import numpy as np
import pytest
import trimesh

from contact_toolkit import CollisionMesh, MeshError
from contact_toolkit.shapes.mesh_files import read_obj

_FORMATS = ["obj", "stl", "stl_ascii", "ply", "off", "glb"]


def _saved(folder, name, data):
    path = folder / name
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return path


def _exported(file_type):
    mesh = trimesh.Trimesh(*mesh_shapes.ball(1), process=False)
    data = mesh.export(file_type=file_type)
    return data if isinstance(data, bytes) else data.encode()


@pytest.mark.parametrize("file_type", _FORMATS)
def test_every_format(tmp_path, file_type):
    """Facets lost, reordered or turned over on the way in."""
    path = _saved(tmp_path, f"ball.{file_type.partition('_')[0]}", _exported(file_type))
    vertices, faces = mesh_shapes.ball(1)
    mesh = CollisionMesh.from_file(path)
    np.testing.assert_allclose(mesh.vertices[mesh.faces], vertices[faces], rtol=0, atol=1e-7)
    assert mesh.defects.closed
    half = CollisionMesh.from_file(str(path), scale=0.5)
    np.testing.assert_allclose(half.vertices, mesh.vertices / 2, rtol=1e-15)
    assert CollisionMesh.from_file(path.rename(path.with_suffix(path.suffix.upper()))).area > 0


def test_from_trimesh():
    vertices, faces = mesh_shapes.cube()
    mesh = CollisionMesh.from_trimesh(trimesh.Trimesh(vertices, faces, process=False))
    np.testing.assert_array_equal(mesh.vertices, vertices)
    np.testing.assert_array_equal(mesh.faces, faces)


_TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"


def test_obj_with_everything(tmp_path):
    """Textures, normals, colours, groups, comments, polygons, continued lines, negative indices."""
    text = (
        "# a comment\nmtllib x.mtl\no thing\nv 0 0 0 1 0 0\nv 1 0 0 1 1 1\r\nv 1 1 0\n"
        "vt 0 0\nvn 0 0 1\nv 0 1 0  # last\ng group\nusemtl m\ns off\n"
        "f 1/1/1 2//1 3/1 \\\n 4\nl 1 2\nf -4 -2 -1\n"
    )
    mesh = CollisionMesh.from_file(_saved(tmp_path, "x.obj", text))
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [0, 2, 3], [0, 2, 3]])


def _lines_of(text):
    """What the reader gives that goes line by line: it never takes a file with a comment whole."""
    return read_obj(b"# line by line\n" + text.encode())


def test_plain_obj_is_read_as_line_by_line():
    """Written by programs, it is read in one go; every bit must be the same."""
    rng = np.random.default_rng(0)
    vertices = rng.normal(size=(500, 3)) * 10.0 ** rng.integers(-300, 300, (500, 3))
    facets = rng.integers(0, 500, (900, 3))
    text = "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in vertices.tolist())
    text += "".join(f"f {a} {b} {c}\n" for a, b, c in (facets + 1).tolist())
    for found, expected in zip(read_obj(text.encode()), _lines_of(text), strict=True):
        assert found.dtype == expected.dtype
        assert found.tobytes() == expected.tobytes()
    np.testing.assert_array_equal(read_obj(text.encode())[0], vertices)


@pytest.mark.parametrize(
    "text",
    [
        "v 1 2\n3 v 1 2 3\nf 1 1 1\n",
        _TRIANGLE + "f 1 2\n3 f 1 2 3\n",
        _TRIANGLE + "f 1 2 4\n",
        _TRIANGLE + "f 0 1 2\n",
        _TRIANGLE + "f 1 2 99999999999\n",
        "v 1-2 0 0\nf 1 1 1\n",
    ],
)
def test_an_obj_that_is_almost_plain_is_refused(text):
    with pytest.raises(MeshError) as plain:
        read_obj(text.encode())
    with pytest.raises(MeshError):
        _lines_of(text)
    assert plain.match("line [1-4]")


_PLY = (
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
)
_OFF = "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n"
_FACET = (
    "facet normal 0 0 1\nouter loop\nvertex 0 0 {}\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
)

_BROKEN = {
    "range.obj": (_TRIANGLE + "f 1 2 3\nf 1 2 99\n", "line 5.*vertex 99.*3 vertices"),
    "from_zero.obj": (_TRIANGLE + "f 0 1 2\n", "line 4.*vertex 0.*count from 1"),
    "before_the_first.obj": (_TRIANGLE + "f -1 -2 -4\n", "line 4.*vertex 0"),
    "two_corners.obj": (_TRIANGLE + "f 1 2 3\nf 1 2\n", "line 5.*three corners"),
    "letters.obj": (_TRIANGLE + "f a b c\n", "line 4.*'a'"),
    "flat.obj": ("v 0 0\nv 1 0\nv 0 1\nf 1 2 3\n", "line 1.*three numbers"),
    "word.obj": ("v 0 0 zero\n", "line 1.*three numbers"),
    "nan.obj": (_TRIANGLE + "v 0 nan 0\nf 1 2 3\nf 1 2 4\n", "vertex 3 of facet 1.*NaN"),
    "infinite.obj": (_TRIANGLE + "v 0 inf 0\nf 1 2 4\n", "vertex 3 of facet 0.*infinite"),
    "empty.obj": ("", "the file is empty"),
    "only_points.obj": (_TRIANGLE, "no facet"),
    "only_facets.obj": ("f 1 2 3\n", "line 1.*0 vertices"),
    "binary.obj": (bytes(range(256)), "no facet"),
    "nan.stl": (f"solid\n{_FACET.format(0)}{_FACET.format('nan')}endsolid\n", "facet 1.*NaN"),
    "cut.stl": (f"solid\n{_FACET.format(0)}", "cut off"),
    "empty.stl": ("", "the file is empty"),
    "no_facet.stl": ("solid\nendsolid\n", "no facet"),
    "text.stl": ("hello world", "neither text nor"),
    "34_bytes.stl": (bytes(34), "neither text nor"),
    "cut_binary.stl": (_exported("stl")[:300], "promises 32 facets and holds 4"),
    "count.stl": (
        _exported("stl")[:80] + struct.pack("<I", 2**31) + _exported("stl")[84:],
        "promises 2147483648 facets and holds 32",
    ),
    "nan_binary.stl": (
        _exported("stl")[:96] + struct.pack("<f", np.nan) + _exported("stl")[100:],
        "facet 0.*NaN",
    ),
    "range.off": (_OFF + "3 0 1 2\n3 0 1 7\n", "line 7.*vertex 7.*count from 0"),
    "negative.off": (_OFF + "3 0 1 2\n3 0 1 -1\n", "line 7.*vertex -1"),
    "short.off": (_OFF + "3 0 1 2\n", "1 of 2 facets"),
    "shorter.off": ("OFF\n3 2 0\n0 0 0\n", "1 of 3 vertices"),
    "nan.off": (_OFF.replace("0 1 0", "0 nan 0") + "3 0 1 2\n3 0 2 1\n", "vertex 2.*NaN"),
    "header.off": ("OBJ\n", "line 1.*OFF"),
    "no_counts.off": ("OFF\n", "numbers of vertices"),
    "empty.off": ("", "the file is empty"),
    "range.ply": (_PLY + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 9\n", "facet 1.*vertex 9"),
    "nan.ply": (_PLY + "0 0 0\n1 0 0\n0 nan 0\n3 0 1 2\n3 0 2 1\n", "vertex 2.*NaN"),
    "short.ply": (_PLY + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "promises 2 facets and holds 1"),
    "cut.ply": (_exported("ply")[:-20], "not a readable .ply"),
    "header.ply": ("ply\n", "not a readable .ply|no facet"),
    "empty.ply": ("", "the file is empty"),
    "cut.glb": (_exported("glb")[:500], "not a readable .glb"),
    "text.glb": ("hello world", "does not begin with glTF"),
    "empty.glb": ("", "the file is empty"),
    "drawing.dxf": ("", r"cannot read \.dxf.*\.obj"),
    "archive.zip": ("PK", r"cannot read \.zip"),
    "nothing": ("", "without suffix"),
}


@pytest.mark.parametrize("name", _BROKEN)
def test_broken_file(tmp_path, name):
    """A facet dropped in silence, or an error that says neither file, nor place, nor mend."""
    data, message = _BROKEN[name]
    path = _saved(tmp_path, name, data)
    with pytest.raises(MeshError, match=message) as error:
        CollisionMesh.from_file(path)
    assert str(error.value).startswith(str(path))


def test_missing_file(tmp_path):
    with pytest.raises(MeshError, match=r"none\.obj: no such file"):
        CollisionMesh.from_file(tmp_path / "none.obj")
    with pytest.raises(MeshError, match="no such file"):
        CollisionMesh.from_file(tmp_path)


@pytest.mark.parametrize("scale", [0.0, -1.0, np.nan, np.inf])
def test_bad_scale(tmp_path, scale):
    """A mesh turned inside out or into a point."""
    path = _saved(tmp_path, "x.obj", _TRIANGLE + "f 1 2 3\n")
    with pytest.raises(MeshError, match="scale"):
        CollisionMesh.from_file(path, scale)


def test_scale_that_overflows(tmp_path):
    path = _saved(tmp_path, "x.obj", "v 0 0 0\nv 1e300 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(MeshError, match=r"vertex 1 of facet 0.*infinite"):
        CollisionMesh.from_file(path, 1e10)


def test_giant_file(tmp_path):
    """Reading it would fill the memory before anyone is asked."""
    path = tmp_path / "giant.stl"
    with path.open("wb") as file:
        file.truncate((1 << 30) + 1)  # a hole: takes no disk
    with pytest.raises(MeshError, match="1 GiB"):
        CollisionMesh.from_file(path)
