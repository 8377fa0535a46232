"""From a study to its runs: which values, seeds and settings each has, and what it is known by."""

from __future__ import annotations

import dataclasses
import hashlib
import itertools
import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.common.yaml import yaml_dump_typed, yaml_load
from scipy.stats import qmc

from scenarios.format.errors import ScenarioError
from scenarios.format.loading import RawScenario
from scenarios.format.scenario import Scenario
from scenarios.format.typed import typed
from scenarios.judge.acceptance import check_acceptance, figure_names
from scenarios.report.provenance import decisive_versions
from scenarios.sweep.study import Study, Value

COLUMNS = {
    "key": str,
    "run": int,
    "seed": int,
    "verdict": str,
    "reason": str,
    "simulated_time": float,
    "wall_time": float,
    "steps": int,
    "versions": str,
}
"""Columns of the rows of every sweep; the inputs and the figures come after them."""


@dataclass(frozen=True)
class PlannedRun:
    """One run: `overrides` hold all that distinguishes it; equal keys mean equal numbers."""

    number: int
    inputs: dict[str, Value]
    seed: int
    overrides: tuple[str, ...]
    key: str


@dataclass(frozen=True)
class Plan:
    """A study with its scenario. Raises ScenarioError, in `check`, if that cannot be run."""

    name: str
    study: Study
    base: RawScenario

    @cached_property
    def scenario(self) -> Scenario:
        """The scenario with what all runs change in it."""
        return self.base.load(self.study.settings)

    @property
    def figures(self) -> tuple[str, ...]:
        """Names of the figures that each run is measured by."""
        return figure_names(self.scenario.acceptance)

    @property
    def score(self) -> str:
        """The figure by which runs are ranked, "" if there is none."""
        limits, figures = self.scenario.acceptance.limits, self.figures
        return self.study.score or next(iter([*limits, *figures]), "")

    @cached_property
    def identity(self) -> dict[str, Any]:
        """What makes two sweeps the same, so that one may go on with the other's rows."""
        study = yaml_load(data=yaml_dump_typed(self.study, schema=Study))
        kept = ("scenario", "settings", "parameters", "sampling", "random_seed")
        said = {key: study.get(key) for key in kept}
        if self.study.sampling == "latin_hypercube":  # whose first points depend on how many
            said["runs"] = self.study.runs
        return said | {"contents": self.base.digest(), "versions": decisive_versions()}

    def check(self) -> None:
        """Raise ScenarioError for a scenario, settings or figures that cannot be."""
        check_acceptance(self.scenario.acceptance)
        if self.score not in ("", *self.figures):
            raise ScenarioError(
                f"{self.name}: score: no figure is called '{self.score}'; there are: "
                f"{', '.join(self.figures)}"
            )
        for name, parameter in self.study.parameters.items():
            if name in self.figures:
                raise ScenarioError(f"{self.name}: '{name}' is both a parameter and a figure")
            if name in COLUMNS:
                raise ScenarioError(
                    f"{self.name}: '{name}' is a column of every sweep; rename the parameter"
                )
            for share in (0.0, 0.5):  # of choices at least the first
                value = parameter.value_at(share)
                self.base.load([*self.study.settings, *parameter.settings(value)])

    def runs(self) -> list[PlannedRun]:
        """Return all runs in their order."""
        parameters = self.study.parameters
        contents, versions = self.identity["contents"], self.identity["versions"]
        planned = []
        for number, shares in enumerate(unit_points(self.study)):
            inputs = {
                name: parameter.value_at(share)
                for (name, parameter), share in zip(parameters.items(), shares, strict=True)
            }
            seed = int(
                np.random.SeedSequence([self.study.random_seed, number]).generate_state(1)[0]
            )
            varied = [s for name, value in inputs.items() for s in parameters[name].settings(value)]
            overrides = (*self.study.settings, *varied, f"random_seed={seed}")
            said = json.dumps([contents, versions, overrides], sort_keys=True)
            key = hashlib.blake2b(said.encode(), digest_size=16).hexdigest()
            planned.append(PlannedRun(number, inputs, seed, overrides, key))
        return planned

    def run_of(self, number: int) -> PlannedRun:
        """Return one run by its number, also where the study's own count ends before it."""
        study = self.study
        if number >= study.runs:
            study = dataclasses.replace(study, runs=number + 1)
        return Plan(self.name, study, self.base).runs()[number]

    def describe(self) -> dict[str, Any]:
        """Return all that is needed to make the plan again elsewhere, for JSON."""
        study = yaml_load(data=yaml_dump_typed(self.study, schema=Study))
        base = asdict(self.base) | {"path": str(self.base.path)}
        return {"name": self.name, "study": study, "base": base, "identity": self.identity}

    @classmethod
    def again(cls, described: Mapping[str, Any]) -> Plan:
        """Return the plan that was described so; KeyError or TypeError if it was none."""
        base = described["base"]
        study = typed(Study, described["study"], described["name"])
        scenario = RawScenario(base["name"], base["raw"], Path(base["path"]))
        return cls(described["name"], study, scenario)


def unit_points(study: Study) -> NDArray[np.float64]:
    """Return a point of the unit cube for each run, (runs, parameters).

    Of "sobol" and "random" more runs begin with the points of fewer.
    """
    runs, size, seed = study.runs, len(study.parameters), study.random_seed
    match study.sampling:
        case "sobol":
            # Drawn by powers of two: SciPy warns of other counts, whose balance is not perfect.
            return qmc.Sobol(size, rng=seed).random_base2(max(0, math.ceil(math.log2(runs))))[:runs]
        case "latin_hypercube":
            return qmc.LatinHypercube(size, rng=seed).random(runs)
        case "random":
            return np.random.default_rng(seed).random((runs, size))
    return np.array(list(itertools.product(*(p.grid() for p in study.parameters.values()))))
