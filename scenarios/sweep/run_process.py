"""The process that a worker's runs happen in: jobs come in on stdin, outcomes go out on stdout.

Both as lines of JSON. It ends with its input, so with the worker, whatever ended that.
"""

from __future__ import annotations

import json
import os
import queue
import sys
import threading
from pathlib import Path
from typing import Any, TextIO


def serve(jobs: TextIO, answers: TextIO) -> None:
    """Answer jobs, each a list of overrides, for the scenario that the first line holds."""
    from scenarios.format.loading import RawScenario
    from scenarios.report.provenance import decisive_versions

    task = json.loads(jobs.readline())
    base = RawScenario(task["name"], task["raw"], Path(task["path"]))
    _answer(answers, decisive_versions())
    waiting: queue.SimpleQueue[list[str]] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(jobs, waiting), daemon=True).start()
    while True:
        _answer(answers, _outcome(base, waiting.get(), task["time_out"]))


def _outcome(base: Any, overrides: list[str], time_out: float) -> dict[str, Any]:
    from scenarios.format.errors import ScenarioError
    from scenarios.judge.verdicts import ERROR
    from scenarios.sweep.outcome import Outcome
    from scenarios.sweep.rollout import run_once

    try:
        scenario = base.load(overrides)
    except ScenarioError as error:  # a value that was drawn is none that the scenario can have
        return Outcome(ERROR, str(error)).row()
    return run_once(base.name, scenario, time_out=time_out).row()


def _listen(jobs: TextIO, waiting: queue.SimpleQueue[list[str]]) -> None:
    for line in jobs:
        waiting.put(json.loads(line))
    os._exit(0)  # even in the middle of a run: nobody waits for its outcome


def _answer(answers: TextIO, what: Any) -> None:
    answers.write(json.dumps(what) + "\n")
    answers.flush()


if __name__ == "__main__":
    # Whatever else prints, as Drake's logger does, must not get between the answers.
    out = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    serve(sys.stdin, out)
