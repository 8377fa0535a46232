"""Run a scenario from the terminal behind a progress bar."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

from pydrake.geometry import Meshcat, MeshcatParams
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

from scenarios.format.scenario import Scenario
from scenarios.report.summary import Summary
from scenarios.runner import run


def run_with_progress(
    console: Console,
    name: str,
    scenario: Scenario,
    folder: Path,
    *,
    replace: bool = False,
    overrides: Sequence[str] = (),
    live: bool = False,
) -> Summary:
    """Run a scenario into `folder` behind a progress bar; `live` also shows it in the browser."""
    meshcat = open_meshcat(console) if live else None
    with progress_bar(console) as bar:
        return run(
            name,
            scenario,
            folder,
            replace=replace,
            overrides=overrides,
            progress=ProgressReport(bar, name, scenario),
            meshcat=meshcat,
        )


class ProgressReport:
    """Moves the bar and works out the real-time factor."""

    def __init__(self, bar: Progress, name: str, scenario: Scenario) -> None:
        self._bar = bar
        self._task = bar.add_task(name, total=scenario.simulation_duration, rate=0.0)
        self._started = 0.0

    def __call__(self, simulated: float) -> None:
        """Take the simulated time [s]."""
        self._started = self._started or time.perf_counter()  # without the set-up
        elapsed = max(time.perf_counter() - self._started, 1e-9)
        self._bar.update(self._task, completed=simulated, rate=simulated / elapsed)


def progress_bar(console: Console) -> Progress:
    """Return a bar with simulated time and real-time factor."""
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:.2f} of {task.total:.2f} s simulated"),
        TextColumn("real-time factor {task.fields[rate]:.2f}"),
        console=console,
    )


def open_meshcat(console: Console) -> Meshcat:
    """Start a Meshcat that only this machine reaches, and say where."""
    meshcat = Meshcat(MeshcatParams(host="localhost"))
    console.print(f"watch at {meshcat.web_url()}", soft_wrap=True)
    return meshcat
