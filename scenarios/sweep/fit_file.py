"""The file that says what is to be fitted to which measurements; the fit over rollouts."""

# No `from __future__ import annotations`: the loader reads the annotations as types.
import csv
import dataclasses
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from scenarios.format.errors import ScenarioError
from scenarios.format.loading import RawScenario
from scenarios.format.typed import read_mapping, typed
from scenarios.judge.verdicts import ERROR, TIMED_OUT
from scenarios.sweep.fit import Fit, FreeParameter, fit
from scenarios.sweep.rollout import run_once
from scenarios.sweep.study import find_beside

Floats = NDArray[np.float64]


@dataclasses.dataclass
class Measured:
    """One measured series.

    Attributes
    ----------
    file
        CSV with a header, relative to the file of the fit.
    time
        Its column of times [s], as the scenario counts them.
    columns
        Column of the scenario's time series to column of the CSV, both in SI units.
    noise
        What each sample is thought to be off by; only matters where several series are fitted.
    """

    file: str = ""
    time: str = "time"
    columns: dict[str, str] = dataclasses.field(default_factory=dict)
    noise: float = 1.0


@dataclasses.dataclass
class FitFile:
    """Parameters of a scenario to be found from measurements.

    Attributes
    ----------
    description
        One line.
    scenario
        Of the library, or a file relative to this one.
    settings
        What is changed in it beforehand, each `key=value`.
    parameters
        What is to be found, by name.
    series
        What was measured.
    time_out
        Longest wall-clock time of a rollout [s].
    """

    description: str = ""
    scenario: str = ""
    settings: list[str] = dataclasses.field(default_factory=list)
    parameters: dict[str, FreeParameter] = dataclasses.field(default_factory=dict)
    series: list[Measured] = dataclasses.field(default_factory=list)
    time_out: float = 120.0


@dataclasses.dataclass(frozen=True)
class Samples:
    """A column of a series: when, what, and how sure; `column` is the record's."""

    column: str
    time: Floats
    values: Floats
    noise: float


def load_fit(path: Path) -> tuple[str, FitFile, RawScenario, list[Samples]]:
    """Return name and contents of a fit's file, its scenario and measurements.

    Raises ScenarioError naming the file and the key, or the file of measurements and its line.
    """
    if not path.is_file():
        raise ScenarioError(f"{path}: no such file")
    ((name, raw), *more) = read_mapping(path, "fits").items()
    if more or not isinstance(raw, dict):
        raise ScenarioError(f"{path}: expected one name and the keys of a fit")
    where = f"{path}: {name}"
    wanted = typed(FitFile, raw, where)
    for key in ("scenario", "parameters", "series"):
        if not getattr(wanted, key):
            raise ScenarioError(f"{where}: {key} is missing")
    for key, parameter in wanted.parameters.items():
        parameter.check(f"{where}: parameters.{key}")
        if not parameter.sets:
            raise ScenarioError(f"{where}: parameters.{key}.sets is empty: name the keys it sets")
    samples = [s for series in wanted.series for s in _read(path.parent / series.file, series)]
    return name, wanted, find_beside(wanted.scenario, path), samples


def fit_rollouts(
    wanted: FitFile,
    base: RawScenario,
    samples: list[Samples],
    progress: Callable[[Mapping[str, float], float], None] = lambda *_: None,
) -> Fit:
    """Fit the parameters over rollouts; `progress` gets those tried, and the rms deviation."""
    measured = np.concatenate([s.values for s in samples])
    noise = np.concatenate([np.full(len(s.values), s.noise) for s in samples])

    def model(values: Mapping[str, float]) -> Floats:
        series = np.concatenate(simulate(wanted, base, samples, values))
        progress(values, float(np.sqrt(np.mean((series - measured) ** 2))))
        return series

    return fit(model, measured, wanted.parameters, noise=noise)


def simulate(
    wanted: FitFile, base: RawScenario, samples: list[Samples], values: Mapping[str, float]
) -> list[Floats]:
    """Return what a rollout with these values gives for each of the measured columns."""
    varied = [f"{key}={v!r}" for name, v in values.items() for key in wanted.parameters[name].sets]
    scenario = base.load([*wanted.settings, *varied])
    outcome = run_once(base.name, scenario, time_out=wanted.time_out, record=True)
    record = outcome.record
    if record is None or outcome.verdict in {ERROR, TIMED_OUT}:
        raise ScenarioError(f"{base.name} with {', '.join(varied)}: {outcome.reason}")
    for s in samples:
        if s.column not in record.columns:
            raise ScenarioError(
                f"series: {base.name} records no '{s.column}'; there are: "
                f"{', '.join(record.columns)}"
            )
        if s.time[0] < record["time"][0] or s.time[-1] > record["time"][-1] + 1e-9:
            raise ScenarioError(
                f"series: measured from {s.time[0]:g} to {s.time[-1]:g} s, but {base.name} is "
                f"simulated to {record['time'][-1]:g} s; set simulation_duration"
            )
    return [np.interp(s.time, record["time"], record[s.column]) for s in samples]


def _read(path: Path, series: Measured) -> list[Samples]:
    try:
        with path.open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
    except (UnicodeDecodeError, csv.Error) as error:
        raise ScenarioError(f"{path}: not readable as CSV: {error}") from error
    wanted = [series.time, *series.columns.values()]
    if not rows or not series.columns:
        raise ScenarioError(f"{path}: no rows under the header, or no columns asked for")
    for name in wanted:
        if name not in rows[0]:
            raise ScenarioError(f"{path}: no column '{name}'; there are: {', '.join(rows[0])}")
    numbers = np.array([[_number(path, line, r[c]) for c in wanted] for line, r in enumerate(rows)])
    if not (np.diff(numbers[:, 0]) > 0.0).all():
        raise ScenarioError(f"{path}: times must increase")
    return [
        Samples(column, numbers[:, 0], numbers[:, index], series.noise)
        for index, column in enumerate(series.columns, start=1)
    ]


def _number(path: Path, line: int, text: str) -> float:
    try:
        number = float(text)
    except (TypeError, ValueError):
        number = float("nan")
    if not np.isfinite(number):
        raise ScenarioError(f"{path}:{line + 2}: {text!r} is not a finite number")
    return number
