"""Run a scenario into a folder: time series, figures, playback, summary, verdict.

The folder holds `scenario.yaml` (resolved, runnable), `summary.json`, `series.parquet`,
`playback.html` (self-contained), `figures/*.png` and `parts/` (the generated models). It is
readable whatever ends the run; `summary.json` says what did.
"""

from __future__ import annotations

import logging
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from pydrake.geometry import Meshcat, MeshcatParams
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, EventStatus

from scenarios.acceptance import CRASHED, INTERRUPTED, judge
from scenarios.assembly import Assembly, assemble
from scenarios.errors import ScenarioError
from scenarios.figures import draw_series
from scenarios.loading import dump
from scenarios.measures import MEASURES, Run
from scenarios.record import Record, collect
from scenarios.scenario import Scenario
from scenarios.summary import Summary, versions
from scenarios.web_figure import draw_web

Progress = Callable[[float], None]
"""Called with the simulated time [s] as the run advances."""

REPORT_PERIOD = 0.1  # [s] of wall time between two calls


def run(
    name: str,
    scenario: Scenario,
    folder: Path,
    *,
    progress: Progress = lambda _: None,
    meshcat: Meshcat | None = None,
) -> Summary:
    """Run a scenario into `folder` and return its summary.

    Ctrl-C ends the run early, with what there is until then in the folder. Raises ScenarioError
    for a scenario that cannot be run; what the simulation itself raises is passed on after the
    folder has been written.
    """
    check_measure(scenario)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "scenario.yaml").write_text(dump(name, scenario), encoding="utf-8")
    meshcat = meshcat or _unwatched_meshcat()
    assembly = assemble(scenario, folder / "parts", meshcat)
    simulator = assembly.simulator(scenario)
    summary = Summary(name, random_seed=scenario.random_seed, versions=versions())
    meshcat.StartRecording(scenario.visualization.frame_rate)
    try:
        advance(simulator, scenario.simulation_duration, summary, progress)
    except Exception as error:
        summary.verdict, summary.error = CRASHED, f"{type(error).__name__}: {error}"
        raise
    finally:
        meshcat.StopRecording()
        meshcat.PublishRecording()
        (folder / "playback.html").write_text(meshcat.StaticHtml(), encoding="utf-8")
        record = collect(assembly, simulator.get_context())
        record.save(folder / "series.parquet")
        summary.save(folder)
    draw_series(record, folder / "figures")
    draw_web(record, assembly, simulator.get_context(), folder / "figures")
    if summary.verdict != INTERRUPTED and scenario.acceptance.measure:
        _judge(summary, scenario, record, assembly, simulator)
        summary.save(folder)
    return summary


def check_measure(scenario: Scenario) -> None:
    """Raise ScenarioError if the acceptance names a measure that does not exist."""
    measure = scenario.acceptance.measure
    if measure and measure not in MEASURES:
        raise ScenarioError(
            f"acceptance.measure: none is called '{measure}'; there are: {', '.join(MEASURES)}"
        )


def advance(simulator: Simulator, duration: float, summary: Summary, progress: Progress) -> None:
    """Advance by `duration` [s], or until Ctrl-C; note times and counts in the summary."""
    start_time = simulator.get_context().get_time()
    with _interruption() as interrupted:
        next_report = 0.0

        def monitor(context: Context) -> EventStatus | None:
            nonlocal next_report
            if interrupted.is_set():
                return EventStatus.ReachedTermination(simulator.get_system(), "interrupted")
            if time.monotonic() >= next_report:
                next_report = time.monotonic() + REPORT_PERIOD
                progress(context.get_time() - start_time)
            return None

        simulator.set_monitor(monitor)
        started = time.perf_counter()
        try:
            simulator.Initialize()
            simulator.AdvanceTo(start_time + duration)
        finally:
            simulator.clear_monitor()
            summary.wall_time = time.perf_counter() - started
            summary.simulated_time = simulator.get_context().get_time() - start_time
            summary.real_time_factor = summary.simulated_time / summary.wall_time
            integrator = simulator.get_integrator()
            summary.force_evaluations = integrator.get_num_derivative_evaluations()
            summary.steps = simulator.get_num_steps_taken()
        progress(summary.simulated_time)
    if interrupted.is_set():
        summary.verdict = INTERRUPTED


@contextmanager
def _interruption() -> Iterator[threading.Event]:
    """Turn Ctrl-C into an event, which the simulation looks at between steps.

    An exception raised in the middle of one of Drake's callbacks would leave half a step behind.
    """
    event = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield event  # signals reach the main thread only
        return
    previous = signal.signal(signal.SIGINT, lambda *_: event.set())
    try:
        yield event
    finally:
        signal.signal(signal.SIGINT, previous)


def _unwatched_meshcat() -> Meshcat:
    """Return a Meshcat for recording only, which does not say where it listens."""
    logger = logging.getLogger("drake")
    level = logger.level
    logger.setLevel(logging.WARNING)
    try:
        return Meshcat(MeshcatParams(host="localhost"))
    finally:
        logger.setLevel(level)


def _judge(
    summary: Summary,
    scenario: Scenario,
    record: Record,
    assembly: Assembly,
    simulator: Simulator,
) -> None:
    plant = assembly.plant
    context = plant.GetMyContextFromRoot(simulator.get_context())
    measure = MEASURES[scenario.acceptance.measure]
    summary.figures = measure(Run(scenario, record, plant, context))
    summary.verdict, summary.checks = judge(scenario.acceptance, summary.figures)
