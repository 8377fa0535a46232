"""Distance queries and contact forces between arbitrarily shaped bodies; needs no simulator."""

from contact_toolkit.batch import Distances, distance_batch, intersects_batch
from contact_toolkit.contact_law import NonlinearDamper
from contact_toolkit.contact_model import (
    ContactArrays,
    ContactModel,
    ContactStatus,
    Forces,
    Found,
    StepTable,
)
from contact_toolkit.contact_pair import ContactGeometry, ContactPair
from contact_toolkit.convex import ConvexPieces, Shape
from contact_toolkit.cspace import CSpaceClass, CSpaceGeometry, CSpaceModel
from contact_toolkit.cspace_classify import (
    Classification,
    MotionClassification,
    classify,
    classify_motions,
)
from contact_toolkit.decomposition import DecompositionError, decompose
from contact_toolkit.floating_bodies import FloatingBodies
from contact_toolkit.friction import Friction
from contact_toolkit.materials import MATERIALS, Material, find_material
from contact_toolkit.mesh import CollisionMesh, MeshDefects, MeshError
from contact_toolkit.queries import (
    EDGE,
    FACET,
    PIECE,
    VERTEX,
    ClosestPair,
    WitnessCache,
    WitnessPairs,
    distance,
    intersects,
    witness_pairs,
)
from contact_toolkit.queries_point import SignedDistances, signed_distance
from contact_toolkit.swept import (
    ImpactStatus,
    SweptDistance,
    TimeOfImpact,
    swept_distance,
    swept_intersects,
    time_of_impact,
)
from contact_toolkit.swept_batch import (
    SweptDistances,
    TimesOfImpact,
    swept_distance_batch,
    swept_intersects_batch,
    time_of_impact_batch,
)

__all__ = [
    "EDGE",
    "FACET",
    "MATERIALS",
    "PIECE",
    "VERTEX",
    "CSpaceClass",
    "CSpaceGeometry",
    "CSpaceModel",
    "Classification",
    "ClosestPair",
    "CollisionMesh",
    "ContactArrays",
    "ContactGeometry",
    "ContactModel",
    "ContactPair",
    "ContactStatus",
    "ConvexPieces",
    "DecompositionError",
    "Distances",
    "FloatingBodies",
    "Forces",
    "Found",
    "Friction",
    "ImpactStatus",
    "Material",
    "MeshDefects",
    "MeshError",
    "MotionClassification",
    "NonlinearDamper",
    "Shape",
    "SignedDistances",
    "StepTable",
    "SweptDistance",
    "SweptDistances",
    "TimeOfImpact",
    "TimesOfImpact",
    "WitnessCache",
    "WitnessPairs",
    "classify",
    "classify_motions",
    "decompose",
    "distance",
    "distance_batch",
    "find_material",
    "intersects",
    "intersects_batch",
    "signed_distance",
    "swept_distance",
    "swept_distance_batch",
    "swept_intersects",
    "swept_intersects_batch",
    "time_of_impact",
    "time_of_impact_batch",
    "witness_pairs",
]
