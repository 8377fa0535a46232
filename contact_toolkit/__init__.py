"""Distance queries and contact forces between arbitrarily shaped bodies; needs no simulator."""

from contact_toolkit.mesh import CollisionMesh, MeshDefects, MeshError

__all__ = ["CollisionMesh", "MeshDefects", "MeshError"]
