"""Contact parameters that a model already carries in its proximity properties."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from pydrake.geometry import DefaultProximityProperties, ProximityProperties

from contact_toolkit import NonlinearDamper, find_material


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
    only_point_stiffness
        Whether that is the only stiffness it was given.
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
    only_point_stiffness: bool = False


# Of what carries no dissipation. Drake fills in 50 s/m, which stops a fall of 5 cm dead and parts
# overlapping bodies at no more than 1/50 m/s; that suits its steps, not a material. Parts of robots
# and household things bounce at e = 0.2 to 0.5, as their shells and joints take away more than the
# material does (0.6 to 0.85); and at 0.3 a body at rest on its contact stops ringing within 0.1 s.
USUAL_DISSIPATION = 1.5 * NonlinearDamper.alpha_for(0.3, 1.0)
"""Hunt-Crossley dissipation [s/m] of restitution 0.3 at 1 m/s."""


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
    """Read the properties that bear on contact; what is missing is as SceneGraph's defaults.

    Except for a dissipation that nobody chose: Drake's own default gives way to
    `USUAL_DISSIPATION`; one set in `SceneGraphConfig` counts.
    """

    def read(group: str, name: str, default: Any) -> Any:
        return properties.GetPropertyOrDefault(group, name, default)

    # A default that is itself unset means no friction, no loss, no give.
    static, dynamic = defaults.static_friction or 0.0, defaults.dynamic_friction or 0.0
    if properties.HasProperty("material", "coulomb_friction"):
        friction = properties.GetProperty("material", "coulomb_friction")
        static, dynamic = friction.static_friction(), friction.dynamic_friction()
    # The compliance type is not readable from Python; only rigid geometry has one and no modulus.
    rigid = properties.HasProperty("hydroelastic", "compliance_type")
    compliant = properties.HasProperty("hydroelastic", "hydroelastic_modulus")
    pointwise = properties.HasProperty("material", "point_contact_stiffness")
    modulus = math.inf if rigid else defaults.hydroelastic_modulus or math.inf
    return ProximityMaterial(
        static_friction=static,
        dynamic_friction=dynamic,
        dissipation=read("material", "hunt_crossley_dissipation", _default_dissipation(defaults)),
        modulus=read("hydroelastic", "hydroelastic_modulus", modulus),
        point_stiffness=read(
            "material", "point_contact_stiffness", defaults.point_stiffness or math.inf
        ),
        only_point_stiffness=pointwise and not (rigid or compliant),
    )


def _default_dissipation(defaults: DefaultProximityProperties) -> float:
    chosen = defaults.hunt_crossley_dissipation
    if chosen == DefaultProximityProperties().hunt_crossley_dissipation:
        return USUAL_DISSIPATION
    return chosen or 0.0
