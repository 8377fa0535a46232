"""Contact parameters that a model's proximity properties carry."""

from __future__ import annotations

import math
from dataclasses import dataclass

from pydrake.geometry import ProximityProperties


@dataclass(frozen=True)
class ProximityMaterial:
    """What a geometry is tagged with; None where it is not.

    Attributes
    ----------
    static_friction, dynamic_friction
        Coulomb coefficients.
    dissipation
        Hunt-Crossley dissipation d [s/m].
    modulus
        Hydroelastic modulus [Pa]; infinite for a rigid hydroelastic geometry.
    point_stiffness
        Point contact stiffness [N/m].
    """

    static_friction: float | None = None
    dynamic_friction: float | None = None
    dissipation: float | None = None
    modulus: float | None = None
    point_stiffness: float | None = None


def read_material(properties: ProximityProperties) -> ProximityMaterial:
    """Read the properties that bear on contact."""

    def number(group: str, name: str) -> float | None:
        if not properties.HasProperty(group, name):
            return None
        return float(properties.GetProperty(group, name))

    friction = (
        properties.GetProperty("material", "coulomb_friction")
        if properties.HasProperty("material", "coulomb_friction")
        else None
    )
    modulus = number("hydroelastic", "hydroelastic_modulus")
    if modulus is None and properties.HasProperty("hydroelastic", "compliance_type"):
        modulus = math.inf  # the compliance type itself is not readable from Python
    return ProximityMaterial(
        static_friction=friction.static_friction() if friction else None,
        dynamic_friction=friction.dynamic_friction() if friction else None,
        dissipation=number("material", "hunt_crossley_dissipation"),
        modulus=modulus,
        point_stiffness=number("material", "point_contact_stiffness"),
    )
