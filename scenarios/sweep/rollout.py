"""One run of a scenario without a folder: inputs in, figures out, whatever happens."""

from __future__ import annotations

import itertools
import math
import shutil
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context

from contact_toolkit import MeshError
from scenarios.format.errors import ScenarioError
from scenarios.format.loading import RawScenario, find
from scenarios.format.scenario import Scenario
from scenarios.judge.acceptance import columns_read
from scenarios.judge.verdicts import ERROR, INTERRUPTED, TIMED_OUT
from scenarios.report.summary import Summary
from scenarios.runner import advance, judge_run, kept_warnings
from scenarios.simulation.assembly import Assembly, assemble
from scenarios.simulation.record import collect
from scenarios.sweep.outcome import Outcome

_LOOK = 16  # steps between two looks at the state
_DIVERGED = 1e9  # [m, rad, m/s …] beyond this no state of a scenario means anything
_mine = threading.local()


def rollout(
    scenario: str | RawScenario,
    inputs: Mapping[str, Any] | None = None,
    *,
    seed: int | None = None,
    time_out: float = math.inf,
    record: bool = False,
) -> Outcome:
    """Run a scenario with some of its values changed, and measure it by its acceptance.

    What goes wrong within the run, from parts that cannot be made to a state that diverges, is the
    outcome's reason. Meshes equal to those of the last run in this process are used again.

    Parameters
    ----------
    scenario
        A name of the library, a file, or what `find` returns.
    inputs
        Keys of the scenario to values, as `{"contact.alpha": 0.3}`.
    seed
        Of the initial state, in place of the scenario's.
    time_out
        Longest wall-clock time [s], looked at between steps.
    record
        Whether to return the time series.

    Raises
    ------
    ScenarioError
        For a scenario that does not exist, and for inputs that its file could not hold.
    """
    found = find(scenario) if isinstance(scenario, str) else scenario
    values = dict(inputs or {}) | ({} if seed is None else {"random_seed": seed})
    loaded = found.load([f"{key}={value}" for key, value in values.items()])
    return run_once(found.name, loaded, time_out=time_out, record=record)


def run_once(
    name: str, scenario: Scenario, *, time_out: float = math.inf, record: bool = False
) -> Outcome:
    """Run a loaded scenario; see `rollout`."""
    started = time.perf_counter()
    summary = Summary(name)
    recorded = None
    try:
        with _models_folder() as folder, kept_warnings([]):
            columns = None if record else columns_read(scenario.acceptance)
            assembly = assemble(scenario, folder, columns=columns)
            simulator = assembly.simulator(scenario)
        _keep(assembly)
        with kept_warnings([]):
            advance(
                simulator,
                scenario.simulation_duration,
                summary,
                lambda _: None,
                also=_limits(assembly, started + time_out, time_out),
            )
            _require_sane(assembly, simulator.get_context())
            recorded = collect(assembly, simulator.get_context())
            judge_run(summary, scenario, recorded, assembly, simulator)
    except TimeoutError as error:
        summary.verdict, summary.error = TIMED_OUT, str(error)
    except (ScenarioError, MeshError) as error:
        summary.verdict, summary.error = ERROR, str(error)
    except Exception as error:  # noqa: BLE001  of the simulation: its contact, or Drake
        summary.verdict, summary.error = ERROR, f"{type(error).__name__}: {error}"
    if summary.verdict == INTERRUPTED:
        raise KeyboardInterrupt
    return Outcome(
        summary.verdict,
        summary.error,
        {figure: float(value) for figure, value in summary.figures.items()},
        summary.simulated_time,
        time.perf_counter() - started,
        summary.steps,
        recorded if record else None,
    )


@contextmanager
def _models_folder() -> Iterator[Path]:
    """Give a folder, of the same name for all runs of a thread: equal meshes have equal paths."""
    folder: Path | None = getattr(_mine, "folder", None)
    if folder is None:
        folder = _mine.folder = Path(tempfile.mkdtemp(prefix="rollout-"))
    else:
        folder.mkdir(mode=0o700)
    try:
        yield folder
    finally:
        shutil.rmtree(folder)


def _limits(
    assembly: Assembly, deadline: float, time_out: float
) -> Callable[[Simulator, Context], None]:
    """Return what ends a run between two steps: too late, or out of this world."""
    steps = itertools.count(1)

    def check(_: Simulator, context: Context) -> None:
        if time.perf_counter() > deadline:
            raise TimeoutError(f"not done after {time_out:g} s of wall-clock time")
        if next(steps) % _LOOK == 0:
            _require_sane(assembly, context)

    return check


def _require_sane(assembly: Assembly, context: Context) -> None:
    plant = assembly.plant
    state = plant.GetPositionsAndVelocities(plant.GetMyContextFromRoot(context))
    if not np.abs(state).max(initial=0.0) < _DIVERGED:  # NaN is not
        raise ArithmeticError(f"diverged at {context.get_time():.4g} s")


def _keep(assembly: Assembly) -> None:
    """Keep a run's contact until the thread's next: equal meshes, hierarchies and fields stay.

    pydrake never frees a Python system that was in a diagram, so the one before is emptied.
    """
    last: Assembly | None = getattr(_mine, "last", None)
    _mine.last = assembly
    if last is not None:
        last.contact.__dict__.clear()
