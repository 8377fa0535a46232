"""Work out the stiffness of a pair from what its geometries are tagged with.

A foundation yields everywhere alike: a modulus E over a skin h gives k = E / h [Pa/m]. Drake's
point contact yields as a whole: a force per depth [N/m]. Where only that is given, the foundation
is made so stiff that under the nominal load N, the weight of the lighter body, it yields as deep as
the point contact would, x = N / k_point: k = N / V(x), where V(x) is the depth below a plane,
summed over the surface of the smaller geometry that sinks into it as deep as x with the broadest of
the six sides of its frame. For a box that is k_point over its largest face, at nearly any load.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contact_toolkit import CollisionMesh
from contact_toolkit.contact.materials import STIFFEST_MODULUS
from systems.plant.proximity_material import ProximityMaterial
from systems.plant.whole_bodies import WholeBody

SKIN = 0.01
"""Thickness of a skin over the diagonal of the smaller whole body: thin, yet soft enough to
integrate."""

# [N] Where no body of the pair has a weight: that of an object of one kilogram.
_USUAL_LOAD = 9.81
# A piece smaller than the skin is no foundation of its own: it is not made stiffer than one.
_PIECE = SKIN


@dataclass(frozen=True)
class Side:
    """One geometry of a pair.

    Attributes
    ----------
    index
        In the contact model.
    mesh, material
        Its surface, and what it is made of.
    whole
        The body it is on, with all that is welded to that.
    """

    index: int
    mesh: CollisionMesh
    material: ProximityMaterial
    whole: WholeBody


def foundation_stiffness(a: Side, b: Side, skin: float | None) -> float:
    """Return the stiffness k [Pa/m] of an area web between two geometries, in series.

    A rigid geometry does not yield beside one that does. Two rigid ones have skins like any other,
    of the stiffest modulus that the library's materials are simulated with (`STIFFEST_MODULUS`, ten
    times Drake's default): neither where bodies rest nor how they bounce and slide depends on it.
    """
    if skin is not None and not skin > 0:
        raise ValueError(f"skin must be a thickness [m] > 0, not {skin}")
    usual = SKIN * min(a.whole.diagonal, b.whole.diagonal)
    by_points = [side for side in (a, b) if side.material.only_point_stiffness]
    flexibility = 0.0
    if by_points:
        k_point = 1 / sum(1 / side.material.point_stiffness for side in by_points)
        flexibility += 1 / _foundation_of_point(a, b, k_point, usual)
    layers = [
        (side.material.modulus, skin or side.material.skin or usual)
        for side in (a, b)
        if side not in by_points
    ]
    flexibility += sum(thickness / modulus for modulus, thickness in layers)
    if flexibility == 0:
        flexibility = sum(thickness for _, thickness in layers) / STIFFEST_MODULUS
    return 1 / flexibility


def point_area(a: Side, b: Side) -> float | None:
    """Return the area [m²] on which a point bears; None where neither geometry stands for one.

    A sphere smaller than the skin of the smaller whole body is a point. It presses on as much of
    the foundation as a flat punch as wide as the skin is thick.
    """
    skin = SKIN * min(a.whole.diagonal, b.whole.diagonal)
    for side, other in ((a, b), (b, a)):
        primitive = side.mesh.primitive
        if (
            primitive is not None
            and primitive.kind == "sphere"
            and primitive.size[0] < skin
            and other.mesh.solid.has_inside
        ):
            return math.pi * skin**2
    return None


def nominal_load(a: Side, b: Side) -> float:
    """Return the weight of the lighter body [N], of what has one."""
    weight = min(a.whole.weight, b.whole.weight)
    return weight if 0 < weight < math.inf else _USUAL_LOAD


def _foundation_of_point(a: Side, b: Side, k_point: float, skin: float) -> float:
    if (area := point_area(a, b)) is not None:
        return k_point / area
    smaller = min(a, b, key=lambda side: side.mesh.diagonal)
    load = nominal_load(a, b)
    stiffness = load / _largest_yield(smaller.mesh, load / k_point)
    if smaller.mesh.diagonal < _PIECE * smaller.whole.diagonal:
        return min(stiffness, STIFFEST_MODULUS / skin)
    return stiffness


def _largest_yield(mesh: CollisionMesh, depth: float) -> float:
    """Return the largest V [m³] of a plane across an axis, at a depth [m]; see the module."""
    if mesh.primitive is not None and mesh.primitive.kind == "sphere":
        # The plane probes the ball: the depth R - s counts by its share (R - x)/s upwards.
        (radius,) = mesh.primitive.size
        depth = min(depth, radius / 2)
        return math.pi * (radius - depth) * depth**2
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    corners = np.stack([a, b, c], axis=1)
    sides = (corners - mesh.lower, mesh.upper - corners)
    return max(
        float(areas @ _mean_excess(side[:, :, axis], depth)) for side in sides for axis in range(3)
    )


def _mean_excess(height: NDArray[np.float64], depth: float) -> NDArray[np.float64]:
    """Return the mean of max(0, depth - h) over triangles, h linear between (nf, 3) corners."""
    low, middle, high = np.sort(height, axis=1).T
    below = np.clip(depth - low, 0, None) ** 3
    beyond = np.clip(high - depth, 0, None) ** 3
    with np.errstate(divide="ignore", invalid="ignore"):  # only where not chosen
        tip = below / (3 * (middle - low) * (high - low))
        all_but_tip = depth - height.mean(axis=1) + beyond / (3 * (high - low) * (high - middle))
    conditions = [depth <= low, depth >= high, depth <= middle]
    return np.select(conditions, [0.0, depth - height.mean(axis=1), tip], all_but_tip)
