"""CollisionMesh: a triangle mesh made ready for distance queries and contact."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contact_toolkit import _core
from contact_toolkit.shapes.defects import MeshDefects, MeshSolid, SolidKind, describe_defects
from contact_toolkit.shapes.mesh_files import read_mesh_file
from contact_toolkit.shapes.primitives import Primitive

if TYPE_CHECKING:
    import trimesh

MeshError = _core.MeshError

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]

_KINDS: dict[str, SolidKind] = {
    "closed": "closed",
    "nearly_closed": "nearly closed",
    "open": "open",
    "inside_out": "inside out",
}


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
    source
        Where it comes from, such as a file, for messages.
    primitive
        What the mesh stands for, in the same frame, if it is a primitive: contact then meets the
        true surface where this body is the one probed.

    Raises
    ------
    MeshError
        Naming the first bad item and the mend: wrong shape or type, an index out of range, a
        coordinate that is NaN, infinite or beyond 1e15 m, no facet, or no extent.

    Examples
    --------
    >>> from contact_toolkit import CollisionMesh, MeshError
    >>> corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> mesh = CollisionMesh(corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    >>> str(mesh.defects), mesh.solid.kind, round(mesh.solid.volume, 6)
    ('none', 'closed', 0.166667)
    >>> CollisionMesh(corners, [[0, 1, 9]])  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    contact_toolkit._core.MeshError: ...
    """

    def __init__(
        self,
        vertices: ArrayLike,
        faces: ArrayLike,
        *,
        primitive: Primitive | None = None,
        source: str | None = None,
    ) -> None:
        self._core = _core.Mesh(_as_vertices(vertices), _as_faces(faces))
        self._primitive = primitive
        self._source = source
        self._told_of_repairs = False  # see `contact.inside`

    @classmethod
    def from_primitive(cls, primitive: Primitive, tolerance: float = 0.005) -> CollisionMesh:
        """Tessellate a primitive and remember what it is; see `contact_toolkit.shapes.primitives`.

        No facet lies further inside a round surface than `tolerance` times its radius.
        """
        return cls(*primitive.triangles(tolerance), primitive=primitive)

    @classmethod
    def from_file(cls, path: str | Path, scale: float = 1.0) -> CollisionMesh:
        """Read an .obj, .stl, .ply, .off, .glb or .gltf file, its coordinates times `scale`.

        Raises MeshError naming the file, the first bad line or facet and the mend.
        """
        path = Path(path)
        if not (np.isfinite(scale) and scale > 0):
            raise MeshError(f"{path}: scale must be positive and finite, not {scale}")
        vertices, faces = read_mesh_file(path)
        with np.errstate(over="ignore"):  # found and named below
            vertices = vertices * scale
        try:
            return cls(vertices, faces, source=str(path))
        except MeshError as error:
            raise MeshError(f"{path}: {error}") from error

    @classmethod
    def from_trimesh(cls, mesh: trimesh.Trimesh) -> CollisionMesh:
        """Take over the vertices and facets of a trimesh."""
        return cls(mesh.vertices, mesh.faces)

    @property
    def primitive(self) -> Primitive | None:
        """What the mesh stands for, if it is a primitive."""
        return self._primitive

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
        return MeshDefects(
            **self._core.defects, inside_out=self._core.closed and self._core.volume < 0
        )

    def describe_defects(self) -> list[str]:
        """Say of each kind of defect how many there are and where the first is."""
        return describe_defects(
            self.defects, self.vertices, self.edges, self.face_edges, self.volume
        )

    @property
    def source(self) -> str | None:
        """Where it comes from, such as a file; None where nobody said."""
        return self._source

    @property
    def solid(self) -> MeshSolid:
        """The solid it bounds, once nearly clean facets are set right; found when first asked."""
        solid = self._solid
        return MeshSolid(
            kind=_KINDS[solid.kind.name],
            volume=solid.volume,
            openness=solid.openness,
            **solid.repairs,
        )

    @cached_property
    def _solid(self) -> _core.Solid:
        return _core.Solid(self._core)

    def repaired(self) -> CollisionMesh:
        """Return the boundary of `solid` as a mesh of its own: turned, without what is left out.

        Holes stay: what closes them is for a mesh editor to say.
        """
        return CollisionMesh(self._solid.vertices, self._solid.faces, source=self.source)

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
        """Return the boxes `depth` levels below the root's children: (n, 8, 3) corners [m].

        They lie along axes of the hierarchy's own, the same for all: bit i of a corner's number is
        set at the upper end of axis i.
        """
        return self._core.hierarchy_boxes(depth).reshape(-1, 8, 3)

    def _area_body(self) -> _core.AreaBody:
        """Return what the area web prepares for this mesh, yet empty."""
        if self._primitive is None:
            return _core.AreaBody(self._solid)
        kind = _core.PrimitiveKind.__members__[self._primitive.kind]
        return _core.AreaBody(self._solid, kind, *self._primitive.size)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle what the mesh was made of: the copy's queries give the same bits."""
        _, first = np.unique(self.welded, return_index=True)
        made_of = (self.vertices[self.welded], first.astype(np.int32)[self.faces], self._primitive)
        return _remake, (*made_of, self._source)

    def __repr__(self) -> str:
        return f"CollisionMesh({len(self.vertices)} vertices, {len(self.faces)} facets)"


def _remake(
    vertices: Floats, faces: Ints, primitive: Primitive | None, source: str | None
) -> CollisionMesh:
    return CollisionMesh(vertices, faces, primitive=primitive, source=source)


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
