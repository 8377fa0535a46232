"""Settings of contact, loadable with `pydrake.common.yaml.yaml_load_typed`.

How to choose them, and what they cost: `notebooks/03_choosing_parameters.ipynb`.

None stands for "not set": an override falls back on the `ContactConfig`, and that on the model's
own proximity properties and then on Drake's defaults, as said beside each setting. Values are
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
    stiffness_ratio
        As in `contact_toolkit.Friction`, with its default.
    damping
        As there [s]. Area web: unless set, by which the lighter body swings out on the friction
        springs of a face at half of the critical damping.

    Examples
    --------
    >>> from systems import ContactConfig, FrictionConfig
    >>> ContactConfig(friction=FrictionConfig(static=0.6)).friction.static
    0.6
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
        geometries over their skins, in series. A geometry that was given a point contact stiffness
        and nothing else yields by that much force per depth under the weight of the lighter body.
        Two rigid geometries have skins of 1e8 Pa, ten times Drake's default. A sphere of less than
        1 % of the smaller body's diagonal is a point, which bears on a circle with that radius.
        Facet web: spring constant [N/mⁿ]; when unset, the point contact stiffnesses, in series.
    skin
        Thickness of the compliant skins [m]; unless set, that of a material which has one, and 1 %
        of the bounding box diagonal of the smaller body, with all that is welded to it.
    alpha
        Restitution slope [s/m]; when unset, 2/3 of the Hunt-Crossley dissipations, combined as
        Drake does. Geometry without one has 3.1 s/m, restitution 0.3 at 1 m/s (Drake's 50 s/m
        serves its steps).
    n
        Exponent of the deformation, from 1 (the default) to 1.5 (Hertz).
    settling
        Area web with n = 1: settling speed [m/s], 0 for the law as published. The smallest motions
        at a contact, which that hardly damps, die out at half of the critical damping, and
        restitution falls by less than 3/2 `alpha` times this; see `NonlinearDamper`. Unless set,
        that is 0.01, with a settling speed from 0.001 to 0.1 m/s.
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
    settling: float | None = None
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

    Examples
    --------
    >>> from systems import ContactConfig, PairConfig
    >>> soft = PairConfig(bodies=["foot", "ground"], k=1e7, alpha=2.0)
    >>> ContactConfig(alpha=0.2, overrides=[soft]).overrides[0].alpha
    2.0
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
    discrete
        How contact meets the steps of a discrete plant: "implicit" (solved with the step, stable at
        any stiffness) or "explicit" (as the step begins, for comparison).
    hold_anchors
        Leave friction's anchors where `NonlinearDamperContact.SetContactState` puts them, so that
        contact of a continuous plant has no state: for `Linearize` and trajectory optimization.
    max_step
        Longest step [s] of a continuous plant, so that nothing crosses a body unseen; 0: no limit.
    when_deep
        "warn" (once) or "raise" when bodies penetrate farther than the web can tell.
    when_chattering
        "raise" or "warn" (once) when forces that leap, as between flat faces of the facet web,
        leave the integrator of a continuous plant only steps that get nowhere.
    initial_overlap
        What becomes of bodies that overlap when a simulation begins, by more than half of their
        skins and ten times their weight. "ease" (the default): links of one tree of joints pass
        through each other from then on, and so does what the joints of a mounted robot hold in
        place; all others are parted gently.
        "filter": all of them pass through each other. "warn": they are flung apart. Each of these
        tells of it. "raise": an error.
    easing_time
        How long [s] it takes to part what is eased out.
    threads
        Native threads that share the pairs; the result does not depend on it.

    Examples
    --------
    >>> from pydrake.common.yaml import yaml_load_typed
    >>> from systems import ContactConfig
    >>> config = yaml_load_typed(schema=ContactConfig, data='''
    ... k: 1.0e+9
    ... friction: {static: 0.6}
    ... overrides:
    ... - {bodies: [foot, ground], k: 1.0e+7}
    ... ''')
    >>> config.k, config.friction.static, config.overrides[0].bodies
    (1000000000.0, 0.6, ['foot', 'ground'])
    """

    pairs: list[list[str]] = dataclasses.field(default_factory=list)
    overrides: list[PairConfig] = dataclasses.field(default_factory=list)
    materials: dict[str, str] = dataclasses.field(default_factory=dict)
    tessellation_tolerance: float = 0.005
    half_space_reach: float = 100.0
    discrete: str = "implicit"
    hold_anchors: bool = False
    max_step: float = 0.005
    when_deep: str = "warn"
    when_chattering: str = "raise"
    initial_overlap: str = "ease"
    easing_time: float = 0.2
    threads: int = 1
