"""Geometries of one body that touch or overlap become one solid.

Else the sides within it would bear load, and an overlap would bear it twice.
"""

from __future__ import annotations

import dataclasses
import logging
from collections.abc import Iterator, Mapping
from itertools import combinations
from weakref import WeakKeyDictionary

import numpy as np
from pydrake.geometry import GeometryId
from pydrake.multibody.tree import BodyIndex
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from contact_toolkit import CollisionMesh, MeshError, distance, signed_distance
from contact_toolkit.shapes.csg import TOUCHING, united_shells
from contact_toolkit.shapes.primitives import Triangles
from contact_toolkit.shapes.shared_mesh import shared_mesh
from systems.plant.geometry_import import ImportedGeometry
from systems.plant.pairs import GeometryPair
from systems.plant.proximity_material import ProximityMaterial

Geometries = dict[GeometryId, ImportedGeometry]

_SHOWN = 3  # names of what was united
_log = logging.getLogger("contact_toolkit")
_shells: WeakKeyDictionary[CollisionMesh, int] = WeakKeyDictionary()


def unite_seams(
    geometries: Geometries,
    pairs: list[GeometryPair],
    materials: Mapping[BodyIndex, ProximityMaterial],
) -> tuple[Geometries, list[GeometryPair]]:
    """Return the geometries with what is one solid as one geometry, and the pairs of these.

    Those are boxes, convex pieces and closed meshes of one body, of the same material and with the
    same partners, which touch, overlap or lie one within the other; so do shells within one mesh.
    It goes by the id and the pose of the first, and by all names. Round primitives stay as
    they are: their surface is known exactly, and that of the union is not.

    Parameters
    ----------
    materials
        Of bodies for which the geometries' own do not count.
    """
    partners: dict[GeometryId, set[GeometryId]] = {each: set() for each in geometries}
    for a, b in pairs:
        partners[a].add(b)
        partners[b].add(a)
    alike: dict[object, list[GeometryId]] = {}
    for key, each in geometries.items():
        if _may_be_united(each.mesh):
            material = materials.get(each.body, each.material)
            alike.setdefault((each.body, material, frozenset(partners[key])), []).append(key)
    first_of = {key: key for key in geometries}
    united = dict(geometries)
    for keys in alike.values():
        for group in _groups(keys, geometries):
            whole = _united([geometries[key] for key in group])
            if whole is None:
                continue
            for key in group:
                first_of[key] = group[0]
                del united[key]
            united[group[0]] = whole
    # In the order in which they were: those of a group at the place of the first.
    kept = {key: united[key] for key in geometries if key in united}
    return kept, list(dict.fromkeys((first_of[a], first_of[b]) for a, b in pairs))


def _may_be_united(mesh: CollisionMesh) -> bool:
    polyhedral = mesh.primitive is None or mesh.primitive.kind == "box"
    return polyhedral and mesh.solid.kind == "closed"


def _groups(keys: list[GeometryId], geometries: Geometries) -> Iterator[list[GeometryId]]:
    """Yield those that hang together by touching each other."""
    group_of = {key: [key] for key in keys}
    for a, b in combinations(keys, 2):
        if group_of[a] is group_of[b] or not _touch(geometries[a], geometries[b]):
            continue
        joined = group_of[a] + group_of[b]
        for key in joined:
            group_of[key] = joined
    for group in {id(each): each for each in group_of.values()}.values():
        yield [key for key in keys if key in group]


def _touch(a: ImportedGeometry, b: ImportedGeometry) -> bool:
    X_AB = np.linalg.inv(a.X_BG) @ b.X_BG
    nearby = TOUCHING * (a.mesh.diagonal + b.mesh.diagonal)
    if distance(a.mesh, b.mesh, X_AB, upper_bound=nearby).distance < nearby:
        return True
    return _within(b.mesh, a.mesh, X_AB) or _within(a.mesh, b.mesh, np.linalg.inv(X_AB))


def _within(inner: CollisionMesh, outer: CollisionMesh, X_OI: np.ndarray) -> bool:
    """Tell whether a mesh that does not touch the other lies in it."""
    p_O = X_OI[:3, :3] @ inner.vertices[inner.faces[0, 0]] + X_OI[:3, 3]
    if (p_O < outer.lower).any() or (p_O > outer.upper).any():
        return False
    return bool(signed_distance(outer, p_O[None]).distance[0] < 0)


def _united(parts: list[ImportedGeometry]) -> ImportedGeometry | None:
    """Return them as one geometry, None where they already are one or cannot be."""
    first = parts[0]
    if len(parts) == 1 and _num_shells(first.mesh) == 1:
        return None
    name = " + ".join(part.name for part in parts[:_SHOWN])
    if len(parts) > _SHOWN:
        name += f" + {len(parts) - _SHOWN} more"
    try:
        surface = united_shells(*(_surface_in(first, part) for part in parts))
    except MeshError as error:
        if len(parts) > 1:  # a mesh with a cavity is one solid already
            _log.warning("geometries %s overlap; they stay apart, as %s", name, error)
        return None
    mesh = CollisionMesh(*surface, source=first.mesh.source)
    if len(parts) == 1 and _num_shells(mesh) == _num_shells(first.mesh):
        return None
    return dataclasses.replace(first, name=name, mesh=shared_mesh(mesh))


def _num_shells(mesh: CollisionMesh) -> int:
    if mesh not in _shells:
        _shells[mesh] = _count_shells(mesh)
    return _shells[mesh]


def _count_shells(mesh: CollisionMesh) -> int:
    corners = mesh.faces[:, [0, 1, 1, 2]].reshape(-1, 2).T
    links = coo_array((np.ones(corners.shape[1], bool), corners), shape=2 * [len(mesh.vertices)])
    label = connected_components(links, directed=False)[1]
    return len(np.unique(label[mesh.faces[:, 0]]))


def _surface_in(first: ImportedGeometry, part: ImportedGeometry) -> Triangles:
    """Return the part in the frame of the first; as given if clean, so that shells are whole."""
    X_FP = np.linalg.inv(first.X_BG) @ part.X_BG
    clean = part.mesh.defects.closed and not len(part.mesh.solid.duplicate_facets)
    mesh = part.mesh if clean else part.mesh.repaired()
    return mesh.vertices @ X_FP[:3, :3].T + X_FP[:3, 3], mesh.faces
