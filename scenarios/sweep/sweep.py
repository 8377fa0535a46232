"""Run a study: what is not yet in its dataset goes to the workers, what they find into rows."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

from scenarios.interruption import interruption
from scenarios.judge.verdicts import FAILED, PASSED
from scenarios.sweep.dataset import Dataset
from scenarios.sweep.isolated import Task
from scenarios.sweep.outcome import Outcome
from scenarios.sweep.plan import Plan, PlannedRun
from scenarios.sweep.schedule import cluster, outcomes

MOST_ROWS = 500  # in memory before they are written
SHORTEST, LONGEST = 1.0, 20.0  # [s] that a row waits to be written, at first and later on


@dataclass
class Tally:
    """How far a sweep is."""

    total: int
    before: int = 0
    done: int = 0
    passed: int = 0
    failed: int = 0
    stopped: bool = False
    started: float = field(default_factory=time.monotonic)

    @property
    def without_figures(self) -> int:
        """Runs that broke, timed out or diverged."""
        return self.done - self.passed - self.failed

    def count(self, verdict: str) -> None:
        """Count one more run."""
        self.done += 1
        self.passed += verdict == PASSED
        self.failed += verdict == FAILED


def sweep(
    plan: Plan,
    folder: Path,
    *,
    resume: bool = False,
    scheduler: str | None = None,
    workers: int | None = None,
    progress: Callable[[Tally], None] = lambda _: None,
) -> Tally:
    """Do the runs of a plan that its folder does not hold yet, and return how it went.

    Rows are written every few seconds, so that whatever ends the sweep costs the runs of these at
    most. Ctrl-C ends it early. Raises ScenarioError for a plan, folder or scheduler that will not
    do, OSError naming the file where the disk does not take the rows.
    """
    plan.check()
    dataset = Dataset(folder, plan)
    study, versions = plan.study, plan.identity["versions"]
    base = plan.base
    task = Task(base.name, base.raw, str(base.path), versions, study.time_out, study.memory_limit)
    with dataset.writing(resume=resume), interruption() as stop:
        verdicts = dict(zip(*dataset.columns("key", "verdict"), strict=True))
        runs = plan.runs()
        missing = [run for run in runs if run.key not in verdicts]
        tally = Tally(len(runs))
        for run in runs:
            if run.key in verdicts:
                tally.count(verdicts[run.key])
        tally.before = tally.done
        progress(tally)
        if missing:
            with cluster(scheduler, workers) as client, _Buffer(dataset) as buffer:
                for run, outcome in outcomes(client, task, missing, stop):
                    buffer.add(_row(run, outcome, versions))
                    tally.count(outcome.verdict)
                    progress(tally)
        tally.stopped = stop.is_set()
    return tally


class _Buffer:
    """Rows on their way into the dataset; what is left goes in at the end, whatever that is."""

    def __init__(self, dataset: Dataset) -> None:
        self._dataset = dataset
        self._rows: list[dict[str, Any]] = []
        self._wait, self._written = SHORTEST, time.monotonic()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._write()

    def add(self, row: dict[str, Any]) -> None:
        self._rows.append(row)
        if len(self._rows) >= MOST_ROWS or time.monotonic() > self._written + self._wait:
            self._write()
            self._wait = min(2.0 * self._wait, LONGEST)  # few files, however long it lasts

    def _write(self) -> None:
        rows, self._rows = self._rows, []
        self._written = time.monotonic()
        if rows:
            self._dataset.add(rows)


def _row(run: PlannedRun, outcome: Outcome, versions: dict[str, str]) -> dict[str, Any]:
    row = outcome.row()
    figures = row.pop("figures")
    said = {"key": run.key, "run": run.number, "seed": run.seed, "versions": json.dumps(versions)}
    return said | row | run.inputs | figures
