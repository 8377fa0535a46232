"""Pictures of a sweep, as SVG for a page and as PNG for a document."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.stats import binomtest

CONFIDENCE = 0.95
_SMALLEST = 3  # runs a bin of a contour needs to have a mean worth drawing

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Draw = Callable[[Axes], None]


def interval(successes: int, runs: int) -> tuple[float, float]:
    """Return Wilson's interval of a success rate; all of [0, 1] where nothing was tried."""
    if runs == 0:
        return 0.0, 1.0
    found = binomtest(successes, runs).proportion_ci(CONFIDENCE, method="wilson")
    return float(found.low), float(found.high)


class Axis:
    """A column as an axis: numbers in bins, or the names of choices side by side."""

    def __init__(self, name: str, values: list[float] | list[str], bins: int) -> None:
        self.name = name
        self.names = sorted({v for v in values if isinstance(v, str)})
        if self.names:
            self.values = np.array([self.names.index(str(v)) for v in values], dtype=np.float64)
            self.edges = np.arange(len(self.names) + 1) - 0.5
        else:
            self.values = np.asarray(values, dtype=np.float64)
            finite = self.values[np.isfinite(self.values)]
            low, high = (finite.min(), finite.max()) if len(finite) else (0.0, 1.0)
            # Of equal counts where values bunch, as those of a normal distribution do.
            shares = np.linspace(0.0, 1.0, bins + 1)
            edges = np.unique(np.quantile(finite, shares)) if len(finite) else finite
            self.edges = edges if len(edges) > 2 else np.array([low, max(high, low + 1e-9)])

    @property
    def bins(self) -> NDArray[np.int64]:
        """Index of the bin of each value, the last one's upper end included."""
        found = np.searchsorted(self.edges, self.values, side="right") - 1
        return np.clip(found, 0, len(self.edges) - 2)

    def label(self, index: int) -> str:
        """Return what a bin is called."""
        if self.names:
            return self.names[index]
        return f"{self.edges[index]:.3g} to {self.edges[index + 1]:.3g}"

    def name_x(self, axes: Axes) -> None:
        """Label the horizontal axis."""
        axes.set_xlabel(self.name)
        if self.names:
            axes.set_xticks(range(len(self.names)), self.names)


def success_map(x: Axis, y: Axis, passed: Bools) -> Draw:
    """Draw the rate of success over two columns; every cell with counts and Wilson's interval."""

    def draw(axes: Axes) -> None:
        shape = len(y.edges) - 1, len(x.edges) - 1
        runs, good = np.zeros(shape, dtype=int), np.zeros(shape, dtype=int)
        np.add.at(runs, (y.bins, x.bins), 1)
        np.add.at(good, (y.bins, x.bins), passed.astype(int))
        rate = np.where(runs > 0, good / np.maximum(runs, 1), np.nan)
        mesh = axes.pcolormesh(
            np.arange(shape[1] + 1), np.arange(shape[0] + 1), rate, cmap="RdYlGn", vmin=0, vmax=1
        )
        for row, column in np.ndindex(*shape):
            k, n = int(good[row, column]), int(runs[row, column])
            low, high = interval(k, n)
            said = f"{k}/{n}\n{100 * low:.0f}–{100 * high:.0f} %" if n else "–"
            axes.text(column + 0.5, row + 0.5, said, ha="center", va="center", fontsize=7)
        for axis, ticks in ((x, axes.set_xticks), (y, axes.set_yticks)):
            if axis.names:
                ticks(np.arange(len(axis.names)) + 0.5, axis.names)
            else:
                ticks(np.arange(len(axis.edges)), [f"{edge:.3g}" for edge in axis.edges])
        axes.set(xlabel=x.name, ylabel=y.name)
        axes.figure.colorbar(mesh, ax=axes, label="rate of success")

    return draw


def scatter(x: Axis, y: Axis, passed: Bools, judged: Bools) -> Draw:
    """Draw one point a run, by verdict."""

    def draw(axes: Axes) -> None:
        for said, which, colour in (
            ("passed", judged & passed, "tab:green"),
            ("failed", judged & ~passed, "tab:red"),
            ("no figures", ~judged, "tab:gray"),
        ):
            if which.any():
                axes.plot(
                    x.values[which], y.values[which], ".", color=colour, markersize=4, label=said
                )
        x.name_x(axes)
        axes.set_ylabel(y.name)
        axes.legend(fontsize=7)

    return draw


def contour(x: Axis, y: Axis, values: Floats, name: str) -> Draw:
    """Draw the mean of a figure over two columns, from bins with enough runs in them."""

    def draw(axes: Axes) -> None:
        known = np.isfinite(values)
        shape = len(y.edges) - 1, len(x.edges) - 1
        runs, total = np.zeros(shape), np.zeros(shape)
        np.add.at(runs, (y.bins[known], x.bins[known]), 1.0)
        np.add.at(total, (y.bins[known], x.bins[known]), values[known])
        mean = np.where(runs >= _SMALLEST, total / np.maximum(runs, 1), np.nan)
        middle = [(axis.edges[:-1] + axis.edges[1:]) / 2 for axis in (x, y)]
        if min(shape) < 2 or np.isfinite(mean).sum() < 4:
            axes.text(0.5, 0.5, "too few runs", ha="center", transform=axes.transAxes)
        else:
            filled = axes.contourf(*middle, mean, levels=9, cmap="viridis")
            axes.figure.colorbar(filled, ax=axes, label=f"mean {name}")
        axes.set(xlabel=x.name, ylabel=y.name)

    return draw


def histogram(values: Floats, name: str, bins: int = 16) -> Draw:
    """Draw the shares of runs by a figure, each with Wilson's interval."""

    def draw(axes: Axes) -> None:
        known = values[np.isfinite(values)]
        counts, edges = np.histogram(known, bins)
        n = len(known)
        share = counts / max(n, 1)
        low, high = np.array([interval(int(k), n) for k in counts]).T
        middle = (edges[:-1] + edges[1:]) / 2
        axes.bar(middle, share, np.diff(edges), color="tab:blue", alpha=0.6)
        errors = np.abs([share - low, high - share])
        axes.errorbar(middle, share, errors, fmt="none", ecolor="black", elinewidth=0.7)
        axes.set(xlabel=name, ylabel="share of runs")

    return draw


def figure_of(*panels: Draw, width: float = 4.6, height: float = 3.6) -> Figure:
    """Return a figure with the panels side by side."""
    figure = Figure(figsize=(width * len(panels), height), layout="constrained")
    for axes, draw in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
        draw(axes)
    return figure


def as_svg(figure: Figure) -> str:
    """Return a figure as an SVG element for a page."""
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None})
    svg = text.getvalue()
    return svg[svg.index("<svg") :]


def as_png(figure: Figure, path: Path) -> Path:
    """Write a figure as PNG."""
    figure.savefig(path, dpi=110)
    return path
