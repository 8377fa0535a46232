"""Contact parameters that a model already carries in its proximity properties."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from pydrake.geometry import DefaultProximityProperties, ProximityProperties

from contact_toolkit import find_material


@dataclass(frozen=True)
class ProximityMaterial:
    """What Drake's own contact would take a geometry to be made of.

    Attributes
    ----------
    static_friction, dynamic_friction
        Coulomb coefficients.
    dissipation
        Hunt-Crossley dissipation [s/m].
    modulus
        Hydroelastic modulus [Pa]; infinite for a rigid hydroelastic geometry.
    point_stiffness
        Point contact stiffness [N/m].
    stiffness_ratio, damping, adhesion, skin
        As in `contact_toolkit.Material`; no properties of Drake's, hence None unless from there.
    """

    static_friction: float
    dynamic_friction: float
    dissipation: float
    modulus: float
    point_stiffness: float
    stiffness_ratio: float | None = None
    damping: float | None = None
    adhesion: bool = False
    skin: float | None = None


def library_material(name: str) -> ProximityMaterial:
    """Return a material of the library; raises ValueError for a name it does not know."""
    material = find_material(name)
    return ProximityMaterial(
        static_friction=material.static_friction,
        dynamic_friction=material.dynamic_friction,
        dissipation=1.5 * material.alpha,
        modulus=material.modulus,
        point_stiffness=math.inf,
        stiffness_ratio=material.stiffness_ratio,
        damping=material.damping,
        adhesion=material.adhesion,
        skin=material.skin,
    )


def read_material(
    properties: ProximityProperties, defaults: DefaultProximityProperties
) -> ProximityMaterial:
    """Read the properties that bear on contact; what is missing is as SceneGraph's defaults."""

    def read(group: str, name: str, default: Any) -> Any:
        return properties.GetPropertyOrDefault(group, name, default)

    # A default that is itself unset means no friction, no loss, no give.
    static, dynamic = defaults.static_friction or 0.0, defaults.dynamic_friction or 0.0
    if properties.HasProperty("material", "coulomb_friction"):
        friction = properties.GetProperty("material", "coulomb_friction")
        static, dynamic = friction.static_friction(), friction.dynamic_friction()
    # The compliance type is not readable from Python; only rigid geometry has one and no modulus.
    rigid = properties.HasProperty("hydroelastic", "compliance_type")
    modulus = math.inf if rigid else defaults.hydroelastic_modulus or math.inf
    return ProximityMaterial(
        static_friction=static,
        dynamic_friction=dynamic,
        dissipation=read(
            "material", "hunt_crossley_dissipation", defaults.hunt_crossley_dissipation or 0.0
        ),
        modulus=read("hydroelastic", "hydroelastic_modulus", modulus),
        point_stiffness=read(
            "material", "point_contact_stiffness", defaults.point_stiffness or math.inf
        ),
    )
