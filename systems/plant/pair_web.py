"""Choose the spring web of a pair from flat settings, whose keys belong to one web or the other."""

from __future__ import annotations

import math
from typing import Literal

from contact_toolkit import AreaWeb, FacetWeb, PointWeb
from contact_toolkit.contact.spring_webs import SpringWeb
from systems.contact_config import ContactLawConfig

# Keys that only one web has; the other webs' pairs do without them.
_KEYS_OF = {"area": ("field", "resolution", "fillet"), "facet": ("weighting",)}


def web_name(law: ContactLawConfig) -> Literal["area", "facet"]:
    """Return the name of the web that the settings ask for; raise ValueError for unknown names."""
    match law.web:
        case None | "area":
            return "area"
        case "facet":
            return "facet"
        case other:
            raise ValueError(f"web must be 'area' or 'facet', not {other!r}")


def require_keys_of_web(given: ContactLawConfig, web: str) -> None:
    """Raise ValueError where settings give a key that the web they are for does not have."""
    for owner, keys in _KEYS_OF.items():
        strange = [key for key in keys if owner != web and getattr(given, key) is not None]
        if strange:
            raise ValueError(
                f"{', '.join(strange)}: of the {owner} web, and the web here is {web!r}; leave it "
                f"out, or set web: {owner}"
            )


def make_web(law: ContactLawConfig, load: float, *, point: bool) -> SpringWeb:
    """Return the web with what the settings say of it; raise ValueError for what makes no sense.

    `load` [N]: the weight of the lighter body with all that its joints hold, which the contact
    usually bears; infinite where unknown.
    `point`: one geometry stands for a point, which takes the place of an area.
    """
    name = web_name(law)
    if point:
        return PointWeb(law.standoff or 0.0)
    settings = {key: getattr(law, key) for key in ("standoff", *_KEYS_OF[name])}
    given = {key: value for key, value in settings.items() if value is not None}
    if name == "area":
        return AreaWeb(**given, nominal_force=load if load < math.inf else None)
    if law.standoff is None:
        raise ValueError(
            "the facet web needs a distance [m] > 0 at which contact begins: set standoff"
        )
    return FacetWeb(**given)
