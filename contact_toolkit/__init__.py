"""Distance queries and contact forces between arbitrarily shaped bodies; needs no simulator."""

from contact_toolkit.contact_law import NonlinearDamper
from contact_toolkit.contact_model import (
    ContactArrays,
    ContactGeometry,
    ContactModel,
    ContactPair,
    Forces,
    Found,
    StepTable,
)
from contact_toolkit.floating_bodies import FloatingBodies
from contact_toolkit.mesh import CollisionMesh, MeshDefects, MeshError
from contact_toolkit.queries import (
    EDGE,
    FACET,
    VERTEX,
    ClosestPair,
    WitnessCache,
    WitnessPairs,
    distance,
    intersects,
    witness_pairs,
)
from contact_toolkit.queries_point import SignedDistances, signed_distance

__all__ = [
    "EDGE",
    "FACET",
    "VERTEX",
    "ClosestPair",
    "CollisionMesh",
    "ContactArrays",
    "ContactGeometry",
    "ContactModel",
    "ContactPair",
    "FloatingBodies",
    "Forces",
    "Found",
    "MeshDefects",
    "MeshError",
    "NonlinearDamper",
    "SignedDistances",
    "StepTable",
    "WitnessCache",
    "WitnessPairs",
    "distance",
    "intersects",
    "signed_distance",
    "witness_pairs",
]
