"""A fit from the terminal: progress, table, and a picture of what was measured and what fits."""

from __future__ import annotations

import json
import math
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


def fit_with_progress(console: Console, file: Path, out: Path | None) -> tuple[Fit, list[Path]]:
    """Fit what a file says and print the table; return it, and the files written to `out`."""
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
    for key in found.undetermined:
        widest = found.estimates[key].widest
        said = f"not determined: {key}, its interval is wider than {widest:.3g}"
        console.print(Text(f"{said}; fix it, or measure what depends on it"), soft_wrap=True)
    if out is None:
        return found, []
    out.mkdir(parents=True, exist_ok=True)
    return found, [_save(found, out / "fit.json"), _draw(found, samples, out / "fit.png")]


def _save(found: Fit, path: Path) -> Path:
    estimates = {
        name: {key: number if math.isfinite(number) else None for key, number in asdict(e).items()}
        | {"determined": e.determined}
        for name, e in found.estimates.items()
    }
    said = {
        "estimates": estimates,
        "residuals": found.residuals.tolist(),
        "evaluations": found.evaluations,
        "converged": found.converged,
        "not_determined": found.undetermined,
        "confidence": CONFIDENCE,
    }
    path.write_text(json.dumps(said, indent=1, allow_nan=False) + "\n", encoding="utf-8")
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
