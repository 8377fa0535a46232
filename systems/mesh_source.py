"""Read the facets of Drake's meshes: from a file, from memory, or from its own mesh types."""

from __future__ import annotations

import io

import numpy as np
from pydrake.geometry import (
    ConvertVolumeToSurfaceMesh,
    MeshSource,
    PolygonSurfaceMesh,
    TriangleSurfaceMesh,
    VolumeMesh,
)

from contact_toolkit import MeshError
from systems.tessellation import Triangles

# Drake stands the y-up glTF model on its feet: (x, y, z) -> (x, -z, y).
_Z_UP_FROM_Y_UP = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])


def read_mesh_source(source: MeshSource) -> Triangles:
    """Return vertices (nv, 3) and faces (nf, 3) of an .obj or .gltf source, unscaled.

    Raises MeshError for other formats, and where the file cannot be read.
    """
    extension = source.extension()
    if extension not in (".obj", ".gltf"):
        raise MeshError(f"{source.description()}: cannot read {extension}; convert it to .obj")
    if source.is_in_memory() and extension == ".gltf":
        raise MeshError(f"{source.description()}: in-memory .gltf; give the path or an .obj")
    import trimesh  # noqa: PLC0415  only reading a file needs it, and it takes a second

    try:
        # process=False: trimesh would silently drop facets with NaN.
        if source.is_path():
            mesh = trimesh.load_mesh(source.path(), process=False)
        else:
            text = io.BytesIO(source.in_memory().mesh_file.contents())
            mesh = trimesh.load_mesh(text, file_type=extension[1:], process=False)
        vertices = np.asarray(mesh.vertices, dtype=np.float64)
        faces = np.asarray(mesh.faces, dtype=np.int32)
    except Exception as error:  # whatever a broken file raises in the reader
        raise MeshError(f"{source.description()}: not a readable mesh: {error}") from error
    if extension == ".gltf":
        vertices = vertices @ _Z_UP_FROM_Y_UP.T
    return vertices, faces


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
