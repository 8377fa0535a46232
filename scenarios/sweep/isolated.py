"""Runs in a process of their own, which may crash, hang or grow without taking the sweep along."""

from __future__ import annotations

import json
import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from scenarios.format.errors import ScenarioError
from scenarios.judge.verdicts import ERROR, TIMED_OUT
from scenarios.sweep.outcome import Outcome

GRACE = 1.5  # a run ends itself between steps; so many times its time-out, it is ended
LOOK = 0.2  # [s] between two looks at the memory
FRESH = 0.5  # share of the memory limit beyond which the next run gets a new process
_START = 120.0  # [s] a process may take to begin: Drake from a cold disk


@dataclass(frozen=True)
class Task:
    """What all runs of a sweep share, for a worker on any machine."""

    name: str
    raw: dict[str, Any]
    path: str
    """These three of a `RawScenario`."""
    versions: dict[str, str]
    time_out: float
    memory_limit: float  # [GB]


class IsolatedRuns:
    """Runs one after another in a process that is replaced when it dies or has grown."""

    def __init__(self, task: Task) -> None:
        self.task = task
        self._process: subprocess.Popen[str] | None = None

    def run(self, overrides: Sequence[str]) -> Outcome:
        """Return the outcome of a run, also where its process had to be ended.

        Raises ScenarioError if other versions are installed here than where the sweep began.
        """
        process = self._process or self._start()
        started = time.perf_counter()
        self._say(process, list(overrides))
        limit = GRACE * self.task.time_out
        line, reason = self._wait(process, limit)
        if line:
            if _memory(process) > FRESH * self.task.memory_limit:
                self.close()
            return Outcome(**json.loads(line))
        self.close()
        late = reason == TIMED_OUT
        said = f"hung: not done after {limit:g} s, and had to be killed" if late else reason
        wall_time = time.perf_counter() - started
        return Outcome(TIMED_OUT if late else ERROR, said, wall_time=wall_time)

    def close(self) -> None:
        """End the process."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.wait()
            for pipe in (process.stdin, process.stdout):
                with suppress(OSError):  # what was still to be said to it
                    assert pipe is not None
                    pipe.close()

    def _start(self) -> subprocess.Popen[str]:
        one_thread = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
        self._process = process = subprocess.Popen(
            [sys.executable, "-m", "scenarios.sweep.run_process"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=os.environ | one_thread,
            start_new_session=True,  # Ctrl-C is for the sweep, which ends its runs
        )
        self._say(process, asdict(self.task))
        line, reason = self._wait(process, _START)
        if not line:
            self.close()
            raise ScenarioError(
                f"the process for runs did not start: {reason}; Drake alone takes some 0.4 GB"
            )
        if (found := json.loads(line)) != self.task.versions:
            self.close()
            raise ScenarioError(
                f"a worker has other versions than the sweep was started with: {_listed(found)}, "
                f"not {_listed(self.task.versions)}; its rows would not be comparable"
            )
        return process

    @staticmethod
    def _say(process: subprocess.Popen[str], what: Any) -> None:
        assert process.stdin is not None
        try:
            process.stdin.write(json.dumps(what) + "\n")
            process.stdin.flush()
        except BrokenPipeError:
            pass  # it died; told by who waits for its answer

    def _wait(self, process: subprocess.Popen[str], limit: float) -> tuple[str, str]:
        """Return its next line, or "" and why there is none."""
        assert process.stdout is not None
        deadline = time.monotonic() + limit
        while not select.select([process.stdout], [], [], LOOK)[0]:
            if _memory(process) > self.task.memory_limit:
                return "", f"used more than its {self.task.memory_limit:g} GB of memory"
            if time.monotonic() > deadline:
                return "", TIMED_OUT
        if line := process.stdout.readline():
            return line, ""
        code = process.wait()
        died = f"by {signal.Signals(-code).name}" if code < 0 else f"with status {code}"
        return "", f"the process died {died}"


def _memory(process: subprocess.Popen[str]) -> float:
    """Return the resident memory of a process [GB], 0 if it is gone."""
    try:
        pages = Path(f"/proc/{process.pid}/statm").read_text(encoding="ascii").split()[1]
    except (OSError, IndexError):
        return 0.0
    return int(pages) * os.sysconf("SC_PAGE_SIZE") / 1e9


def _listed(versions: dict[str, str]) -> str:
    return ", ".join(f"{name} {number}" for name, number in versions.items())
