"""CollisionMesh: a triangle mesh made ready for distance queries and contact."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contact_toolkit import _core
from contact_toolkit.mesh_files import read_mesh_file

if TYPE_CHECKING:
    import trimesh

MeshError = _core.MeshError

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]


@dataclass(frozen=True)
class MeshDefects:
    """What is wrong with a mesh but tolerated; each field is an array of indices.

    Attributes
    ----------
    open_edges, non_manifold_edges, inconsistent_edges
        Into `CollisionMesh.edges`: edges of one facet (the boundary of an open surface), of three
        or more, and of two facets whose windings disagree.
    zero_area_facets, duplicate_facets
        Into `CollisionMesh.faces`; a duplicate has the three vertices of an earlier facet.
    unused_vertices
        Into `CollisionMesh.vertices`: vertices that no facet touches; no query sees them.
    """

    open_edges: Ints
    non_manifold_edges: Ints
    inconsistent_edges: Ints
    zero_area_facets: Ints
    duplicate_facets: Ints
    unused_vertices: Ints

    @property
    def closed(self) -> bool:
        """Whether the surface bounds a solid, so that queries may speak of an inside."""
        return not (
            self.open_edges.size or self.non_manifold_edges.size or self.inconsistent_edges.size
        )

    def __str__(self) -> str:
        found = {name.replace("_", " "): len(value) for name, value in vars(self).items()}
        return ", ".join(f"{count} {name}" for name, count in found.items() if count) or "none"


class CollisionMesh:
    """A validated triangle mesh with adjacency and a bounding volume hierarchy; immutable.

    Exactly coincident vertices are welded, so a triangle soup gets its adjacency back; facets are
    kept as given, in number, order and winding. Open and non-manifold surfaces are welcome in every
    query that needs no inside; see `defects`.

    Parameters
    ----------
    vertices
        (nv, 3) positions [m].
    faces
        (nf, 3) integer indices into `vertices`, counter-clockwise seen from outside.

    Raises
    ------
    MeshError
        Naming the first bad item and the mend: wrong shape or type, an index out of range, a
        coordinate that is NaN, infinite or beyond 1e15 m, no facet, or no extent.
    """

    def __init__(self, vertices: ArrayLike, faces: ArrayLike) -> None:
        self._core = _core.Mesh(_as_vertices(vertices), _as_faces(faces))

    @classmethod
    def from_file(cls, path: str | Path, scale: float = 1.0) -> CollisionMesh:
        """Read an .obj, .stl, .ply, .off or .glb file, multiplying its coordinates by `scale`.

        Raises MeshError naming the file, the first bad line or facet and the mend.
        """
        path = Path(path)
        if not (np.isfinite(scale) and scale > 0):
            raise MeshError(f"{path}: scale must be positive and finite, not {scale}")
        vertices, faces = read_mesh_file(path)
        with np.errstate(over="ignore"):  # found and named below
            vertices = vertices * scale
        try:
            return cls(vertices, faces)
        except MeshError as error:
            raise MeshError(f"{path}: {error}") from error

    @classmethod
    def from_trimesh(cls, mesh: trimesh.Trimesh) -> CollisionMesh:
        """Take over the vertices and facets of a trimesh."""
        return cls(mesh.vertices, mesh.faces)

    @property
    def vertices(self) -> Floats:
        """(nv, 3) welded vertex positions [m], read-only."""
        return self._core.vertices

    @property
    def faces(self) -> Ints:
        """(nf, 3) indices into `vertices`, with the winding given; read-only."""
        return self._core.faces

    @property
    def edges(self) -> Ints:
        """(ne, 2) unique edges, the lower vertex index first, in lexicographic order."""
        return self._core.edges

    @property
    def face_edges(self) -> Ints:
        """(nf, 3) indices into `edges`; entry k joins vertices k and k + 1 (mod 3) of the facet."""
        return self._core.face_edges

    @property
    def face_normals(self) -> Floats:
        """(nf, 3) unit normals by winding; zero for zero-area facets."""
        return self._core.face_normals

    @property
    def welded(self) -> Ints:
        """(number of vertices given,) index into `vertices` of each vertex given."""
        return self._core.welded

    @property
    def defects(self) -> MeshDefects:
        """The tolerated defects, found once at construction."""
        return MeshDefects(**self._core.defects)

    @property
    def lower(self) -> Floats:
        """(3,) lower corner of the bounding box [m]."""
        return self._core.lower

    @property
    def upper(self) -> Floats:
        """(3,) upper corner of the bounding box [m]."""
        return self._core.upper

    @property
    def diagonal(self) -> float:
        """Length of the bounding box's diagonal [m]."""
        return self._core.diagonal

    @property
    def volume(self) -> float:
        """Enclosed volume [m³]; negative when wound inside out, meaningless when open."""
        return self._core.volume

    @property
    def area(self) -> float:
        """Surface area [m²]."""
        return self._core.area

    @property
    def hierarchy(self) -> dict[str, float]:
        """Figures of the bounding volume hierarchy: nodes, depth, occupancy, size in memory [B]."""
        return self._core.hierarchy_figures

    def hierarchy_boxes(self, depth: int) -> Floats:
        """Return the boxes `depth` levels below the root's children: (n, 2, 3) corners [m]."""
        return self._core.hierarchy_boxes(depth).reshape(-1, 2, 3)

    def __reduce__(self) -> tuple[type[CollisionMesh], tuple[Floats, Ints]]:
        """Pickle what the mesh was made of: the copy's queries give the same bits."""
        _, first = np.unique(self.welded, return_index=True)
        return CollisionMesh, (self.vertices[self.welded], first.astype(np.int32)[self.faces])

    def __repr__(self) -> str:
        return f"CollisionMesh({len(self.vertices)} vertices, {len(self.faces)} facets)"


def _as_vertices(vertices: ArrayLike) -> Floats:
    array = _as_array(vertices, "vertices")
    if array.dtype.kind not in "fiu":
        raise MeshError(f"vertices must be real numbers, not {array.dtype}")
    _require_columns(array, "vertices")
    return np.ascontiguousarray(array, dtype=np.float64)


def _as_faces(faces: ArrayLike) -> Ints:
    array = _as_array(faces, "faces")
    if array.size == 0 and array.ndim <= 2:
        array = np.empty((0, 3), dtype=np.int32)
    if array.dtype.kind not in "iu":
        raise MeshError(f"faces must be integer vertex indices, not {array.dtype}")
    _require_columns(array, "faces")
    if array.size and (array.max() > np.iinfo(np.int32).max or array.min() < 0):
        facet = int(np.argmax((array > np.iinfo(np.int32).max).any(1) | (array < 0).any(1)))
        raise MeshError(
            f"facet {facet} refers to vertices {array[facet].tolist()}; indices count from 0 and "
            f"must be below 2³¹"
        )
    return np.ascontiguousarray(array, dtype=np.int32)


def _as_array(values: ArrayLike, name: str) -> NDArray[Any]:
    try:
        return np.asarray(values)
    except ValueError as error:
        raise MeshError(f"{name} must be a rectangular array with 3 columns: {error}") from error


def _require_columns(array: NDArray[Any], name: str) -> None:
    if array.ndim != 2 or array.shape[1] != 3:
        raise MeshError(f"{name} must have shape (n, 3), not {array.shape}")
