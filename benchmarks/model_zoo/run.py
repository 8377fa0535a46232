"""Run models each in a process of its own: a parser that aborts takes only itself along."""

from __future__ import annotations

import json
import multiprocessing
import os
import sys

from benchmarks.apart import ask_apart
from benchmarks.model_zoo.fall import Fall, fall, load, moving_bodies
from benchmarks.model_zoo.files import ModelFile

BUDGET = 60.0  # [s] of a core
_TIME_OUT = 1800.0  # [s] until a process is taken to hang


def fall_apart(model: ModelFile, budget: float = BUDGET) -> Fall:
    """Let a model fall in a process of its own."""
    arguments = (model.package, model.path, str(budget))
    try:
        return Fall(**ask_apart("benchmarks.model_zoo.run", *arguments, time_out=_TIME_OUT))
    except TimeoutError as error:
        return Fall(outcome="failed", reason=str(error))
    except ChildProcessError as error:
        return Fall(outcome="unloaded", reason=str(error))


def loads_and_touches(model: ModelFile) -> bool:
    """Whether Drake loads a model with something that can fall or be touched; in a forked child.

    A parser that aborts takes only the child along.
    """
    child = multiprocessing.get_context("fork").Process(target=_exit_by, args=(model,))
    child.start()
    child.join(_TIME_OUT)
    if child.is_alive():
        child.kill()
    return child.exitcode == 0


def _exit_by(model: ModelFile) -> None:
    try:
        found = bool(moving_bodies(load(model)[1]))
    except Exception:  # noqa: BLE001  whatever a parser raises
        found = False
    os._exit(0 if found else 1)


if __name__ == "__main__":
    print(json.dumps(fall(ModelFile(sys.argv[1], sys.argv[2]), float(sys.argv[3])).as_dict()))
