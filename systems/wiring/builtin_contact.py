"""Take pairs of geometries away from Drake's built-in contact."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable

from pydrake.geometry import (
    CollisionFilterDeclaration,
    GeometryId,
    GeometrySet,
    ProximityProperties,
    RoleAssign,
    SceneGraph,
    SourceId,
)

from systems.plant.pairs import GeometryPair


def take_over_pairs(
    scene_graph: SceneGraph, source: SourceId, pairs: Iterable[GeometryPair]
) -> None:
    """Filter the pairs from built-in contact, in the model all later contexts are made from.

    A geometry left with no pair of its own also loses its hydroelastic properties: merely building
    Drake's hydroelastic mesh of 20 000 facets takes 0.7 s a context.
    """
    partners: dict[GeometryId, list[GeometryId]] = defaultdict(list)
    for a, b in pairs:
        partners[a].append(b)
    declaration = CollisionFilterDeclaration()
    for a, others in partners.items():
        declaration.ExcludeBetween(GeometrySet([a]), GeometrySet(others))
    scene_graph.collision_filter_manager().Apply(declaration)

    inspector = scene_graph.model_inspector()
    still_wanted = {geometry for pair in inspector.GetCollisionCandidates() for geometry in pair}
    ours = set(partners).union(*partners.values())
    for geometry in sorted(ours - still_wanted, key=lambda geometry: geometry.get_value()):
        properties = inspector.GetProximityProperties(geometry)
        if properties.HasGroup("hydroelastic"):
            scene_graph.AssignRole(
                source, geometry, _without_hydroelastic(properties), RoleAssign.kReplace
            )


def _without_hydroelastic(properties: ProximityProperties) -> ProximityProperties:
    kept = ProximityProperties(properties)
    for name in list(kept.GetPropertiesInGroup("hydroelastic")):
        kept.RemoveProperty("hydroelastic", name)
    return kept
