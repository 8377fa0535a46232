"""Run scenes each in a process of its own."""

from __future__ import annotations

import json
import logging
import resource
import sys
import warnings
from dataclasses import asdict, dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.apart import ask_apart
from benchmarks.model_zoo.files import folder_of
from benchmarks.scenes import door, grippers, ground, piles, pushing, thread
from benchmarks.scenes.scene import Run, Scene

_TIME_OUT = 3600.0  # [s] until a process is taken to hang

SCENES: dict[str, Scene] = {
    scene.name: scene
    for module in (grippers, pushing, piles, ground, thread, door)
    for scene in module.SCENES
}


@dataclass
class Result:
    """What a scene came to under one contact.

    Attributes
    ----------
    figures
        As of `Scene.truths`; empty where it failed.
    real_time_factor
        Simulated time over time of one core, without building.
    megabytes
        The most memory the process held.
    said
        Warnings and messages of the toolkit's on the way, each once.
    failure
        The error, where there is one.
    """

    figures: dict[str, float] = field(default_factory=dict)
    real_time_factor: float = float("nan")
    megabytes: float = float("nan")
    said: list[str] = field(default_factory=list)
    failure: str = ""

    def astray(self, scene: Scene) -> dict[str, float]:
        """Return the figures that are not what they should be."""
        return {
            name: self.figures.get(name, float("nan"))
            for name, truth in scene.truths.items()
            if not truth.met_by(self.figures.get(name, float("nan")))
        }


def missing(scene: Scene) -> list[str]:
    """Return the packages that a scene needs and that are not installed."""
    return [package for package in scene.packages if folder_of(package) is None]


def run_apart(scene: Scene, engine: str) -> Result:
    """Run a scene in a process of its own."""
    try:
        answer = ask_apart("benchmarks.scenes.run", scene.name, engine, time_out=_TIME_OUT)
        return Result(**answer)
    except (TimeoutError, ChildProcessError) as error:
        return Result(failure=str(error))


def run(scene: Scene, engine: str) -> Result:
    """Run a scene under one of `benchmarks.discrete_steps.ENGINES`."""
    messages = _Messages()
    logging.getLogger("contact_toolkit").addHandler(messages)
    with TemporaryDirectory() as folder, warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("default")
        going = Run(scene, engine, Path(folder))
        figures = {name: float(figure) for name, figure in scene.measure(going).items()}
        heard = [*messages.texts, *(str(each.message) for each in said)]
    return Result(
        figures,
        going.time / going.spent,
        resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
        list(dict.fromkeys(text.replace(f"{folder}/", "") for text in heard)),
    )


class _Messages(logging.Handler):
    """Keeps what is logged as a warning or worse."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.texts: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.texts.append(record.getMessage())


if __name__ == "__main__":
    print(json.dumps(asdict(run(SCENES[sys.argv[1]], sys.argv[2]))))
