"""Work out the contact law of two geometries from settings, materials and their properties."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any, Literal

from contact_toolkit import CollisionMesh, ContactPair, Friction, NonlinearDamper
from systems.contact_config import ContactLawConfig, FrictionConfig
from systems.proximity_material import ProximityMaterial

_SKIN = 0.01  # of the smaller geometry's diagonal: thin beside it, yet soft enough to integrate


@dataclass(frozen=True)
class Side:
    """One geometry of a pair: its index in the contact model, its mesh, and what it is made of."""

    index: int
    mesh: CollisionMesh
    material: ProximityMaterial


def make_contact_pair(a: Side, b: Side, law: ContactLawConfig) -> ContactPair:
    """Return the pair with every parameter decided: by `law`, else by the materials of the sides.

    Raises ValueError for values that make no sense, and where one is needed that nothing tells.
    """
    web = _web(law.web)
    if web == "facet" and law.standoff is None:
        raise ValueError(
            "the facet web needs a distance [m] > 0 at which contact begins: set standoff"
        )
    n = 1.0 if law.n is None else law.n
    damper = NonlinearDamper(
        k=_stiffness(a, b, web, n, law.skin) if law.k is None else law.k,
        alpha=2 / 3 * _dissipation(a.material, b.material) if law.alpha is None else law.alpha,
        n=n,
        adhesion=(
            a.material.adhesion or b.material.adhesion if law.adhesion is None else law.adhesion
        ),
    )
    return ContactPair(
        a.index,
        b.index,
        damper,
        web=web,
        friction=_friction(a.material, b.material, law.friction),
        **_given(law, "standoff", "weighting", "field", "resolution", "fillet"),
    )


def overlay(base: ContactLawConfig, exception: ContactLawConfig) -> ContactLawConfig:
    """Return `base` with whatever `exception` sets."""
    names = [field.name for field in dataclasses.fields(ContactLawConfig)]
    settings = _given(base, *names) | _given(exception, *names)
    given = vars(base.friction) | _given(exception.friction, *vars(exception.friction))
    return ContactLawConfig(**settings | {"friction": FrictionConfig(**given)})


def _web(web: str | None) -> Literal["area", "facet"]:
    match web:
        case None | "area":
            return "area"
        case "facet":
            return "facet"
        case _:
            raise ValueError(f"web must be 'area' or 'facet', not {web!r}")


def _given(settings: object, *names: str) -> dict[str, Any]:
    values = {name: getattr(settings, name) for name in names}
    return {name: value for name, value in values.items() if value is not None}


def _stiffness(a: Side, b: Side, web: str, n: float, skin: float | None) -> float:
    if n != 1:
        raise ValueError(f"Drake's properties are of linear springs: with n = {n}, set k")
    if web == "facet":
        k = _in_series(a.material.point_stiffness, b.material.point_stiffness)
    else:
        if skin is not None and not skin > 0:
            raise ValueError(f"skin must be a thickness [m] > 0, not {skin}")
        usual = _SKIN * min(a.mesh.diagonal, b.mesh.diagonal)
        k = _in_series(
            *(side.material.modulus / (skin or side.material.skin or usual) for side in (a, b))
        )
    if not math.isfinite(k):
        raise ValueError("neither geometry gives way: set k, or make one compliant")
    return k


def _in_series(a: float, b: float) -> float:
    return 1 / (1 / a + 1 / b) if math.isfinite(a) or math.isfinite(b) else math.inf


def _dissipation(a: ProximityMaterial, b: ProximityMaterial) -> float:
    """Combine as Drake does: the softer side, which deforms more, counts more."""
    if a.modulus == b.modulus:
        return (a.dissipation + b.dissipation) / 2
    series = _in_series(a.modulus, b.modulus)
    return series / a.modulus * a.dissipation + series / b.modulus * b.dissipation


def _friction(a: ProximityMaterial, b: ProximityMaterial, settings: FrictionConfig) -> Friction:
    """Take the settings; combine the coefficients of the two sides where there are none."""
    static, dynamic = settings.static, settings.dynamic
    if static is None:
        static = Friction.combined_coefficient(a.static_friction, b.static_friction)
        if dynamic is None:
            dynamic = Friction.combined_coefficient(a.dynamic_friction, b.dynamic_friction)
    given = _given(settings, "stiffness_ratio", "damping")
    # Two materials: the more yielding spring, and the stronger damping.
    for name, choose in (("stiffness_ratio", min), ("damping", max)):
        told = [x for x in (getattr(a, name), getattr(b, name)) if x is not None]
        if told:
            given.setdefault(name, choose(told))
    return Friction(static, dynamic, **given)
