"""What one engine made of a scenario."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from contact_toolkit import CollisionMesh
from scenarios.compare.placements import body_names, placements
from scenarios.format.models import surface_of
from scenarios.format.scenario import Scenario
from scenarios.judge.acceptance import Check, judge
from scenarios.judge.expressions import columns_in, evaluate
from scenarios.judge.heap import Heap
from scenarios.judge.measures import moved, rest
from scenarios.simulation.columns import motion_units
from scenarios.simulation.record import Record

Floats = NDArray[np.float64]


@dataclass
class Outcome:
    """A run of one engine: poses X_WB (n, 4, 4) by body, the record, its figures and verdict.

    `penetration` is how deep parts are in each other at the end [m].
    """

    engine: str
    record: Record | None = None
    poses: Mapping[str, Floats] = field(default_factory=dict)
    wall_time: float = 0.0
    penetration: float = float("nan")
    figures: dict[str, float] = field(default_factory=dict)
    checks: list[Check] = field(default_factory=list)
    verdict: str = ""
    error: str = ""

    @property
    def real_time_factor(self) -> float:
        """Simulated over wall-clock time."""
        if self.record is None or not self.wall_time:
            return float("nan")
        return float(self.record["time"][-1] / self.wall_time)

    def creep(self, window: float) -> float:
        """Largest mean speed of any body in the last part of the run [µm/s]."""
        if self.record is None:
            return float("nan")
        last = self.record.last(window)
        spans = [
            np.linalg.norm(X[last][-1, :3, 3] - X[last][0, :3, 3]) for X in self.poses.values()
        ]
        return float(1e6 * max(spans, default=0.0) / window)

    def energy_gained(self) -> float:
        """Largest kinetic and gravitational energy above that at the start [J]."""
        if self.record is None:
            return float("nan")
        total = self.record["kinetic_energy"] + self.record["gravitational_energy"]
        return float((total - total[0]).max())

    def judge(self, scenario: Scenario) -> None:
        """Hold those figures of the scenario that every engine has against its limits."""
        assert self.record is not None
        acceptance = scenario.acceptance
        at_end, moving = self._at_end(scenario)
        match acceptance.measure:
            case "heap":
                self.figures |= at_end.figures(moving, self.record, acceptance.window)
            case "bodies":
                self.figures |= moved(self.record, acceptance.window)
            case "stack":
                self.figures |= rest(self.record, acceptance.body, acceptance.window)
        self.penetration = at_end.deepest_overlap
        for name, expression in acceptance.figures.items():
            if all(column in self.record.columns for column in columns_in(expression)):
                self.figures[name] = evaluate(expression, self.record, acceptance.window)
        limits = {name: limit for name, limit in acceptance.limits.items() if name in self.figures}
        shared = type(acceptance)(limits=limits)
        self.verdict, self.checks = judge(shared, self.figures)

    def _at_end(self, scenario: Scenario) -> tuple[Heap, list[str]]:
        """Return the scenario's parts at their last poses, and the names of those that moved."""
        placed = placements(scenario)
        surfaces = {part: surface_of(scenario.parts[part]) for part in scenario.parts}
        meshes = {part: CollisionMesh(*surface) for part, surface in surfaces.items()}
        names = body_names(placed)
        return Heap(
            [meshes[placement.part] for placement in placed.values()],
            [
                self.poses[names[model]][-1] if names[model] in self.poses else placement.X_WB
                for model, placement in placed.items()
            ],
            np.array([name in self.poses for name in names.values()], dtype=bool),
        ), [name for name in names.values() if name in self.poses]


def record_of(
    time: Floats,
    poses: Mapping[str, Floats],
    velocities: Mapping[str, Floats],
    masses: Mapping[str, float],
    kinetic: Floats,
    gravity: Floats,
) -> Record:
    """Return the columns that every engine has: motion (V_WB (n, 6), angular first), energies."""
    potential = sum(
        (-masses[name] * X[:, :3, 3] @ gravity for name, X in poses.items()), np.zeros(len(time))
    )
    columns = {"time": time, "kinetic_energy": kinetic, "gravitational_energy": potential}
    units = {"time": "s", "kinetic_energy": "J", "gravitational_energy": "J"}
    for name, X in poses.items():
        R = X[:, :3, :3]
        tilt = np.arctan2(np.hypot(R[:, 0, 2], R[:, 1, 2]), R[:, 2, 2])
        yaw = np.unwrap(np.arctan2(R[:, 1, 0], R[:, 0, 0]))
        motion = [*X[:, :3, 3].T, tilt, yaw, *velocities[name].T]
        for (quantity, unit), column in zip(motion_units().items(), motion, strict=True):
            columns[f"{name}.{quantity}"], units[f"{name}.{quantity}"] = column, unit
    return Record(columns, units)
