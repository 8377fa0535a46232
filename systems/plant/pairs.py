"""Choose the pairs of collision geometries that the nonlinear damper takes over."""

from __future__ import annotations

from itertools import combinations, product

from pydrake.geometry import GeometryId, SceneGraphInspector
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex

from systems.plant.names import BodyNames

GeometryPair = tuple[GeometryId, GeometryId]


def choose_geometry_pairs(
    plant: MultibodyPlant, inspector: SceneGraphInspector, bodies: BodyNames, pairs: list[list[str]]
) -> list[GeometryPair]:
    """Return pairs of the plant's collision geometries that SceneGraph does not filter.

    Parameters
    ----------
    pairs
        Pairs of body names; empty: all.

    Raises
    ------
    ValueError
        For unknown or ambiguous names, and where two bodies named share no unfiltered geometries.
    """
    geometries = {
        index: sorted(plant.GetCollisionGeometriesForBody(plant.get_body(index)), key=_value)
        for index in map(BodyIndex, range(plant.num_bodies()))
    }

    def unfiltered(a: BodyIndex, b: BodyIndex) -> list[GeometryPair]:
        candidates = product(geometries[a], geometries[b])
        return [pair for pair in candidates if not inspector.CollisionFiltered(*pair)]

    if not pairs:
        chosen = [pair for ab in combinations(geometries, 2) for pair in unfiltered(*ab)]
        if not chosen:
            raise ValueError(
                "no two collision geometries of the plant may touch: register some on two bodies, "
                "or look at the collision filters"
            )
        return chosen
    wanted: dict[tuple[BodyIndex, BodyIndex], list[GeometryPair]] = {}
    for i, names in enumerate(pairs):
        ab = bodies.find_two(names, f"pairs[{i}]")
        wanted[ab] = unfiltered(*ab)
        if not wanted[ab]:
            raise ValueError(
                f"pairs[{i}]: {names[0]!r} and {names[1]!r} cannot touch: one has no collision "
                "geometry, or SceneGraph filters them (as it does for bodies joined by a joint)"
            )
    return [pair for geometry_pairs in wanted.values() for pair in geometry_pairs]


def _value(geometry: GeometryId) -> int:
    return geometry.get_value()
