"""The spring webs: where the springs between two geometries are, and what is asked of them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class AreaWeb:
    """An elastic foundation over the surface of one body, probing the signed distance of the other.

    Its stiffness is in [Pa/mⁿ]. The answer does not depend on how the bodies are meshed.

    Parameters
    ----------
    standoff
        Distance [m] at which contact begins, at least 0; positive where the probed surface is open.
    field
        How the probed body is seen: "smooth" (continuous forces, fast; convex edges slightly
        rounded) or "exact". Primitives are always seen exactly.
    resolution
        Spacing of the nodes as a fraction of the smaller bounding box's diagonal, from 1e-4 to 1,
        where bodies are not flat. None: 0.02, or as much less as a round primitive needs under
        `nominal_force`.
    sampled
        Which body carries the nodes: "a", "b" or "auto", the smaller one unless it is made of flat
        sides and the other is not, or the other is much thinner. A capsule or cylinder on a box or
        half space, which takes few nodes.
    fillet
        Radius [m] of the sharp convex edges of both bodies, by which crossing edges bear load; 0:
        none.
    nominal_force
        Force [N] that the contact usually bears, such as the lighter body's weight: by it nodes are
        chosen where a primitive is round. None: the weight of the smaller geometry were it water.

    Raises
    ------
    ValueError
        Naming the parameter out of range.

    Examples
    --------
    >>> from contact_toolkit import AreaWeb, ContactPair, NonlinearDamper
    >>> ContactPair(0, 1, NonlinearDamper(k=1e9), AreaWeb(resolution=0.1)).web.standoff
    0.0
    """

    standoff: float = 0.0
    field: Literal["smooth", "exact"] = "smooth"
    resolution: float | None = None
    sampled: Literal["auto", "a", "b"] = "auto"
    fillet: float = 0.0
    nominal_force: float | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.standoff) and self.standoff >= 0):
            raise ValueError(f"standoff must be finite and not negative, not {self.standoff}")
        _require_choice("field", self.field, ("smooth", "exact"))
        if self.resolution is not None and not 1e-4 <= self.resolution <= 1:
            raise ValueError(
                f"resolution must be a fraction of the diagonal, between 1e-4 and 1, not "
                f"{self.resolution}"
            )
        _require_choice("sampled", self.sampled, ("auto", "a", "b"))
        if not (math.isfinite(self.fillet) and self.fillet >= 0):
            raise ValueError(f"fillet must be finite and not negative, not {self.fillet}")
        if self.nominal_force is not None and not 0 < self.nominal_force < math.inf:
            raise ValueError(
                f"nominal_force must be finite and positive, not {self.nominal_force}; leave it "
                "out for the default"
            )


@dataclass(frozen=True)
class FacetWeb:
    """A spring for every witness pair; the spring constant is in [N/mⁿ].

    Parameters
    ----------
    standoff
        Distance [m] at which contact begins; positive, as the distances have no sign.
    weighting
        "multiplicity" (each merged witness pair counts as often as the facet pairs behind it:
        continuous and conservative) or "unit" (once, as published).

    Raises
    ------
    ValueError
        Naming the parameter out of range.

    Examples
    --------
    >>> from contact_toolkit import ContactPair, FacetWeb, NonlinearDamper
    >>> ContactPair(0, 1, NonlinearDamper(k=25.0), FacetWeb(standoff=0.0015)).web.weighting
    'multiplicity'
    >>> FacetWeb(standoff=0.0)
    Traceback (most recent call last):
    ValueError: the facet web needs a positive standoff, as its distances have no sign, not 0.0
    """

    standoff: float
    weighting: Literal["multiplicity", "unit"] = "multiplicity"

    def __post_init__(self) -> None:
        if not (math.isfinite(self.standoff) and self.standoff > 0):
            raise ValueError(
                f"the facet web needs a positive standoff, as its distances have no sign, not "
                f"{self.standoff}"
            )
        _require_choice("weighting", self.weighting, ("multiplicity", "unit"))


@dataclass(frozen=True)
class PointWeb:
    """One spring at the centre of a small sphere; the spring constant is in [N/m], linear.

    For balls that stand for points: F = k (standoff + r - φ), with φ the other body's exact signed
    distance of the centre, through which the force acts. One geometry must be a primitive sphere,
    the other a solid; of two spheres the smaller one is the point.

    Parameters
    ----------
    standoff
        Distance [m] at which contact begins, at least 0.

    Raises
    ------
    ValueError
        Naming the parameter out of range.

    Examples
    --------
    >>> from contact_toolkit import ContactPair, NonlinearDamper, PointWeb
    >>> ContactPair(0, 1, NonlinearDamper(k=1e5), PointWeb()).web.standoff
    0.0
    """

    standoff: float = 0.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.standoff) and self.standoff >= 0):
            raise ValueError(f"standoff must be finite and not negative, not {self.standoff}")


SpringWeb = AreaWeb | FacetWeb | PointWeb


def _require_choice(name: str, value: str, choices: tuple[str, ...]) -> None:
    if value not in choices:
        raise ValueError(f"{name} must be one of {list(choices)}, not {value!r}")
