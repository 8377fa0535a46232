"""Run a scenario into a folder: time series, figures, playback, summary, verdict.

The folder holds `scenario.yaml` (complete, runnable), `summary.json`, `series.parquet`,
`playback.html` (self-contained), `figures/*.png` and `parts/` (the generated models). It appears
only when it is whole, whatever ended the run; `summary.json` says what did.
"""

from __future__ import annotations

import logging
import threading
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pydrake.geometry import Meshcat, MeshcatParams
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, EventStatus

from scenarios.format.loading import dump
from scenarios.format.scenario import Scenario
from scenarios.interruption import interruption
from scenarios.judge.acceptance import check_acceptance, judge, measure
from scenarios.judge.measures import Run
from scenarios.judge.verdicts import ERROR, FAILED, INTERRUPTED
from scenarios.report.figures import draw_series
from scenarios.report.provenance import commit, host, now, versions
from scenarios.report.summary import Summary
from scenarios.report.web_figure import draw_web
from scenarios.run_folder import RunFolder
from scenarios.simulation.assembly import Assembly, assemble
from scenarios.simulation.drawings import camera_for, moving_radii
from scenarios.simulation.record import Record, collect, column_names

Progress = Callable[[float], None]
"""Called with the simulated time [s] as the run advances."""

REPORT_PERIOD = 0.1  # [s] of wall time between two calls


def run(
    name: str,
    scenario: Scenario,
    folder: Path,
    *,
    replace: bool = False,
    overrides: Sequence[str] = (),
    progress: Progress = lambda _: None,
    meshcat: Meshcat | None = None,
) -> Summary:
    """Run a scenario into `folder` and return its summary.

    Raises ScenarioError, and leaves everything as it was, for a scenario that cannot be run and for
    a folder that holds another run (unless `replace`) or that another run is writing. Ctrl-C in
    set-up raises KeyboardInterrupt and keeps nothing; later it ends the run early, with what there
    is until then in the folder. What the simulation itself raises is passed on after the folder has
    been written.
    """
    check_acceptance(scenario.acceptance)
    target = RunFolder(folder, replace=replace)
    partial = target.open()
    summary = Summary(
        name,
        random_seed=scenario.random_seed,
        overrides=list(overrides),
        truth=scenario.acceptance.truth,
        date=now(),
        commit=commit(),
        host=host(),
        versions=versions(),
    )
    try:
        with kept_warnings(summary.warnings):
            (partial / "scenario.yaml").write_text(dump(name, scenario), encoding="utf-8")
            meshcat = meshcat or unwatched_meshcat()
            assembly = assemble(scenario, partial / "parts", meshcat)
            check_acceptance(scenario.acceptance, column_names(assembly))
            simulator = assembly.simulator(scenario)
            trouble = _simulate(summary, scenario, simulator, meshcat, progress)
            _finish(summary, scenario, assembly, simulator, meshcat, partial)
            summary.save(partial)
        summary.folder = str(target.keep())
    finally:
        target.discard()
    if trouble is not None:
        raise trouble
    return summary


def _simulate(
    summary: Summary,
    scenario: Scenario,
    simulator: Simulator,
    meshcat: Meshcat,
    progress: Progress,
) -> Exception | None:
    """Advance to the end, and return what the simulation raised if it did."""
    meshcat.StartRecording(scenario.visualization.frame_rate)
    try:
        advance(simulator, scenario.simulation_duration, summary, progress)
    except Exception as error:  # noqa: BLE001  raised again once the folder is written
        summary.verdict, summary.error = ERROR, f"{type(error).__name__}: {error}"
        return error
    finally:
        meshcat.StopRecording()
        meshcat.PublishRecording()
    return None


def _finish(
    summary: Summary,
    scenario: Scenario,
    assembly: Assembly,
    simulator: Simulator,
    meshcat: Meshcat,
    folder: Path,
) -> None:
    """Write what was recorded, judge it and draw it; nothing but a full disk ends this early."""
    root = simulator.get_context()
    try:
        record = collect(assembly, root)
        record.save(folder / "series.parquet")
        judge_run(summary, scenario, record, assembly, simulator)
        _aim(meshcat, scenario, record, assembly)
        (folder / "playback.html").write_text(meshcat.StaticHtml(), encoding="utf-8")
        for draw in (
            lambda: draw_series(record, folder / "figures"),
            lambda: draw_web(record, assembly, root, folder / "figures"),
        ):
            try:
                draw()
            except (ValueError, ArithmeticError, LookupError, RuntimeError) as error:
                summary.warnings.append(f"a figure could not be drawn: {error}")
    except KeyboardInterrupt:
        summary.verdict, summary.error = INTERRUPTED, "interrupted while the run was evaluated"


def advance(
    simulator: Simulator,
    duration: float,
    summary: Summary,
    progress: Progress,
    *,
    also: Callable[[Simulator, Context], EventStatus | None] = lambda *_: None,
) -> None:
    """Advance by `duration` [s], or until Ctrl-C; note times and counts in the summary.

    `also` is called after every step and may end the run.
    """
    start_time = simulator.get_context().get_time()
    with interruption() as interrupted:
        simulator.set_monitor(_monitor(simulator, interrupted, progress, also))
        started = time.perf_counter()
        try:
            simulator.Initialize()
            simulator.AdvanceTo(start_time + duration)
        except KeyboardInterrupt:
            interrupted.set()
        finally:
            simulator.clear_monitor()
            summary.wall_time = time.perf_counter() - started
            summary.simulated_time = simulator.get_context().get_time() - start_time
            summary.real_time_factor = summary.simulated_time / summary.wall_time
            integrator = simulator.get_integrator()
            summary.force_evaluations = integrator.get_num_derivative_evaluations()
            summary.steps = simulator.get_num_steps_taken()
        if not interrupted.is_set():
            progress(summary.simulated_time)
    if interrupted.is_set():
        summary.verdict = INTERRUPTED


def _monitor(
    simulator: Simulator,
    interrupted: threading.Event,
    progress: Progress,
    also: Callable[[Simulator, Context], EventStatus | None],
) -> Callable[[Context], EventStatus | None]:
    start_time = simulator.get_context().get_time()
    next_report = 0.0

    def monitor(context: Context) -> EventStatus | None:
        nonlocal next_report
        if interrupted.is_set():
            return EventStatus.ReachedTermination(simulator.get_system(), "interrupted")
        if time.monotonic() >= next_report:
            next_report = time.monotonic() + REPORT_PERIOD
            progress(context.get_time() - start_time)
        return also(simulator, context)

    return monitor


@contextmanager
def kept_warnings(kept: list[str]) -> Iterator[None]:
    """Keep the messages of warnings, each once, instead of printing them amid the progress."""

    def keep(message: Warning | str, *_: Any, **__: Any) -> None:
        if str(message) not in kept:
            kept.append(str(message))

    with warnings.catch_warnings():
        warnings.showwarning = keep
        yield


def unwatched_meshcat() -> Meshcat:
    """Return a Meshcat for recording only, which does not say where it listens."""
    logger = logging.getLogger("drake")
    level = logger.level
    logger.setLevel(logging.WARNING)
    try:
        return Meshcat(MeshcatParams(host="localhost"))
    finally:
        logger.setLevel(level)


def _aim(meshcat: Meshcat, scenario: Scenario, record: Record, assembly: Assembly) -> None:
    """Point the playback's camera at where the bodies went, as far as the scenario leaves it."""
    radii = moving_radii(assembly.plant, assembly.contact)
    found = camera_for(record.positions(), max(radii.values(), default=0.1))
    given = scenario.visualization
    camera, target = (
        wanted if len(wanted) else automatic
        for wanted, automatic in zip((given.camera, given.target), found, strict=True)
    )
    meshcat.SetCameraPose(camera, target)


def judge_run(
    summary: Summary,
    scenario: Scenario,
    record: Record,
    assembly: Assembly,
    simulator: Simulator,
) -> None:
    """Measure and judge a run that reached its end; report, not raise, what cannot be measured."""
    acceptance = scenario.acceptance
    if summary.verdict in (ERROR, INTERRUPTED) or not (acceptance.measure or acceptance.figures):
        return
    context = assembly.plant.GetMyContextFromRoot(simulator.get_context())
    try:
        summary.figures = measure(Run(scenario, record, assembly.plant, context))
        summary.verdict, summary.checks = judge(acceptance, summary.figures)
    except ValueError as error:  # there is no such figure: no equilibrium, for example
        summary.verdict, summary.error = FAILED, str(error)
    except Exception as error:  # noqa: BLE001  a fault of ours in judging; the run itself is whole
        summary.verdict, summary.error = ERROR, f"judging: {type(error).__name__}: {error}"
