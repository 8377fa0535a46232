"""A fit from the terminal: progress, table, and a picture of what was measured and what fits."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from rich.console import Console
from rich.table import Table
from rich.text import Text

from scenarios.sweep.fit import CONFIDENCE, Fit
from scenarios.sweep.fit_file import Samples, fit_rollouts, load_fit


def fit_with_progress(console: Console, file: Path, out: Path | None) -> list[Path]:
    """Fit what a file says, print the table, and return the files written to `out`, if any."""
    name, wanted, base, samples = load_fit(file)
    with console.status(f"{name}: first rollout") as status:

        def tell(values: Mapping[str, float], deviation: float) -> None:
            said = ", ".join(f"{key} = {value:.5g}" for key, value in values.items())
            status.update(f"{name}: {said}; off by {deviation:.3g} rms")

        found = fit_rollouts(wanted, base, samples, tell)
    table = Table(
        "parameter", "value", f"{100 * CONFIDENCE:.0f} % interval", "start", title=name, box=None
    )
    for key, e in found.estimates.items():
        interval = f"{e.lower:.5g} to {e.upper:.5g}"
        start = f"{wanted.parameters[key].start:.5g}"
        table.add_row(Text(key), f"{e.value:.5g}", interval, start)
    console.print(table)
    rms = float(np.sqrt(np.mean(found.residuals**2)))
    console.print(f"off by {rms:.3g} rms; {found.evaluations} rollouts")
    if not found.converged:
        console.print("the search was cut short: begin closer, or loosen the bounds")
    if out is None:
        return []
    out.mkdir(parents=True, exist_ok=True)
    return [_save(found, out / "fit.json"), _draw(found, samples, out / "fit.png")]


def _save(found: Fit, path: Path) -> Path:
    said = asdict(found) | {"residuals": found.residuals.tolist(), "confidence": CONFIDENCE}
    path.write_text(json.dumps(said, indent=1) + "\n", encoding="utf-8")
    return path


def _draw(found: Fit, samples: list[Samples], path: Path) -> Path:
    figure = Figure(figsize=(7.0, 3.0 * len(samples)), layout="constrained")
    panels = figure.subplots(len(samples), 1, squeeze=False)[:, 0]
    ends = np.cumsum([len(s.values) for s in samples])[:-1]
    for axes, s, off in zip(panels, samples, np.split(found.residuals, ends), strict=True):
        axes.plot(s.time, s.values, ".", markersize=4, label="measured")
        axes.plot(s.time, s.values + off, linewidth=1.0, label="fitted")
        axes.set(xlabel="time [s]", ylabel=s.column)
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8)
    figure.savefig(path, dpi=120)
    return path
