"""Which words a scenario's settings may take."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from types import MappingProxyType

from contact_toolkit import MATERIALS

_LAW: dict[str, tuple[str, ...]] = {
    "web": ("area", "facet"),
    "weighting": ("multiplicity", "unit"),
    "field": ("smooth", "exact"),
}

CHOICES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        **{f"contact.{key}": words for key, words in _LAW.items()},
        **{f"contact.overrides.*.{key}": words for key, words in _LAW.items()},
        "contact.materials.*": tuple(MATERIALS),
        "contact.when_deep": ("warn", "raise"),
        "contact.when_chattering": ("raise", "warn"),
        "contact.discrete": ("implicit", "explicit"),
        "joints.*.kind": ("prismatic", "revolute"),
        "drives.*.follows": ("force", "position"),
        "swept_monitor": ("off", "count", "warn", "raise"),
        "plant_config.contact_model": ("point", "hydroelastic", "hydroelastic_with_fallback"),
        "plant_config.discrete_contact_approximation": ("tamsi", "sap", "similar", "lagged"),
        "simulator_config.integration_scheme": (
            "runge_kutta3", "radau3", "radau1", "implicit_euler", "semi_explicit_euler",
            "explicit_euler", "runge_kutta2", "runge_kutta5", "velocity_implicit_euler",
            "bogacki_shampine3", "cenic",
        ),
    }
)  # fmt: skip
"""Allowed words by place; `*` stands for any name or list index."""


@lru_cache(maxsize=1024)
def choices_at(place: str) -> tuple[str, ...]:
    """Return the words allowed at a place such as `joints.lift.kind`, none if any will do."""
    steps = place.split(".")
    for pattern, words in CHOICES.items():
        wanted = pattern.split(".")
        if len(wanted) == len(steps) and all(
            w in ("*", s) for w, s in zip(wanted, steps, strict=True)
        ):
            return words
    return ()
