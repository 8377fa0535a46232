"""Read the facets of Drake's meshes: from a file, from memory, or from its own mesh types."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from pydrake.geometry import (
    ConvertVolumeToSurfaceMesh,
    MeshSource,
    PolygonSurfaceMesh,
    TriangleSurfaceMesh,
    VolumeMesh,
)

from contact_toolkit import MeshError
from contact_toolkit.shapes.mesh_files import read_obj
from contact_toolkit.shapes.primitives import Triangles
from systems.plant.mesh_files import read_for_drake


def read_mesh_source(source: MeshSource) -> Triangles:
    """Return vertices (nv, 3) and faces (nf, 3) of a source, unscaled, stood as Drake does.

    Raises MeshError where the file cannot be read, naming the place and the mend.
    """
    extension = source.extension()
    if source.is_path():
        return read_for_drake(Path(source.path()))
    if extension != ".obj":
        raise MeshError(
            f"{source.description()}: an in-memory {extension}; give the path, or an .obj"
        )
    try:
        vertices, faces = read_obj(source.in_memory().mesh_file.contents())
    except MeshError as error:
        raise MeshError(f"{source.description()}: {error}") from error
    return vertices, faces.astype(np.int32)


def surface_of(mesh: VolumeMesh | TriangleSurfaceMesh | PolygonSurfaceMesh) -> Triangles:
    """Return the boundary of one of Drake's meshes; polygons are fanned into triangles."""
    surface = ConvertVolumeToSurfaceMesh(mesh) if isinstance(mesh, VolumeMesh) else mesh
    vertices = np.array([surface.vertex(i) for i in range(surface.num_vertices())])
    faces: list[list[int]] = []
    for element in (surface.element(i) for i in range(surface.num_elements())):
        corners = getattr(element, "num_vertices", lambda: 3)()
        faces.extend(
            [element.vertex(0), element.vertex(k), element.vertex(k + 1)]
            for k in range(1, corners - 1)
        )
    return vertices, np.array(faces, dtype=np.int32)
