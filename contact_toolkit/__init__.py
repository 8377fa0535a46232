"""Distance queries and contact forces between arbitrarily shaped bodies; needs no simulator."""

from importlib.metadata import version as _installed_version

from contact_toolkit.contact.contact_law import NonlinearDamper
from contact_toolkit.contact.contact_model import (
    ContactArrays,
    ContactModel,
    ContactState,
    ContactStatus,
    Forces,
    Linearization,
    LoadedSprings,
)
from contact_toolkit.contact.contact_pair import ContactGeometry, ContactPair
from contact_toolkit.contact.floating_bodies import FloatingBodies
from contact_toolkit.contact.friction import Friction
from contact_toolkit.contact.materials import MATERIALS, Material, find_material
from contact_toolkit.contact.spring_webs import AreaWeb, FacetWeb, PointWeb
from contact_toolkit.contact.step_solver import StepSolution, StepSolver
from contact_toolkit.cspace.classify import (
    Classification,
    MotionClassification,
    classify,
    classify_motions,
)
from contact_toolkit.cspace.model import CSpaceClass, CSpaceGeometry, CSpaceModel
from contact_toolkit.query.batch import Distances, distance_batch, intersects_batch
from contact_toolkit.query.point import SignedDistances, signed_distance
from contact_toolkit.query.swept import (
    ImpactStatus,
    SweptDistance,
    TimeOfImpact,
    swept_distance,
    swept_intersects,
    time_of_impact,
)
from contact_toolkit.query.swept_batch import (
    SweptDistances,
    TimesOfImpact,
    swept_distance_batch,
    swept_intersects_batch,
    time_of_impact_batch,
)
from contact_toolkit.query.witness import (
    ClosestPair,
    FeatureKind,
    WitnessCache,
    WitnessPairs,
    distance,
    intersects,
    witness_pairs,
)
from contact_toolkit.shapes.convex_pieces import ConvexPieces, Shape
from contact_toolkit.shapes.decomposition import DecompositionError, decompose
from contact_toolkit.shapes.defects import MeshDefects, MeshSolid
from contact_toolkit.shapes.mesh import CollisionMesh, MeshError

__version__ = _installed_version("contact-toolkit")

__all__ = [
    "MATERIALS",
    "AreaWeb",
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
    "ContactState",
    "ContactStatus",
    "ConvexPieces",
    "DecompositionError",
    "Distances",
    "FacetWeb",
    "FeatureKind",
    "FloatingBodies",
    "Forces",
    "Friction",
    "ImpactStatus",
    "Linearization",
    "LoadedSprings",
    "Material",
    "MeshDefects",
    "MeshError",
    "MeshSolid",
    "MotionClassification",
    "NonlinearDamper",
    "PointWeb",
    "Shape",
    "SignedDistances",
    "StepSolution",
    "StepSolver",
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
