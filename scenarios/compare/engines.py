"""The engines that there are to compare."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Mapping

from scenarios.compare.drake_engines import builtin, ours
from scenarios.compare.outcome import Outcome
from scenarios.format.scenario import Scenario


def engines() -> Mapping[str, Callable[[Scenario], Outcome]]:
    """Return the engines that are installed here, by name."""
    found: dict[str, Callable[[Scenario], Outcome]] = {
        "ours, implicit": lambda scenario: ours(scenario, implicit=True),
        "ours, continuous": lambda scenario: ours(scenario, implicit=False),
        "Drake point": lambda scenario: builtin(scenario, hydroelastic=False),
        "Drake hydroelastic": lambda scenario: builtin(scenario, hydroelastic=True),
    }
    if importlib.util.find_spec("mujoco") is not None:
        from scenarios.compare.mujoco_engine import mujoco_engine

        found["MuJoCo"] = mujoco_engine
    return found


def absent_engines() -> list[str]:
    """Return what would bring further engines, a line each."""
    if "MuJoCo" in engines():
        return []
    return ["MuJoCo is not installed: pip install 'contact-toolkit[compare]'"]
