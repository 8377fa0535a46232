"""Read .ply files with their polygons whole (trimesh would fan them)."""

from __future__ import annotations

import io
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contact_toolkit import _core

MeshError = _core.MeshError

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2",
    "int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8",
}  # fmt: skip
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_CORNERS = ("vertex_indices", "vertex_index")


@dataclass
class _Property:
    name: str
    dtype: np.dtype[np.generic]
    counted_by: np.dtype[np.generic] | None  # of a list


@dataclass
class _Element:
    name: str
    count: int
    properties: list[_Property] = field(default_factory=list)


def read_ply(data: bytes) -> tuple[NDArray[np.float64], list[list[int]]]:
    """Return the vertices (nv, 3) and the polygons; raises MeshError naming what is wrong."""
    header, mark, body = data.partition(b"end_header")
    body = body[body.find(b"\n") + 1 :]
    if not header.startswith(b"ply") or not mark:
        raise MeshError("does not begin with ply and a header; export it again")
    order, elements = _read_header(header.decode("ascii", "replace"))
    source = _Text(body) if order == "" else _Binary(body)
    vertices = np.empty((0, 3))
    polygons: list[list[int]] = []
    for element in elements:
        names = [each.name for each in element.properties]
        if element.name == "vertex":
            if not {"x", "y", "z"} <= set(names):
                raise MeshError("its vertices have no x, y, z; export it again")
            columns = [names.index(axis) for axis in "xyz"]
            rows = source.rows(element)
            vertices = np.array([[row[c] for c in columns] for row in rows], np.float64)
            vertices = vertices.reshape(-1, 3)
        elif element.name == "face":
            corners = next((names.index(name) for name in _CORNERS if name in names), None)
            if corners is None:
                raise MeshError("its facets have no vertex_indices; export it again")
            polygons = [[int(i) for i in row[corners]] for row in source.rows(element)]
        else:
            source.rows(element)
    return vertices, polygons


def _read_header(header: str) -> tuple[str, list[_Element]]:
    order: str | None = None
    elements: list[_Element] = []
    for line in header.splitlines():
        match line.split():
            case ["format", name, *_] if name in _ORDERS:
                order = _ORDERS[name]
            case ["element", name, count] if count.isdigit():
                elements.append(_Element(name, int(count)))
            case ["property", "list", counted_by, kind, name] if elements:
                elements[-1].properties.append(
                    _Property(name, _dtype(kind, order), _dtype(counted_by, order))
                )
            case ["property", kind, name] if elements:
                elements[-1].properties.append(_Property(name, _dtype(kind, order), None))
    if order is None:
        raise MeshError("its header names no format known; export it again")
    return order, elements


def _dtype(kind: str, order: str | None) -> np.dtype[np.generic]:
    if kind not in _TYPES:
        raise MeshError(f"its header names the type {kind!r}, which .ply has not; export it again")
    return np.dtype((order or "") + _TYPES[kind])


class _Text:
    def __init__(self, body: bytes) -> None:
        self._lines = io.StringIO(body.decode("ascii", "replace"))

    def rows(self, element: _Element) -> list[list[Any]]:
        return [self._row(element, place) for place in range(element.count)]

    def _row(self, element: _Element, place: int) -> list[Any]:
        words = iter(self._lines.readline().split())
        try:
            row: list[Any] = []
            for each in element.properties:
                if each.counted_by is None:
                    row.append(float(next(words)))
                else:
                    row.append([int(next(words)) for _ in range(int(next(words)))])
        except (StopIteration, ValueError, RuntimeError):
            raise MeshError(
                f"{element.name} {place} is cut off or no number; export it again"
            ) from None
        return row


class _Binary:
    def __init__(self, body: bytes) -> None:
        self._body = body
        self._at = 0

    def rows(self, element: _Element) -> list[list[Any]]:
        if all(each.counted_by is None for each in element.properties):
            layout = np.dtype([(f"{i}", each.dtype) for i, each in enumerate(element.properties)])
            table = self._take(layout, element.count, element)
            return [list(row) for row in table.tolist()]
        rows = []
        for _ in range(element.count):
            row: list[Any] = []
            for each in element.properties:
                if each.counted_by is None:
                    row.append(self._take(each.dtype, 1, element)[0])
                else:
                    count = int(self._take(each.counted_by, 1, element)[0])
                    row.append(self._take(each.dtype, max(count, 0), element).tolist())
            rows.append(row)
        return rows

    def _take(self, dtype: np.dtype[Any], count: int, element: _Element) -> NDArray[Any]:
        if self._at + dtype.itemsize * count > len(self._body):
            raise MeshError(
                f"ends within the {element.count} promised of {element.name}: the file is cut off; "
                "export it again"
            )
        taken = np.frombuffer(self._body, dtype, count, self._at)
        self._at += dtype.itemsize * count
        return taken
