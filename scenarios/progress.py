"""Run a scenario from the terminal: progress bar, live viewing."""

from __future__ import annotations

import time
from pathlib import Path

from pydrake.geometry import Meshcat, MeshcatParams
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

from scenarios.assembly import assemble
from scenarios.runner import advance, run
from scenarios.scenario import Scenario
from scenarios.summary import Summary


def run_with_progress(
    console: Console, name: str, scenario: Scenario, folder: Path, *, live: bool = False
) -> Summary:
    """Run a scenario into `folder` behind a progress bar; `live` also shows it in the browser."""
    meshcat = _open_meshcat(console) if live else None
    with _bar(console) as bar:
        return run(name, scenario, folder, progress=_Report(bar, name, scenario), meshcat=meshcat)


def play_live(console: Console, name: str, scenario: Scenario, folder: Path) -> None:
    """Simulate at the pace of real time for a browser to watch; then wait for Enter."""
    meshcat = _open_meshcat(console)
    assembly = assemble(scenario, folder, meshcat)
    simulator = assembly.simulator(scenario)
    simulator.set_target_realtime_rate(1.0)
    with _bar(console) as bar:
        advance(
            simulator,
            scenario.simulation_duration,
            Summary(name),
            _Report(bar, name, scenario),
        )
    console.input("Enter closes the viewer. ")


class _Report:
    """Moves the bar and works out the real-time factor."""

    def __init__(self, bar: Progress, name: str, scenario: Scenario) -> None:
        self._bar = bar
        self._task = bar.add_task(name, total=scenario.simulation_duration, rate=0.0)
        self._started = time.perf_counter()

    def __call__(self, simulated: float) -> None:
        elapsed = max(time.perf_counter() - self._started, 1e-9)
        self._bar.update(self._task, completed=simulated, rate=simulated / elapsed)


def _bar(console: Console) -> Progress:
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:.2f} of {task.total:.2f} s simulated"),
        TextColumn("real-time factor {task.fields[rate]:.2f}"),
        console=console,
    )


def _open_meshcat(console: Console) -> Meshcat:
    meshcat = Meshcat(MeshcatParams(host="localhost"))
    console.print(f"watch at {meshcat.web_url()}", soft_wrap=True)
    return meshcat
