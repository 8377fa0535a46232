"""The results as pictures: ratios to other engines, and growth with the number of facets."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from benchmarks import closest_points, growth, witness_coherent, witness_cold
from benchmarks.harness import Row

mpl.use("agg")
_COLOURS = {witness_cold: "C0", witness_coherent: "C2", closest_points: "C1"}


def plot_ratios(rows: Iterable[Row], path: Path) -> None:
    """Draw a dot for each pose and standoff, by pairs of meshes; a dashed line for each target."""
    rows = list(rows)
    figure = Figure(figsize=(8, 4), layout="constrained")
    axes = figure.subplots()
    axes.axvline(1.0, color="black", linewidth=1)
    for i, (module, colour) in enumerate(_COLOURS.items()):
        mine = [row for row in rows if row.benchmark == module.NAME]
        pairs = [row.case.split(",")[0] for row in mine]
        height = [list(dict.fromkeys(pairs)).index(pair) + 0.25 * (i - 1) for pair in pairs]
        yardstick = "coal" if module is not closest_points else "the better of coal and FCL"
        axes.plot(
            [row.ratio for row in mine],
            height,
            f"{colour}o",
            alpha=0.6,
            label=f"{module.NAME}, to {yardstick}",
        )
        axes.axvline(module.TARGET, color=colour, linestyle="--", linewidth=1)
        axes.set_yticks(range(len(set(pairs))), dict.fromkeys(pairs))
    axes.set(xscale="log", xlabel="times faster")
    axes.xaxis.set_major_formatter("{x:g}")
    axes.invert_yaxis()
    axes.grid(axis="x", alpha=0.3)
    figure.legend(loc="outside lower center", ncols=3, fontsize=7)
    figure.savefig(path, dpi=120)


def plot_growth(rows: Iterable[Row], path: Path) -> None:
    """Draw time against the number of facets, ours and coal's."""
    rows = [row for row in rows if row.benchmark == growth.NAME and row.size is not None]
    figure = Figure(figsize=(7, 5), layout="constrained")
    axes = figure.subplots()
    kinds = dict.fromkeys(row.case.rpartition(", ")[0] for row in rows)
    for i, kind in enumerate(kinds):
        mine = [row for row in rows if row.case.rpartition(", ")[0] == kind]
        sizes = [row.size for row in mine]
        axes.plot(sizes, [row.seconds for row in mine], f"C{i}o-", label=kind)
        axes.plot(sizes, [row.yardstick_seconds for row in mine], f"C{i}o:", label=f"{kind}, coal")
    if rows:
        n = np.geomspace(min(row.size for row in rows), max(row.size for row in rows))
        slope = n * np.log2(n)
        axes.plot(n, slope * rows[0].seconds / slope[0], "k--", linewidth=1, label="n log n")
    axes.set(xscale="log", yscale="log", xlabel="facets", ylabel="time [s]")
    figure.legend(loc="outside right upper", fontsize=7)
    axes.grid(alpha=0.3)
    figure.savefig(path, dpi=120)
