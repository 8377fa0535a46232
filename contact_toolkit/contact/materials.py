"""Materials: named parameter sets, each with its source or reasoning.

Handbook figures scatter by tens of percent with finish, dirt and temperature: they are starting
points. Coefficients are those of a surface on its like unless the source says otherwise; two
surfaces combine as in Drake. Restitution is that of an impact at 1 m/s on a like body, where the
damping of both sides is the same.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType

from contact_toolkit.contact.contact_law import NonlinearDamper

# [Pa] A skin of 1 mm with this modulus gives way by 0.1 mm under 1 kN on 1 cm². Stiffer solids are
# given this modulus in simulation: neither restitution nor friction depends on it, and a contact a
# hundred times stiffer takes ten times the steps.
STIFFEST_MODULUS = 1e8


@dataclass(frozen=True)
class Material:
    """What one side of a contact is made of.

    Attributes
    ----------
    youngs_modulus
        [Pa].
    restitution
        e of an impact at 1 m/s, above 0.
    static_friction, dynamic_friction
        Coefficients.
    source
        Where the figures come from, or why they are what they are.
    stiffness_ratio, damping
        As in `Friction`: media that only resist motion have the ratio 0 and a damping [s].
    adhesion
        Whether it holds on to what is pulled from it.
    skin
        Thickness [m] of the layer that gives way, for media whose depth is their own; else None.
    """

    youngs_modulus: float
    restitution: float
    static_friction: float
    dynamic_friction: float
    source: str
    stiffness_ratio: float = 2 / 3
    damping: float | None = None
    adhesion: bool = False
    skin: float | None = None

    @property
    def modulus(self) -> float:
        """The modulus to simulate with [Pa]: Young's, up to `STIFFEST_MODULUS`."""
        return min(self.youngs_modulus, STIFFEST_MODULUS)

    @property
    def alpha(self) -> float:
        """Restitution slope [s/m] that gives the restitution at 1 m/s."""
        return NonlinearDamper.alpha_for(self.restitution, 1.0)


MATERIALS = MappingProxyType(
    {
        "steel": Material(
            youngs_modulus=2.1e11,
            restitution=0.85,
            static_friction=0.74,
            dynamic_friction=0.57,
            source="Coefficients: dry on steel, physics handbooks. Restitution gives α = 0.17 s/m; "
            "Hunt and Crossley (1975) quote 0.08 to 0.32 s/m for steel, bronze and ivory.",
        ),
        "aluminium": Material(
            youngs_modulus=7.0e10,
            restitution=0.8,
            static_friction=0.52,
            dynamic_friction=0.40,
            source="Coefficients: chosen so that on steel they combine to the handbooks' 0.61 and "
            "0.47; clean aluminium on itself galls and may exceed 1. Restitution: it yields "
            "earlier than steel, hence below it.",
        ),
        "hard plastic": Material(
            youngs_modulus=2.5e9,
            restitution=0.75,
            static_friction=0.35,
            dynamic_friction=0.30,
            source="ABS and acetal, makers' data sheets: 2 to 3 GPa, 0.2 to 0.4 on themselves. "
            "Restitution: of moulded balls and housings dropped from centimetres, 0.7 to 0.8.",
        ),
        "rubber": Material(
            youngs_modulus=5.0e6,
            restitution=0.7,
            static_friction=1.0,
            dynamic_friction=0.8,
            source="Coefficients: on dry concrete, physics handbooks. Modulus: of vulcanised "
            "rubber of about 60 Shore A. Restitution: tyre compounds have 0.5, lively ones 0.85.",
        ),
        "wood": Material(
            youngs_modulus=5.0e8,
            restitution=0.6,
            static_friction=0.5,
            dynamic_friction=0.3,
            source="Coefficients: on wood, physics handbooks. Modulus: of softwood across the "
            "grain, a twentieth of that along it. Restitution: blocks dropped from centimetres.",
        ),
        "ice": Material(
            youngs_modulus=9.0e9,
            restitution=0.8,
            static_friction=0.1,
            dynamic_friction=0.03,
            source="Coefficients: on ice, physics handbooks; near melting, less. Restitution: of "
            "intact ice at moderate speed; once it cracks, far less.",
        ),
        "mud": Material(
            youngs_modulus=2.0e4,
            restitution=0.05,
            static_friction=0.5,
            dynamic_friction=0.5,
            stiffness_ratio=0.0,
            damping=0.1,
            adhesion=True,
            skin=0.1,
            source="Reasoned: 20 kPa, a boot's sole, sink through the 0.1 m of it; impacts die; it "
            "yields sideways as slowly as it is pushed, and holds on.",
        ),
        "tall grass": Material(
            youngs_modulus=3.0e3,
            restitution=0.2,
            static_friction=0.35,
            dynamic_friction=0.35,
            stiffness_ratio=0.0,
            damping=0.02,
            skin=0.3,
            source="Reasoned: stalks 0.3 m tall lie down under a few kilopascal and drag. "
            "Coefficients: of a tyre on grass, engineering tables.",
        ),
        "sand": Material(
            youngs_modulus=1.0e6,
            restitution=0.1,
            static_friction=0.65,
            dynamic_friction=0.6,
            skin=0.05,
            source="Coefficients: tangent of the angle of repose of dry sand, 30° to 34°. Modulus: "
            "of a loose top layer; soil mechanics gives ten times as much for firm sand. "
            "Restitution: grains carry the energy away. Craters do not stay: the law is elastic.",
        ),
    }
)
"""Parameter sets by name."""


def find_material(name: str) -> Material:
    """Return the material called `name`; raises ValueError naming those there are.

    Examples
    --------
    >>> from contact_toolkit import MATERIALS, find_material
    >>> rubber = find_material("rubber")
    >>> rubber is MATERIALS["rubber"], rubber.static_friction
    (True, 1.0)
    >>> find_material("cheese")  # doctest: +ELLIPSIS
    Traceback (most recent call last):
    ValueError: no material 'cheese'; there are steel, ...
    """
    if name not in MATERIALS:
        raise ValueError(f"no material {name!r}; there are {', '.join(MATERIALS)}")
    return MATERIALS[name]
