"""The study file: a scenario, what varies in it, and how many runs look at it."""

# No `from __future__ import annotations`: the loader reads the annotations as types.
import dataclasses
import math
from pathlib import Path
from typing import TypeAlias, Union

import numpy as np
from numpy.typing import NDArray
from pydrake.common.schema import Gaussian, Uniform, UniformDiscrete
from scipy.stats import norm

from scenarios.format.errors import ScenarioError
from scenarios.format.loading import RawScenario, find
from scenarios.format.typed import read_mapping, typed

SAMPLINGS = ("sobol", "latin_hypercube", "random", "grid")
STUDIES = Path(__file__).parents[1] / "studies"

Value: TypeAlias = float | str


@dataclasses.dataclass
class Parameter:
    """What varies: a number by a distribution, or a choice between named settings.

    Attributes
    ----------
    sets
        Keys of the scenario that take the number, as `contact.alpha`; those of lists by index.
    distribution
        Drake's `!Uniform {min, max}`, `!Gaussian {mean, stddev}` or `!UniformDiscrete {values}`.
    choices
        Instead: name to settings of the scenario, each `key=value` as `--set` takes them; all
        equally likely.
    points
        How many values a grid takes of a distribution that is not discrete.
    """

    sets: list[str] = dataclasses.field(default_factory=list)
    distribution: Union[Uniform, Gaussian, UniformDiscrete, None] = None  # noqa: UP007  Drake's loader
    choices: dict[str, list[str]] = dataclasses.field(default_factory=dict)
    points: int = 0

    def grid(self) -> NDArray[np.float64]:
        """Return the shares in [0, 1] whose values a grid takes; none if nobody said how many."""
        if isinstance(self.distribution, Uniform) and self.points > 1:
            return np.linspace(0.0, 1.0, self.points)  # its ends belong to it
        count = len(self.choices) or self.points
        if isinstance(self.distribution, UniformDiscrete):
            count = len(self.distribution.values)
        return (np.arange(count) + 0.5) / count if count > 0 else np.empty(0)

    def value_at(self, share: float) -> Value:
        """Return the value that a share in [0, 1) of all values lies below."""
        match self.distribution:
            case Uniform(min=low, max=high):
                return float(low + share * (high - low))
            case Gaussian(mean=mean, stddev=deviation):
                return float(mean + deviation * norm.ppf(np.clip(share, 1e-12, 1 - 1e-12)))
            case UniformDiscrete(values=values):
                return float(values[int(share * len(values))])
        return list(self.choices)[int(share * len(self.choices))]

    def settings(self, value: Value) -> list[str]:
        """Return what a value sets in the scenario, as `--set` takes it."""
        if isinstance(value, str):
            return self.choices[value]
        return [f"{key}={value!r}" for key in self.sets]

    def check(self, where: str) -> None:
        """Raise ScenarioError for what cannot be sampled."""
        if (self.distribution is None) == (not self.choices):
            raise ScenarioError(f"{where} needs either a distribution or choices")
        if self.choices and self.sets:
            raise ScenarioError(f"{where}.sets goes with a distribution; choices say what they set")
        if self.distribution is not None and not self.sets:
            raise ScenarioError(f"{where}.sets is empty: name the keys that take the value")
        match self.distribution:
            case Uniform(min=low, max=high):
                sound = math.isfinite(high - low) and low <= high
            case Gaussian(mean=mean, stddev=deviation):
                sound = math.isfinite(mean + deviation) and deviation >= 0.0
            case UniformDiscrete(values=values):
                sound = len(values) > 0 and all(map(math.isfinite, values))
            case _:
                sound = all(isinstance(settings, list) for settings in self.choices.values())
        if not sound:
            raise ScenarioError(
                f"{where}: no numbers can be drawn from this; mind bounds and order"
            )


@dataclasses.dataclass
class Study:
    """Many runs of one scenario.

    Attributes
    ----------
    description
        One line.
    scenario
        Of the library, or a file (`FILE` or `FILE:NAME`) relative to the study's.
    settings
        What all runs change in it, each `key=value` as `--set` takes them.
    parameters
        What varies, by name; the unit in brackets belongs to the name: `force [N]`.
    sampling
        How values are chosen: "sobol" and "latin_hypercube" (evenly spread), "random", or "grid"
        (all combinations).
    runs
        How many; a grid has as many as it has points.
    random_seed
        Of the sampling, and of the runs' own seeds.
    time_out
        Longest wall-clock time of a run [s].
    memory_limit
        Largest memory of the process of a run [GB].
    score
        The figure by which runs are ranked; the first of the scenario's limits unless given.
    maps
        Pairs of parameters over which the report maps success; unless given, the first three
        numbers, in pairs.
    """

    description: str = ""
    scenario: str = ""
    settings: list[str] = dataclasses.field(default_factory=list)
    parameters: dict[str, Parameter] = dataclasses.field(default_factory=dict)
    sampling: str = "sobol"
    runs: int = 100
    random_seed: int = 0
    time_out: float = 60.0
    memory_limit: float = 2.0
    score: str = ""
    maps: list[list[str]] = dataclasses.field(default_factory=list)

    def check(self, where: str) -> None:
        """Raise ScenarioError naming the key for values no sweep can have."""
        if not self.scenario:
            raise ScenarioError(f"{where}: scenario is missing: what is to be run?")
        if not self.parameters:
            raise ScenarioError(f"{where}: parameters are empty: nothing varies")
        for name, parameter in self.parameters.items():
            parameter.check(f"{where}: parameters.{name}")
            if self.sampling == "grid" and not len(parameter.grid()):
                raise ScenarioError(f"{where}: parameters.{name}.points: how many, on the grid?")
        if self.sampling not in SAMPLINGS:
            raise ScenarioError(
                f"{where}: sampling must be one of {', '.join(SAMPLINGS)}, not '{self.sampling}'"
            )
        for key in ("runs", "time_out", "memory_limit"):
            value = getattr(self, key)
            if not (math.isfinite(value) and value > 0):
                raise ScenarioError(f"{where}: {key} must be positive, not {value}")
        if not 0 <= self.random_seed < 2**32:
            raise ScenarioError(f"{where}: random_seed must be from 0 to 2³² − 1")
        self._check_maps(where)

    def _check_maps(self, where: str) -> None:
        for pair in self.maps:
            if len(pair) != 2 or any(name not in self.parameters for name in pair):
                raise ScenarioError(
                    f"{where}: maps: {pair} are not two of {', '.join(self.parameters)}"
                )


def load_study(name_or_file: str) -> tuple[str, Study, RawScenario]:
    """Return name and contents of a study, of those that come with us or of a file; its scenario.

    Raises ScenarioError naming the file and the key.
    """
    path = STUDIES / f"{name_or_file}.yaml"
    if not path.is_file():
        path = Path(name_or_file)
    if not path.is_file():
        known = ", ".join(sorted(file.stem for file in STUDIES.glob("*_study.yaml")))
        raise ScenarioError(f"{name_or_file}: no such file, and no study of ours: {known}")
    ((name, raw), *more) = read_mapping(path, "studies").items()
    if more or not isinstance(raw, dict):
        raise ScenarioError(f"{path}: expected one name and the keys of a study")
    where = f"{path}: {name}"
    study = typed(Study, raw, where)
    study.check(where)
    return name, study, find_beside(study.scenario, path)


def find_beside(name_or_file: str, path: Path) -> RawScenario:
    """Return a scenario of the library, or of a file relative to the folder of `path`."""
    file, colon, name = name_or_file.partition(":")
    beside = path.parent / file
    return find(f"{beside}{colon}{name}" if beside.is_file() else name_or_file)
