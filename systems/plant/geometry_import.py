"""Take collision geometries over from a SceneGraph: any `Shape` becomes a `CollisionMesh`."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    GeometryId,
    HalfSpace,
    Mesh,
    MeshSource,
    SceneGraph,
    Shape,
    Sphere,
)
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex

from contact_toolkit import CollisionMesh, MeshError
from contact_toolkit.shapes import primitives
from contact_toolkit.shapes.primitives import Primitive, Triangles
from contact_toolkit.shapes.shared_mesh import shared_mesh
from systems.plant.mesh_source import read_mesh_source, surface_of
from systems.plant.pairs import GeometryPair
from systems.plant.proximity_material import ProximityMaterial, read_material

_POINT = 1e-9  # [m] radius of what is given as a point, a sphere of none


@dataclass(frozen=True)
class ImportedGeometry:
    """One collision geometry of a plant, as a mesh.

    Attributes
    ----------
    geometry_id, name
        As SceneGraph knows it.
    body
        The body it is fixed in.
    X_BG
        (4, 4) pose of the geometry in its body.
    mesh
        In the geometry's frame; shared between geometries of equal shape.
    material
        What its proximity properties say it is made of.
    """

    geometry_id: GeometryId
    name: str
    body: BodyIndex
    X_BG: NDArray[np.float64]
    mesh: CollisionMesh
    material: ProximityMaterial


class GeometryImporter:
    """Makes meshes of the collision geometries of a finalized plant, each shape once.

    Parameters
    ----------
    plant, scene_graph
        The plant, finalized, and the SceneGraph it is registered with.
    tessellation_tolerance
        How far facets may lie inside a curved surface, relative to its radius.
    half_space_reach
        Radius [m] about its origin within which a half space is represented; equally deep.

    Raises
    ------
    ValueError
        Where one of these two makes no sense.
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        scene_graph: SceneGraph,
        *,
        tessellation_tolerance: float = 0.005,
        half_space_reach: float = 100.0,
    ) -> None:
        if not 0 < tessellation_tolerance < 1:
            raise ValueError(
                f"tessellation_tolerance must be a share of the radius between 0 and 1, not "
                f"{tessellation_tolerance}"
            )
        if not 0 < half_space_reach < math.inf:
            raise ValueError(
                f"half_space_reach must be a finite radius [m] > 0, not {half_space_reach}"
            )
        self._plant = plant
        # The model's inspector: a context's would show defaults as if they had been given.
        self._inspector = scene_graph.model_inspector()
        self._defaults = scene_graph.get_config().default_proximity_properties
        self._tolerance = tessellation_tolerance
        self._reach = half_space_reach
        self._meshes: dict[tuple[object, ...], CollisionMesh] = {}

    def body_of(self, geometry: GeometryId) -> BodyIndex | None:
        """Return the body the geometry is fixed in; None when it is not the plant's."""
        body = self._plant.GetBodyFromFrameId(self._inspector.GetFrameId(geometry))
        return None if body is None else body.index()

    def read(self, geometry: GeometryId) -> ImportedGeometry:
        """Return the geometry as a mesh; raises MeshError, naming it, where that cannot be done."""
        body = self.body_of(geometry)
        name = self._inspector.GetName(geometry)
        if body is None:
            raise ValueError(f"geometry {name!r} belongs to no body of the plant")
        try:
            mesh = self._mesh_of(geometry)
        except MeshError as error:
            body_name = self._plant.get_body(body).scoped_name()
            raise MeshError(f"collision geometry {name!r} of body {body_name}: {error}") from error
        return ImportedGeometry(
            geometry_id=geometry,
            name=name,
            body=body,
            X_BG=self._inspector.GetPoseInFrame(geometry).GetAsMatrix4(),
            mesh=mesh,
            material=read_material(
                self._inspector.GetProximityProperties(geometry), self._defaults
            ),
        )

    def read_all(self, pairs: Iterable[GeometryPair]) -> dict[GeometryId, ImportedGeometry]:
        """Return every geometry of the pairs, in the order in which they name them; see `read`."""
        return {geometry: self.read(geometry) for geometry in dict.fromkeys(chain(*pairs))}

    def _mesh_of(self, geometry: GeometryId) -> CollisionMesh:
        shape = self._inspector.GetShape(geometry)
        key = _shape_key(shape)
        if key is None:
            return shared_mesh(self._make_mesh(geometry, shape))
        if key not in self._meshes:
            self._meshes[key] = shared_mesh(self._make_mesh(geometry, shape))
        return self._meshes[key]

    def _make_mesh(self, geometry: GeometryId, shape: Shape) -> CollisionMesh:
        primitive = self._primitive_of(shape)
        if primitive is None:
            has_source = isinstance(shape, Mesh | Convex)
            source = shape.source().description().strip("'") if has_source else None
            return CollisionMesh(*self._triangles_of(geometry, shape), source=source)
        return CollisionMesh.from_primitive(primitive, self._tolerance)

    def _primitive_of(self, shape: Shape) -> Primitive | None:
        match shape:
            case Box():
                return Primitive("box", tuple(shape.size()))
            case Sphere():
                return Primitive("sphere", (max(shape.radius(), _POINT),))
            case Cylinder():
                return Primitive("cylinder", (shape.radius(), shape.length()))
            case Capsule():
                return Primitive("capsule", (shape.radius(), shape.length()))
            case HalfSpace():
                return Primitive("half_space", (self._reach,))
        return None

    def _triangles_of(self, geometry: GeometryId, shape: Shape) -> Triangles:
        match shape:
            case Ellipsoid():
                semi_axes = [shape.a(), shape.b(), shape.c()]
                triangles = primitives.ellipsoid(semi_axes, self._tolerance)
            case Convex():
                triangles = surface_of(shape.GetConvexHull())
            case Mesh():
                triangles = self._mesh_triangles(geometry, shape)
            case _:
                raise MeshError(f"a {type(shape).__name__} has no surface to touch")
        return triangles

    def _mesh_triangles(self, geometry: GeometryId, shape: Mesh) -> Triangles:
        if shape.extension() == ".vtk":
            # Drake reads tetrahedra only for its own hydroelastic contact, and scales them.
            own = self._inspector.maybe_get_hydroelastic_mesh(geometry)
            if own is None:
                raise MeshError(
                    f"{shape.source().description()}: a .vtk mesh is read only where it has "
                    "hydroelastic properties; add them or convert it to .obj"
                )
            return surface_of(own)
        vertices, faces = read_mesh_source(shape.source())
        scale = shape.scale3()
        # A mirrored mesh is wound inside out.
        return vertices * scale, faces[:, ::-1] if np.prod(scale) < 0 else faces


def _shape_key(shape: Shape) -> tuple[object, ...] | None:
    """Return what makes two shapes the same mesh; None where that is unknown."""
    size: tuple[object, ...] | None
    match shape:
        case Mesh() | Convex():
            readable = shape.extension() != ".vtk"
            size = (_contents_of(shape.source()), *shape.scale3()) if readable else None
        case Box():
            size = tuple(shape.size())
        case Sphere():
            size = (shape.radius(),)
        case Ellipsoid():
            size = (shape.a(), shape.b(), shape.c())
        case Cylinder() | Capsule():
            size = (shape.radius(), shape.length())
        case HalfSpace():
            size = ()
        case _:
            size = None
    return None if size is None else (type(shape), *size)


def _contents_of(source: MeshSource) -> object:
    """Return what is equal where the contents are: the path, or the hash of what is in memory."""
    if source.is_path():
        return source.path()
    return source.in_memory().mesh_file.sha256().to_string()
