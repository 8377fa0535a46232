"""Play a scenario live in the browser: pause, restart, gravity and contact settings by sliders."""

from __future__ import annotations

import tempfile
import time
import webbrowser
from dataclasses import replace
from pathlib import Path

from pydrake.geometry import Meshcat
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, EventStatus
from rich.console import Console

from scenarios.format.scenario import Scenario
from scenarios.progress import ProgressReport, open_meshcat, progress_bar
from scenarios.report.summary import Summary
from scenarios.runner import advance, kept_warnings
from scenarios.simulation.assembly import Assembly, assemble
from scenarios.simulation.drawings import camera_for, moving_radii
from scenarios.simulation.record import collect

_PAUSE, _RESTART, _QUIT = "Pause", "Restart", "Quit"
_GRAVITY, _STIFFNESS = "gravity [g]", "k [10^x of the scenario's]"
_DAMPING, _FRICTION = "alpha [of the scenario's]", "friction [of the scenario's]"
_WEB, _COLLISION = "lines and arrows", "collision layer"
_BROWSER_WAIT = 20.0  # [s]


def play_live(
    console: Console, name: str, scenario: Scenario, *, browser: bool = True
) -> list[str]:
    """Simulate at the pace of real time for a browser to watch, until Quit or Ctrl-C.

    Restart takes over the sliders. Returns the warnings there were.
    """
    warned: list[str] = []
    meshcat = open_meshcat(console)
    if browser and webbrowser.open(meshcat.web_url()):
        _wait_for_browser(meshcat)
    _add_controls(meshcat)
    try:
        with kept_warnings(warned), tempfile.TemporaryDirectory() as folder:
            again = True
            while again:
                again = _play_once(console, name, scenario, meshcat, Path(folder))
    except KeyboardInterrupt:
        console.print("stopped")
    return warned


def _play_once(
    console: Console, name: str, scenario: Scenario, meshcat: Meshcat, folder: Path
) -> bool:
    """Play from the start; return whether to restart."""
    meshcat.Delete("/drake")
    changed = with_sliders(
        scenario,
        *(meshcat.GetSliderValue(s) for s in (_GRAVITY, _STIFFNESS, _DAMPING, _FRICTION)),
    )
    assembly = assemble(changed, folder, meshcat, live=True)
    simulator = assembly.simulator(changed)
    simulator.set_target_realtime_rate(1.0)
    _aim(meshcat, changed, assembly, simulator)
    controls = _Controls(meshcat)
    summary = Summary(name)
    with progress_bar(console) as bar:
        report = ProgressReport(bar, name, changed)
        advance(simulator, changed.simulation_duration, summary, report, also=controls.after_a_step)
    if summary.verdict == "interrupted":
        raise KeyboardInterrupt
    console.print("finished: Restart plays it again, Quit (or Ctrl-C) closes the viewer")
    while not (controls.restart() or controls.quit()):
        controls.show_layers()
        time.sleep(0.05)
    return not controls.quit()


def with_sliders(
    scenario: Scenario, gravity: float, stiffness: float, damping: float, friction: float
) -> Scenario:
    """Return the scenario with gravity and contact settings multiplied, k by a power of ten."""
    contact = scenario.contact

    def times(value: float | None, factor: float) -> float | None:
        return None if value is None else value * factor

    changed = replace(
        contact,
        k=times(contact.k, 10.0**stiffness),
        alpha=times(contact.alpha, damping),
        friction=replace(
            contact.friction,
            static=times(contact.friction.static, friction),
            dynamic=times(contact.friction.dynamic, friction),
        ),
    )
    return replace(scenario, gravity=gravity * scenario.gravity, contact=changed)


class _Controls:
    """The buttons, as this play has seen them."""

    def __init__(self, meshcat: Meshcat) -> None:
        self._meshcat = meshcat
        self._restarts = meshcat.GetButtonClicks(_RESTART)
        self._pauses = meshcat.GetButtonClicks(_PAUSE)
        self._layers: tuple[bool, ...] = ()

    def restart(self) -> bool:
        return bool(self._meshcat.GetButtonClicks(_RESTART) > self._restarts)

    def quit(self) -> bool:
        return bool(self._meshcat.GetButtonClicks(_QUIT) > 0)

    def show_layers(self) -> None:
        layers = tuple(self._meshcat.GetSliderValue(s) >= 0.5 for s in (_WEB, _COLLISION))
        if layers != self._layers:
            self._layers = layers
            self._meshcat.SetProperty("/drake/contact", "visible", layers[0])
            self._meshcat.SetProperty("/drake/collision", "visible", layers[1])

    def after_a_step(self, simulator: Simulator, _: Context) -> EventStatus | None:
        self.show_layers()
        clock = time.monotonic()
        while (self._meshcat.GetButtonClicks(_PAUSE) - self._pauses) % 2:
            if self.restart() or self.quit():
                break
            time.sleep(0.02)
            self.show_layers()
        if time.monotonic() - clock > 0.1:
            simulator.ResetStatistics()  # real time begins anew
        if self.restart() or self.quit():
            return EventStatus.ReachedTermination(simulator.get_system(), "button")
        return None


def _add_controls(meshcat: Meshcat) -> None:
    for button, key in ((_PAUSE, "Space"), (_RESTART, "KeyR"), (_QUIT, "Escape")):
        meshcat.AddButton(button, key)
    for slider, low, high, step, value in (
        (_GRAVITY, 0.0, 2.0, 0.05, 1.0),
        (_STIFFNESS, -2.0, 2.0, 0.1, 0.0),
        (_DAMPING, 0.0, 4.0, 0.1, 1.0),
        (_FRICTION, 0.0, 4.0, 0.1, 1.0),
        (_WEB, 0.0, 1.0, 1.0, 1.0),
        (_COLLISION, 0.0, 1.0, 1.0, 0.0),
    ):
        meshcat.AddSlider(slider, low, high, step, value)


def _wait_for_browser(meshcat: Meshcat) -> None:
    until = time.monotonic() + _BROWSER_WAIT
    while meshcat.GetNumActiveConnections() == 0 and time.monotonic() < until:
        time.sleep(0.05)


def _aim(meshcat: Meshcat, scenario: Scenario, assembly: Assembly, simulator: Simulator) -> None:
    simulator.Initialize()
    record = collect(assembly, simulator.get_context())
    radii = moving_radii(assembly.plant, assembly.contact)
    found = camera_for(record.positions(), max(radii.values(), default=0.1))
    given = scenario.visualization
    meshcat.SetCameraPose(
        given.camera if len(given.camera) else found[0],
        given.target if len(given.target) else found[1],
    )
