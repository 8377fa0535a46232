"""Runs benchmarks, prints their rows, writes the table and the plots: `python -m benchmarks`."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path

from benchmarks import (
    bin_of_parts,
    closest_points,
    contact_forces,
    contact_in_drake,
    facet_kernel,
    growth,
    point_distances,
    real_parts,
    translation_sweep,
    two_threads,
    witness_coherent,
    witness_cold,
    witness_merging,
)
from benchmarks.attitudes import each_with_itself_and_the_next, parts_in_folder
from benchmarks.harness import RUNS, Row, Stopwatch
from benchmarks.plots import plot_growth, plot_ratios
from benchmarks.report import as_line, write_results

BENCHMARKS = {
    module.__name__.rpartition(".")[2]: module
    for module in (
        witness_cold,
        witness_merging,
        witness_coherent,
        closest_points,
        real_parts,
        point_distances,
        translation_sweep,
        growth,
        facet_kernel,
        contact_forces,
        contact_in_drake,
        bin_of_parts,
        two_threads,
    )
}


def main() -> None:
    """Run the benchmarks named on the command line, or all."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(BENCHMARKS)}")
    parser.add_argument("--runs", type=int, default=RUNS, help="of each call; the median counts")
    parser.add_argument("--coarser", type=int, default=1, help="divides the meshes' sections")
    parser.add_argument("--cpu-time", action="store_true", help="for busy machines: no wall time")
    parser.add_argument("--out", type=Path, help="folder for the table and plots of a full run")
    parser.add_argument(
        "--meshes", type=Path, help="folder of mesh files to measure instead, as in real_parts"
    )
    options = parser.parse_args()
    if unknown := set(options.names) - set(BENCHMARKS):
        parser.error(f"no benchmark is called {', '.join(unknown)}")

    watch = Stopwatch(options.runs, time.thread_time if options.cpu_time else time.perf_counter)
    rows: list[Row] = []
    measurements: dict[str, Callable[[], Iterable[Row]]] = {
        name: partial(BENCHMARKS[name].measure, watch, options.coarser)
        for name in options.names or BENCHMARKS
    }
    if options.meshes:
        parts = parts_in_folder(options.meshes)
        pairs = each_with_itself_and_the_next(parts)
        measurements = {str(options.meshes): partial(real_parts.measure_pairs, watch, pairs)}
    for name, measure in measurements.items():
        print(f"\n{name}", flush=True)
        for row in measure():
            print(as_line(row), flush=True)
            rows.append(row)
    if options.out:
        options.out.mkdir(parents=True, exist_ok=True)
        write_results(rows, watch, options.out)
        plot_ratios(rows, options.out / "ratios.png")
        plot_growth(rows, options.out / "growth.png")


if __name__ == "__main__":
    main()
