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
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from contact_toolkit import _core

MeshError = _core.MeshError

Triangles: TypeAlias = tuple[NDArray[np.float64], NDArray[np.int64]]

_MAX_FILE_BYTES = 1 << 30  # a gigabyte of text is some ten million facets
_STL_HEADER, _STL_FACET = 84, 50  # [bytes]


def read_mesh_file(path: Path) -> Triangles:
    """Read vertices (nv, 3) and facets (nf, 3) of an .obj, .stl, .ply, .off or .glb file.

    Polygons are fanned into triangles. Raises MeshError naming the file, the place and the mend.
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
        return reader(data)
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from error


def read_obj(data: bytes) -> Triangles:
    """Read vertices (nv, 3) and facets (nf, 3) of a Wavefront OBJ file's contents.

    Everything but positions and facets is skipped. Raises MeshError naming the line.
    """
    positions: list[list[float]] = []
    polygons: list[tuple[int, list[int]]] = []
    for line, words in _lines(data.replace(b"\\\n", b" ")):
        if words[0] == "v":
            positions.append(_position(words[1:4], line))
        elif words[0] == "f":
            given = [_integer(word.partition("/")[0], line) for word in words[1:]]
            # Negative indices count back from the last vertex so far.
            polygons.append((line, [i + len(positions) + 1 if i < 0 else i for i in given]))
    facets = [
        [corner - 1 for corner in facet]
        for line, corners in polygons
        for facet in _facets(corners, 1, len(positions), line)
    ]
    return _arrays(positions, facets)


def _read_off(data: bytes) -> Triangles:
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
        facets.extend(_facets(corners, 0, counts[0], number))
    return _arrays(positions, facets)


def _read_stl(data: bytes) -> Triangles:
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


def _read_ply(data: bytes) -> Triangles:
    vertices, facets = _read_with_trimesh(data, "ply")
    header, _, _ = data.partition(b"end_header")
    promised = re.search(rb"element\s+face\s+(\d+)", header)
    if promised and len(facets) < int(promised[1]):  # more where polygons were cut
        raise MeshError(
            f"a .ply that promises {int(promised[1])} facets and holds {len(facets)}; "
            f"export it again"
        )
    return vertices, facets


def _read_glb(data: bytes) -> Triangles:
    if not data.startswith(b"glTF"):
        raise MeshError("does not begin with glTF, as a .glb does; export it again")
    return _read_with_trimesh(data, "glb")


def _read_with_trimesh(data: bytes, file_type: str) -> Triangles:
    import trimesh  # noqa: PLC0415  only reading a file needs it, and it takes a second

    try:
        # process=False: trimesh would silently drop facets with NaN.
        mesh = trimesh.load_mesh(io.BytesIO(data), file_type=file_type, process=False)
        return np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)
    except Exception as error:  # whatever a broken file raises in the reader
        raise MeshError(f"not a readable .{file_type} file ({error}); export it again") from error


_READERS: dict[str, Callable[[bytes], Triangles]] = {
    ".obj": read_obj,
    ".stl": _read_stl,
    ".ply": _read_ply,
    ".off": _read_off,
    ".glb": _read_glb,
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


def _facets(corners: Sequence[int], first: int, vertices: int, line: int) -> Iterator[list[int]]:
    """Fan a polygon into triangles; refuse one that refers to a vertex not there."""
    if len(corners) < 3:
        raise MeshError(f"line {line}: a facet needs three corners, not {len(corners)}")
    for corner in corners:
        if not first <= corner < first + vertices:
            raise MeshError(
                f"line {line}: the facet refers to vertex {corner}, but the file has {vertices} "
                f"vertices; they count from {first}"
            )
    for k in range(1, len(corners) - 1):
        yield [corners[0], corners[k], corners[k + 1]]


def _arrays(positions: list[list[float]], facets: list[list[int]]) -> Triangles:
    return np.array(positions, np.float64).reshape(-1, 3), np.array(facets, np.int64).reshape(-1, 3)
