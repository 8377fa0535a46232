"""Polygons of mesh files cut into triangles, against their areas and sides by closed form."""

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from contact_toolkit import CollisionMesh
from contact_toolkit.shapes.polygons import triangulate

# A U-profile: 100 mm wide, 60 mm high, with a slot of 60 x 40 mm, 200 mm long.
PROFILE = 1e-3 * np.array(
    [[0, 0], [100, 0], [100, 60], [80, 60], [80, 20], [20, 20], [20, 60], [0, 60]], dtype=float
)
CAP = 0.1 * 0.06 - 0.06 * 0.04
PERIMETER = 2 * (0.1 + 0.06) + 2 * 0.04
LENGTH = 0.2


def u_block() -> tuple[np.ndarray, list[list[int]]]:
    n = len(PROFILE)
    vertices = np.vstack([np.column_stack([PROFILE, np.full(n, z)]) for z in (0.0, LENGTH)])
    sides = [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    return vertices, [list(range(n))[::-1], list(range(n, 2 * n)), *sides]


def written(kind: str) -> bytes:
    vertices, polygons = u_block()
    if kind == "obj":
        lines = [f"v {x} {y} {z}" for x, y, z in vertices]
        lines += ["f " + " ".join(str(i + 1) for i in polygon) for polygon in polygons]
        return "\n".join(lines).encode()
    rows = [f"{len(p)} " + " ".join(map(str, p)) for p in polygons]
    points = [f"{x} {y} {z}" for x, y, z in vertices]
    if kind == "off":
        return "\n".join(["OFF", f"{len(points)} {len(rows)} 0", *points, *rows]).encode()
    form = {"ply": "ascii", "ply_binary": "binary_little_endian", "ply_big": "binary_big_endian"}
    header = (
        f"ply\nformat {form[kind]} 1.0\nelement vertex {len(points)}\nproperty double x\n"
        f"property double y\nproperty double z\nelement face {len(rows)}\n"
        "property list uchar int vertex_indices\nend_header\n"
    ).encode()
    if kind == "ply":
        return header + "\n".join([*points, *rows, ""]).encode()
    order = "<" if kind == "ply_binary" else ">"
    body = vertices.astype(f"{order}f8").tobytes()
    for polygon in polygons:
        body += struct.pack(f"{order}B{len(polygon)}i", len(polygon), *polygon)
    return header + body


@pytest.mark.parametrize("kind", ["obj", "off", "ply", "ply_binary", "ply_big"])
def test_concave_faces_of_a_u_profile(kind, tmp_path):
    """The slot closed by facets across it: 0.1516 m² of surface instead of 0.0872."""
    path = tmp_path / f"block.{kind.partition('_')[0]}"
    path.write_bytes(written(kind))
    mesh = CollisionMesh.from_file(path)
    assert mesh.defects.closed
    assert mesh.area == pytest.approx(2 * CAP + PERIMETER * LENGTH, rel=1e-12)
    assert mesh.volume == pytest.approx(CAP * LENGTH, rel=1e-12)


def area_of(vertices, triangles) -> float:
    corners = vertices[np.array(triangles)]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return 0.5 * np.linalg.norm(normals, axis=1).sum()


def boundary_of(triangles) -> set[tuple[int, int]]:
    sides = {(t[k], t[(k + 1) % 3]) for t in triangles for k in range(3)}
    return {side for side in sides if side[::-1] not in sides}


@given(
    radii=st.lists(st.floats(0.2, 1.0), min_size=4, max_size=24),
    turn=st.tuples(*[st.floats(-3, 3)] * 3),
    lift=st.floats(0, 1e-3),
    between=st.booleans(),
)
def test_star_shaped_polygons(radii, turn, lift, between):
    """Area lost or doubled, or a side that no triangle has: a neighbour comes loose."""
    angles = 2 * np.pi * np.arange(len(radii)) / len(radii)
    flat = np.array(radii)[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    if between:  # a corner in the middle of every side
        flat = np.stack([flat, (flat + np.roll(flat, -1, axis=0)) / 2], axis=1).reshape(-1, 2)
    x, y = flat.T
    expected = 0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum()
    wobble = lift * (np.arange(len(flat)) % 3 - 1)
    vertices = Rotation.from_rotvec(turn).apply(np.column_stack([flat, wobble]))
    triangles = triangulate(vertices, [list(range(len(flat)))])
    count = len(flat)
    assert len(triangles) == count - 2
    assert boundary_of(triangles) == {(i, (i + 1) % count) for i in range(count)}
    assert area_of(vertices, triangles) == pytest.approx(expected, rel=1e-9 + 300 * lift)


@pytest.mark.parametrize(
    "corners",
    [
        [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]],
        [[0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]],
        [[0, 0, 0], [1, 1, 0], [1, 0, 0], [0, 1, 0]],
        [[0, 0, 0], [1, 0, 0], [np.nan, 1, 0], [0, 1, 0]],
    ],
    ids=["on a line", "one point", "crosses itself", "not a number"],
)
def test_polygons_without_an_inside(corners):
    """A reader that hangs or drops sides where there is nothing to cut."""
    triangles = triangulate(np.array(corners, dtype=float), [[0, 1, 2, 3]])
    assert len(triangles) == 2
    assert {i for triangle in triangles for i in triangle} == {0, 1, 2, 3}
