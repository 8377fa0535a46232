"""Runs spread over the workers of a Dask cluster: this machine's own, or any by its address."""

from __future__ import annotations

import logging
import math
import os
import queue
import signal
import threading
import time
import uuid
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing import resource_tracker
from typing import TYPE_CHECKING, Any

from scenarios.format.errors import ScenarioError
from scenarios.judge.verdicts import ERROR
from scenarios.sweep.isolated import IsolatedRuns, Task
from scenarios.sweep.outcome import Outcome

if TYPE_CHECKING:
    from distributed import Client, Future

    from scenarios.sweep.plan import PlannedRun

ANSWER = 30.0  # [s] within which a scheduler must answer, and have a worker
AHEAD = 2  # runs sent out per worker's thread: the next is there when one is done
CENSUS = 2.0  # [s] between two looks at how many workers there are
DEATHS = 3  # workers that may die on a run before it is given up

# Dask looks after itself many times a second: 6 % of a core, and less than 1 % with these.
_QUIET = {
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "10s",
}

_mine = threading.local()  # of a worker's thread: its process for runs


@contextmanager
def cluster(scheduler: str | None, workers: int | None) -> Iterator[Client]:
    """Connect to a scheduler, or start one with workers here; end what was started.

    Raises ScenarioError if Dask is not installed or nobody answers at the address.
    """
    try:
        import dask
        from distributed import Client, LocalCluster
    except ImportError as error:
        raise ScenarioError(
            f"sweeps need Dask ({error}): pip install 'contact-toolkit[sweep]'"
        ) from error
    settings = {
        "distributed.scheduler.allowed-failures": DEATHS,
        "distributed.admin.tick.limit": "1h",
    }
    with dask.config.set(settings | _QUIET):
        if scheduler is None:
            with _out_of_reach_of_ctrl_c():
                here = LocalCluster(
                    n_workers=workers or os.cpu_count() or 1,
                    threads_per_worker=1,
                    memory_limit=None,  # of the process of each run there is a limit of our own
                    dashboard_address="127.0.0.1:0",  # any free port
                    host="127.0.0.1",
                    silence_logs=logging.CRITICAL,  # deaths of workers are ours to tell
                )
            try:
                with Client(here) as client:
                    yield client
            finally:
                with suppress(TimeoutError):  # a busy machine; the workers end with this process
                    here.close()
            return
        try:
            client = Client(scheduler, timeout=ANSWER)
        except (OSError, ValueError) as error:  # a time-out is an OSError
            raise ScenarioError(
                f"no Dask scheduler answers at {scheduler} ({error}); start one with `dask "
                "scheduler`, and workers with `dask worker ADDRESS`"
            ) from error
        with client:
            try:
                client.wait_for_workers(1, timeout=ANSWER)
            except TimeoutError as error:
                raise ScenarioError(
                    f"{scheduler} has no workers; start some with `dask worker ADDRESS`"
                ) from error
            yield client


@contextmanager
def _out_of_reach_of_ctrl_c() -> Iterator[None]:
    """Start processes, and threads that start them, which Ctrl-C does not reach.

    A terminal sends it to every process; the one that called ends the others.
    """
    resource_tracker.ensure_running()  # started later it would undo this for its thread
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def outcomes(
    client: Client, task: Task, runs: Iterable[PlannedRun], stop: threading.Event
) -> Iterator[tuple[PlannedRun, Outcome]]:
    """Yield runs with their outcomes as they finish, until all are done or `stop` is set.

    Runs of workers that die are done again elsewhere; one on which several died is an outcome. What
    is wrong with a worker itself is raised.
    """
    finished: queue.SimpleQueue[tuple[PlannedRun, Future]] = queue.SimpleQueue()
    prefix = uuid.uuid4().hex  # two sweeps may share a scheduler
    waiting, at_work = iter(runs), 0
    more, threads, asked = True, 1, -math.inf
    while not stop.is_set():
        if time.monotonic() > asked + CENSUS:
            threads, asked = max(1, _threads(client)), time.monotonic()
        while more and at_work < AHEAD * threads:
            run = next(waiting, None)
            if more := run is not None:
                assert run is not None
                future = client.submit(
                    _run, task, list(run.overrides), key=f"run-{prefix}-{run.number}", pure=False
                )
                future.add_done_callback(lambda done, run=run: finished.put((run, done)))
                at_work += 1
        if not at_work:
            return
        try:
            run, future = finished.get(timeout=0.5)
        except queue.Empty:
            continue
        if stop.is_set():  # Ctrl-C may have reached workers of this machine too
            return
        at_work -= 1
        yield run, _outcome_of(future)
        future.release()


def _outcome_of(future: Future) -> Outcome:
    from distributed import CancelledError, KilledWorker

    try:
        outcome: Outcome = future.result()
    except KilledWorker:
        return Outcome(ERROR, f"{DEATHS + 1} workers died on it")
    except (CancelledError, OSError) as error:
        raise ScenarioError(f"the connection to the scheduler was lost: {error}") from error
    return outcome


def _run(task: Task, overrides: list[str]) -> Outcome:
    """Run in this worker's own process for runs, which lives as long as the sweep."""
    runs: IsolatedRuns | None = getattr(_mine, "runs", None)
    if runs is None or runs.task != task:
        if runs is not None:
            runs.close()
        runs = _mine.runs = IsolatedRuns(task)
    return runs.run(overrides)


def _threads(client: Client) -> int:
    workers: dict[str, Any] = client.scheduler_info(n_workers=-1)["workers"]
    return sum(int(worker["nthreads"]) for worker in workers.values())
