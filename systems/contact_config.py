"""Settings of contact, loadable with `pydrake.common.yaml.yaml_load_typed`.

How to choose them, and what they cost: `notebooks/02_choosing_parameters.ipynb`.

None stands for "not set": an override falls back on the `ContactConfig`, and that on the model's
own proximity properties and then on Drake's defaults, as told beside each setting. Values are
checked where they are used, by `AddNonlinearDamperContact`: the loader fills in fields late.
"""

# No `from __future__ import annotations`: the loader reads the annotations as types.
import dataclasses
from dataclasses import dataclass


@dataclass
class FrictionConfig:
    """Anchored Coulomb friction.

    Attributes
    ----------
    static, dynamic
        Coefficients; when unset, those of the two geometries, combined as Drake does. `static`
        alone sets both.
    stiffness_ratio, damping
        As in `contact_toolkit.Friction`, with its defaults.
    """

    static: float | None = None
    dynamic: float | None = None
    stiffness_ratio: float | None = None
    damping: float | None = None


@dataclass
class ContactLawConfig:
    """How two geometries push on each other.

    Attributes
    ----------
    web
        Where the springs are: "area" (an elastic foundation, the default) or "facet" (one spring a
        witness pair).
    standoff
        Distance [m] at which contact begins. Area web: 0 unless set. Facet web: must be set.
    k
        Area web: foundation stiffness [Pa/mⁿ]; when unset, the hydroelastic moduli of the two
        geometries over their skins, in series. Facet web: spring constant [N/mⁿ]; when unset, the
        point contact stiffnesses, in series.
    skin
        Thickness of the compliant skins [m]; unless set, that of a material which has one, and 1 %
        of the bounding box diagonal of the smaller geometry.
    alpha
        Restitution slope [s/m]; when unset, 2/3 of the Hunt-Crossley dissipations, combined as
        Drake does.
    n
        Exponent of the deformation, from 1 (the default) to 1.5 (Hertz).
    adhesion
        Whether the force may pull while bodies are torn apart; unless set, as the materials say.
    weighting
        Facet web: "multiplicity" (the default) or "unit", as published.
    field
        Area web: the signed distance field of the probed body, "smooth" (the default) or "exact".
    resolution
        Area web: spacing of the nodes, relative to the bounding box diagonal of the smaller
        geometry, 0.02 unless set; four times closer along sharp edges. Time goes with the number of
        nodes in contact.
    fillet
        Area web: radius [m] of the geometries' sharp edges, by which crossing edges bear load; none
        unless set.
    friction
        See `FrictionConfig`.
    """

    web: str | None = None
    standoff: float | None = None
    k: float | None = None
    skin: float | None = None
    alpha: float | None = None
    n: float | None = None
    adhesion: bool | None = None
    weighting: str | None = None
    field: str | None = None
    resolution: float | None = None
    fillet: float | None = None
    friction: FrictionConfig = dataclasses.field(default_factory=FrictionConfig)


@dataclass
class PairConfig(ContactLawConfig):
    """Settings of one pair of bodies that differ from the rest.

    Attributes
    ----------
    bodies
        Two body names, in either order.
    """

    bodies: list[str] = dataclasses.field(default_factory=list)


@dataclass
class ContactConfig(ContactLawConfig):
    """Which bodies touch by the nonlinear damper, and how.

    Bodies are named as in the plant, `body` where that is unambiguous, else `model::body`.

    Attributes
    ----------
    pairs
        Pairs of body names taken over from the built-in contact; empty: every pair of collision
        geometries that SceneGraph does not filter.
    overrides
        Exceptions for some of these pairs; a later one wins.
    materials
        Body name to the name of a material in `contact_toolkit.MATERIALS`, which takes the place of
        the proximity properties of the body's geometries.
    tessellation_tolerance
        How far facets may lie inside a curved shape, relative to its radius.
    half_space_reach
        Radius [m] about its origin within which a half space is felt.
    max_step
        Longest step [s] of a continuous plant, so that nothing crosses a body unseen; 0: no limit.
    when_deep
        "warn" (once) or "raise" when bodies penetrate farther than the web can tell.
    when_chattering
        "raise" or "warn" (once) when forces that leap, as between flat faces of the facet web,
        leave the integrator of a continuous plant only steps that get nowhere.
    threads
        Native threads that share the pairs; the result does not depend on it.
    """

    pairs: list[list[str]] = dataclasses.field(default_factory=list)
    overrides: list[PairConfig] = dataclasses.field(default_factory=list)
    materials: dict[str, str] = dataclasses.field(default_factory=dict)
    tessellation_tolerance: float = 0.005
    half_space_reach: float = 100.0
    max_step: float = 0.005
    when_deep: str = "warn"
    when_chattering: str = "raise"
    threads: int = 1
