"""One mesh for equal surfaces: hierarchies, fields and nodes are built once for a process."""

from __future__ import annotations

import hashlib
from weakref import WeakValueDictionary

from contact_toolkit.shapes.mesh import CollisionMesh

# Kept only as long as somebody else keeps the mesh.
_meshes: WeakValueDictionary[bytes, CollisionMesh] = WeakValueDictionary()


def surface_digest(mesh: CollisionMesh) -> bytes:
    """Return what names the surface, in any process: equal for equal vertices and facets."""
    digest = hashlib.blake2b(repr(mesh.primitive).encode(), digest_size=20)
    for array in (mesh.vertices, mesh.faces):
        digest.update(f"{array.shape}".encode())
        digest.update(array.tobytes())
    return digest.digest()


def shared_mesh(mesh: CollisionMesh) -> CollisionMesh:
    """Return the first mesh that is equal to this one in all it was made of, and still alive."""
    digest = hashlib.blake2b(surface_digest(mesh) + repr(mesh.source).encode(), digest_size=20)
    digest.update(mesh.welded.tobytes())
    return _meshes.setdefault(digest.digest(), mesh)
