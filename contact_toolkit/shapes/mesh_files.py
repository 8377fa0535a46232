"""Mesh files, read whole or not at all.

The text formats in which a broken line would go unnoticed are read here, so that an error can name
it; the others are read by trimesh, whose facets are counted against what the file promises.
"""

from __future__ import annotations

import io
import re
import struct
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from contact_toolkit import _core
from contact_toolkit.shapes.ply_files import read_ply
from contact_toolkit.shapes.polygons import triangulate

MeshError = _core.MeshError

Triangles: TypeAlias = tuple[NDArray[np.float64], NDArray[np.int64]]

_MAX_FILE_BYTES = 1 << 30  # a gigabyte of text is some ten million facets
_STL_HEADER, _STL_FACET = 84, 50  # [bytes]


def read_mesh_file(path: Path) -> Triangles:
    """Read vertices (nv, 3) and facets (nf, 3) of an .obj, .stl, .ply, .off, .glb or .gltf file.

    Polygons are cut into triangles, see `triangulate`. Raises MeshError naming the file, the place
    and the mend.
    """
    if not path.is_file():
        raise MeshError(f"{path}: no such file")
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise MeshError(
            f"{path}: cannot read {path.suffix or 'a file without suffix'}; "
            f"convert it to one of {', '.join(_READERS)}"
        )
    if path.stat().st_size > _MAX_FILE_BYTES:
        raise MeshError(f"{path}: larger than 1 GiB; simplify the mesh")
    data = path.read_bytes()
    if not data.strip():
        raise MeshError(f"{path}: the file is empty; export it again")
    try:
        return reader(data, path)
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from error


def read_obj(data: bytes) -> Triangles:
    """Read vertices (nv, 3) and facets (nf, 3) of a Wavefront OBJ file's contents.

    Everything but positions and facets is skipped. Raises MeshError naming the line.
    """
    if (plain := _read_plain_obj(data)) is not None:
        return plain
    positions: list[list[float]] = []
    polygons: list[tuple[int, list[int]]] = []
    for line, words in _lines(data.replace(b"\\\n", b" ")):
        if words[0] == "v":
            positions.append(_position(words[1:4], line))
        elif words[0] == "f":
            given = [_integer(word.partition("/")[0], line) for word in words[1:]]
            # Negative indices count back from the last vertex so far.
            polygons.append((line, [i + len(positions) + 1 if i < 0 else i for i in given]))
    for line, corners in polygons:
        _require_corners(corners, 1, len(positions), f"line {line}: the facet")
    return _arrays(positions, [[corner - 1 for corner in corners] for _, corners in polygons])


# As programs write it: positions, then triangles.
_NUMBER = rb"-?\d++(?:\.\d*+)?+(?:[eE][-+]?\d++)?+"
_PLAIN_OBJ = re.compile(
    rb"((?:v %b %b %b\n)++)((?:f \d{1,9}+ \d{1,9}+ \d{1,9}+\n)++)" % ((_NUMBER,) * 3)
)


def _read_plain_obj(data: bytes) -> Triangles | None:
    """Read a file without anything else, five times as fast as line by line; None of others."""
    found = _PLAIN_OBJ.fullmatch(data)
    if found is None:
        return None
    positions, corners = found[1].replace(b"v", b""), found[2].replace(b"f", b"")
    vertices = np.fromstring(positions, np.float64, sep=" ").reshape(-1, 3)
    facets = np.fromstring(corners, np.int64, sep=" ").reshape(-1, 3) - 1
    inside = facets.min() >= 0 and facets.max() < len(vertices)
    return (vertices, facets) if inside else None


def _read_off(data: bytes, _path: Path) -> Triangles:
    lines = _lines(data)
    number, words = next(lines, (1, [""]))
    if not re.fullmatch(r"(ST)?C?N?OFF", words[0]):
        raise MeshError(f"line {number} must begin with OFF, not {words[0]!r}")
    words = words[1:]
    if not words:
        number, words = next(lines, (number, []))
    counts = [_integer(word, number) for word in words[:2]]
    if len(counts) < 2:
        raise MeshError(f"line {number} must give the numbers of vertices and facets")
    positions: list[list[float]] = []
    facets: list[list[int]] = []
    for place in range(sum(counts)):
        number, words = next(lines, (number, []))
        if not words:
            raise MeshError(
                f"ends at line {number}, after {min(place, counts[0])} of {counts[0]} vertices and "
                f"{max(place - counts[0], 0)} of {counts[1]} facets; export it again"
            )
        if place < counts[0]:
            positions.append(_position(words[:3], number))
            continue
        corners = [_integer(word, number) for word in words[1 : 1 + _integer(words[0], number)]]
        _require_corners(corners, 0, counts[0], f"line {number}: the facet")
        facets.append(corners)
    return _arrays(positions, facets)


def _read_stl(data: bytes, _path: Path) -> Triangles:
    has_header = len(data) >= _STL_HEADER
    promised = struct.unpack_from("<I", data, 80)[0] if has_header else 0
    if not has_header or len(data) != _STL_HEADER + _STL_FACET * promised:
        if not data.lstrip().startswith(b"solid"):
            if not has_header:
                raise MeshError("neither text nor a whole binary .stl; export it again")
            held = (len(data) - _STL_HEADER) // _STL_FACET
            raise MeshError(
                f"a binary .stl that promises {promised} facets and holds {held}; export it again"
            )
        if b"endsolid" not in data:
            raise MeshError("ends without endsolid: the file is cut off; export it again")
    return _read_with_trimesh(data, "stl")


def _read_ply(data: bytes, _path: Path) -> Triangles:
    # trimesh reads triangles faster; of polygons it makes fans, or nothing where they are mixed.
    header, _, _ = data.partition(b"end_header")
    found = re.search(rb"element\s+face\s+(\d+)", header)
    promised = int(found[1]) if found else 0
    try:
        vertices, facets = _read_with_trimesh(data, "ply")
    except MeshError as error:
        try:
            return _read_ply_polygons(data)
        except MeshError as own:
            raise MeshError(f"not a readable .ply file ({own})") from error
    if len(facets) < promised:
        raise MeshError(
            f"a .ply that promises {promised} facets and holds {len(facets)}; export it again"
        )
    return (vertices, facets) if len(facets) == promised else _read_ply_polygons(data)


def _read_ply_polygons(data: bytes) -> Triangles:
    vertices, polygons = read_ply(data)
    for place, corners in enumerate(polygons):
        _require_corners(corners, 0, len(vertices), f"facet {place}")
    return vertices, np.array(triangulate(vertices, polygons), np.int64).reshape(-1, 3)


def _read_glb(data: bytes, _path: Path) -> Triangles:
    if not data.startswith(b"glTF"):
        raise MeshError("does not begin with glTF, as a .glb does; export it again")
    return _read_with_trimesh(data, "glb")


def _read_gltf(data: bytes, path: Path) -> Triangles:
    if not data.lstrip().startswith(b"{"):
        raise MeshError("does not begin with {, as a .gltf does; export it again")
    import trimesh  # noqa: PLC0415  as below

    # Its numbers are in files beside it.
    return _read_with_trimesh(data, "gltf", trimesh.resolvers.FilePathResolver(str(path)))


def _read_with_trimesh(data: bytes, file_type: str, resolver: Any = None) -> Triangles:
    import trimesh  # noqa: PLC0415  only reading a file needs it, and it takes a second

    try:
        # process=False: trimesh would silently drop facets with NaN.
        mesh = trimesh.load_mesh(
            io.BytesIO(data), file_type=file_type, resolver=resolver, process=False
        )
        return np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)
    except Exception as error:  # whatever a broken file raises in the reader
        raise MeshError(f"not a readable .{file_type} file ({error}); export it again") from error


_READERS: dict[str, Callable[[bytes, Path], Triangles]] = {
    ".obj": lambda data, _: read_obj(data),
    ".stl": _read_stl,
    ".ply": _read_ply,
    ".off": _read_off,
    ".glb": _read_glb,
    ".gltf": _read_gltf,
}


def _lines(data: bytes) -> Iterator[tuple[int, list[str]]]:
    """Yield number, from 1, and words of every line that has any, comments aside."""
    for number, line in enumerate(data.decode("utf-8", "replace").splitlines(), start=1):
        words = line.partition("#")[0].split()
        if words:
            yield number, words


def _position(words: Sequence[str], line: int) -> list[float]:
    try:
        x, y, z = words
        return [float(x), float(y), float(z)]
    except ValueError:
        raise MeshError(f"line {line}: a vertex needs three numbers, not {words}") from None


def _integer(word: str, line: int) -> int:
    try:
        return int(word)
    except ValueError:
        raise MeshError(f"line {line}: {word!r} is not an integer") from None


def _require_corners(corners: Sequence[int], first: int, vertices: int, which: str) -> None:
    if len(corners) < 3:
        raise MeshError(f"{which.replace(': the', ': a')} needs three corners, not {len(corners)}")
    for corner in corners:
        if not first <= corner < first + vertices:
            raise MeshError(
                f"{which} refers to vertex {corner}, but the file has {vertices} vertices; they "
                f"count from {first}"
            )


def _arrays(positions: list[list[float]], polygons: Sequence[Sequence[int]]) -> Triangles:
    vertices = np.array(positions, np.float64).reshape(-1, 3)
    return vertices, np.array(triangulate(vertices, polygons), np.int64).reshape(-1, 3)
