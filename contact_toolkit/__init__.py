"""Distance queries and contact forces between arbitrarily shaped bodies; needs no simulator."""

from contact_toolkit.mesh import CollisionMesh, MeshDefects, MeshError
from contact_toolkit.queries import (
    EDGE,
    FACET,
    VERTEX,
    ClosestPair,
    WitnessPairs,
    distance,
    intersects,
    witness_pairs,
)

__all__ = [
    "EDGE",
    "FACET",
    "VERTEX",
    "ClosestPair",
    "CollisionMesh",
    "MeshDefects",
    "MeshError",
    "WitnessPairs",
    "distance",
    "intersects",
    "witness_pairs",
]
