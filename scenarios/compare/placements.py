"""Where a scenario's directives put its parts, for engines that do not read them."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from pathlib import PurePosixPath

import numpy as np
from numpy.typing import NDArray

from scenarios.format.models import PACKAGE
from scenarios.format.scenario import Scenario

Floats = NDArray[np.float64]

_PARTS = f"package://{PACKAGE}/"


@dataclass
class Placement:
    """A body: its part, its pose X_WB (4, 4), and whether it is welded to the world."""

    part: str
    X_WB: Floats = field(default_factory=lambda: np.eye(4))
    fixed: bool = False


def placements(scenario: Scenario) -> dict[str, Placement]:
    """Return the bodies that are parts of the scenario, by the names of their models."""
    placed: dict[str, Placement] = {}
    for directive in scenario.directives:
        model, weld = directive.add_model, directive.add_weld
        if model is not None and model.file.startswith(_PARTS):
            placed[model.name] = Placement(PurePosixPath(model.file).stem)
            for X in (model.default_free_body_pose or {}).values():
                placed[model.name].X_WB = X.GetDeterministicValue().GetAsMatrix4()
        elif weld is not None and (child := placed.get(weld.child.partition("::")[0])):
            child.fixed = True
            if weld.X_PC is not None:
                child.X_WB = weld.X_PC.GetDeterministicValue().GetAsMatrix4()
    return placed


def body_names(placed: dict[str, Placement]) -> dict[str, str]:
    """Return what the record calls the body of each model: its part, if there is only one of it."""
    count = Counter(placement.part for placement in placed.values())
    return {
        model: placement.part if count[placement.part] == 1 else f"{model}::{placement.part}"
        for model, placement in placed.items()
    }
