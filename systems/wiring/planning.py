"""Signed distances of a plant whose contact was taken over, for planning.

Drake's contact and its distances go through one query object and look at the same filters: what is
taken from contact is taken from inverse kinematics too, which then "succeeds" inside a table. Not
possible (1.51): filters set at `Initialize` (a system cannot reach SceneGraph's context, and until
then Drake's contact would push) and a second SceneGraph (the plant asks one port for both). Point
stiffnesses of 1e-9 N/m in place of filters keep the distances, but a step of a plant of 20 boxes
then takes 4 to 5 times as long, and contact results have phantom rows. So the model is filtered,
and a context for planning is opened again.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable

from pydrake.geometry import CollisionFilterDeclaration, GeometryId, GeometrySet, SceneGraph
from pydrake.systems.framework import Context

from systems.plant.pairs import GeometryPair


class TakenPairs:
    """The pairs of geometries that were taken away from Drake's own contact."""

    def __init__(self, scene_graph: SceneGraph, pairs: Iterable[GeometryPair]) -> None:
        self._scene_graph = scene_graph
        self._partners: dict[GeometryId, list[GeometryId]] = defaultdict(list)
        for a, b in pairs:
            self._partners[a].append(b)

    def restore(self, context: Context) -> None:
        """Let Drake see the pairs again in a root context, and in no other."""
        own = self._scene_graph.GetMyMutableContextFromRoot(context)
        declaration = CollisionFilterDeclaration()
        for a, others in self._partners.items():
            declaration.AllowBetween(GeometrySet([a]), GeometrySet(others))
        self._scene_graph.collision_filter_manager(own).Apply(declaration)
