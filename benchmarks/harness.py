"""Medians of interleaved runs, and the rows of the results table."""

from __future__ import annotations

import gc
import statistics
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

RUNS = 9
_SHORTEST_RUN = 1e-2  # [s] shorter calls are repeated within a run: timers and caches settle


@dataclass(frozen=True)
class Row:
    """One line of the results: how much faster than its yardstick something is.

    Attributes
    ----------
    benchmark, case
        What was measured, and on what.
    yardstick
        What it was compared with, in the same run.
    seconds, yardstick_seconds
        Medians [s] per call; a yardstick may also be a budget.
    target
        The least acceptable ratio; None where the figure is for information.
    size, output
        Facets (or bodies) that go in, rows (or touching pairs) that come out.
    """

    benchmark: str
    case: str
    yardstick: str
    seconds: float
    yardstick_seconds: float
    target: float | None = None
    size: int | None = None
    output: int | None = None

    @property
    def ratio(self) -> float:
        """How many times faster than the yardstick."""
        return self.yardstick_seconds / self.seconds


@dataclass
class Stopwatch:
    """Times calls against each other in one process.

    Parameters
    ----------
    runs
        Timed runs of each; their median counts.
    clock
        Wall time, or on a busy machine `time.thread_time`, the calling thread's own.
    """

    runs: int = RUNS
    clock: Callable[[], float] = time.perf_counter

    def medians(self, *calls: Callable[[], object]) -> list[float]:
        """Return the median duration [s] of each call, all of them run in turn, `runs` times."""
        repeats = [self._repeats(call) for call in calls]  # the first runs, thrown away
        samples: list[list[float]] = [[] for _ in calls]
        gc.disable()
        try:
            for _ in range(self.runs):
                for call, repeat, sample in zip(calls, repeats, samples, strict=True):
                    start = self.clock()
                    for _ in range(repeat):
                        call()
                    sample.append((self.clock() - start) / repeat)
        finally:
            gc.enable()
        return [statistics.median(sample) for sample in samples]

    def row(
        self,
        benchmark: str,
        case: str,
        ours: Callable[[], object],
        yardsticks: Mapping[str, Callable[[], object]],
        **figures: float | None,
    ) -> Row:
        """Compare `ours` with the fastest of the yardsticks."""
        seconds, *others = self.medians(ours, *yardsticks.values())
        best, name = min(zip(others, yardsticks, strict=True))
        return Row(benchmark, case, name, seconds, best, **figures)

    @staticmethod
    def _repeats(call: Callable[[], object]) -> int:
        call()
        start = time.perf_counter()
        call()
        return max(1, int(_SHORTEST_RUN / max(time.perf_counter() - start, 1e-9)))
