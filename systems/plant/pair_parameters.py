"""Work out the contact law of two geometries from settings, materials and their properties."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

from contact_toolkit import ContactPair, Friction, NonlinearDamper
from systems.contact_config import ContactLawConfig, FrictionConfig
from systems.plant.pair_stiffness import Side, foundation_stiffness, nominal_load, point_area
from systems.plant.pair_web import make_web, web_name
from systems.plant.proximity_material import ProximityMaterial

_USUAL_LOSS = 0.01  # [-] of the speed of what settles; less of what is faster
_SLOWEST_SETTLING, _FASTEST_SETTLING = 1e-3, 0.1  # [m/s]

_GRAVITY = 9.81  # [m/s²]
_LONGEST_DAMPING = 5e-3  # [s] of small geometries of heavy bodies


def make_contact_pair(a: Side, b: Side, law: ContactLawConfig) -> ContactPair:
    """Return the pair with every parameter decided: by `law`, else by the materials of the sides.

    Raises ValueError for values that make no sense, and where one is needed that nothing tells.
    """
    loads = [side.whole.load for side in (a, b) if side.whole.load > 0]
    n = 1.0 if law.n is None else law.n
    area = point_area(a, b) if web_name(law) == "area" and n == 1 else None
    web = make_web(law, load=min(loads, default=math.inf), point=area is not None)
    damper = NonlinearDamper(
        k=_stiffness(a, b, web_name(law), n, law.skin) if law.k is None else law.k,
        alpha=2 / 3 * _dissipation(a.material, b.material) if law.alpha is None else law.alpha,
        n=n,
        adhesion=(
            a.material.adhesion or b.material.adhesion if law.adhesion is None else law.adhesion
        ),
    )
    friction = _friction(a.material, b.material, law.friction)
    if web_name(law) == "area" and n == 1:
        swing = _Swing(a, b, damper.k, area)
        speed = _usual_settling(damper.alpha) if law.settling is None else law.settling
        if speed * damper.alpha > 0:
            smallest = swing.smallest(speed, damper.alpha)
            damper = dataclasses.replace(damper, settling=speed, smallest=smallest)
        if friction.damping is None and friction.stiffness_ratio > 0:
            friction = dataclasses.replace(
                friction, damping=swing.friction(friction.stiffness_ratio)
            )
    if area is not None:
        damper = dataclasses.replace(damper, k=damper.k * area)
    return ContactPair(a.index, b.index, damper, web, friction)


def overlay(base: ContactLawConfig, exception: ContactLawConfig) -> ContactLawConfig:
    """Return `base` with whatever `exception` sets."""
    names = [field.name for field in dataclasses.fields(ContactLawConfig)]
    settings = _given(base, *names) | _given(exception, *names)
    given = vars(base.friction) | _given(exception.friction, *vars(exception.friction))
    return ContactLawConfig(**settings | {"friction": FrictionConfig(**given)})


def _given(settings: object, *names: str) -> dict[str, Any]:
    values = {name: getattr(settings, name) for name in names}
    return {name: value for name, value in values.items() if value is not None}


def _usual_settling(alpha: float) -> float:
    """Return the settling speed [m/s] of the area web.

    What is put down on hard ground rattles at about g over its frequency, where a small α damps too
    little to stop it: the slower the damping, the faster the motions that must die out.
    """
    fastest = _USUAL_LOSS / (1.5 * alpha) if alpha > 0 else math.inf
    return min(max(fastest, _SLOWEST_SETTLING), _FASTEST_SETTLING)


class _Swing:
    """The lighter body on the springs under its face, to whose motions small damping is fitted.

    What little the law damps near rest lets a box on a slope rock for ever, and walk down it by the
    nodes that are unloaded in turn; stacks sway.
    """

    def __init__(self, a: Side, b: Side, k: float, area: float | None) -> None:
        if area is None:
            area = min(side.mesh.diagonal for side in (a, b)) ** 2 / 3  # of a cube's face
        self.frequency = math.sqrt(k * area * _GRAVITY / nominal_load(a, b))

    def smallest(self, settling: float, alpha: float) -> float:
        """Return the speed w [m/s] at which up and down half of the critical damping is added."""
        return 1.5 * alpha * settling * _GRAVITY / self.frequency  # 3/2 α s/w (m g) = m ω

    def friction(self, stiffness_ratio: float) -> float:
        """Return the damping [s] at which it swings to and fro at half of the critical damping."""
        return min(1 / (self.frequency * math.sqrt(stiffness_ratio)), _LONGEST_DAMPING)


def _stiffness(a: Side, b: Side, web: str, n: float, skin: float | None) -> float:
    if n != 1:
        raise ValueError(f"Drake's properties are of linear springs: with n = {n}, set k")
    if web == "area":
        return foundation_stiffness(a, b, skin)
    k = _in_series(a.material.point_stiffness, b.material.point_stiffness)
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
        given_values = [x for x in (getattr(a, name), getattr(b, name)) if x is not None]
        if given_values:
            given.setdefault(name, choose(given_values))
    return Friction(static, dynamic, **given)
