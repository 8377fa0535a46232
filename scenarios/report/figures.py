"""Draw the time series of a run."""

from __future__ import annotations

from math import pi
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from scenarios.simulation.record import Record

_LABELS = {
    "z": "height [mm]",
    "g_force": "g-force",
    "yaw": "yaw [deg]",
    "tilt": "tilt [deg]",
    "springs": "springs",
    "facet_pairs": "facet pairs",
}
_LEDGER = ("elastic_energy", "damping_loss", "friction_loss", "step_loss")
MOST_BODIES = 6  # a hundred parts would make two hundred pictures
_SCALES = {"m": 1e3, "rad": 180.0 / pi}  # to mm and degrees


def draw_series(record: Record, folder: Path) -> list[Path]:
    """Draw the bodies that moved most, the counts and the energies; return the PNG files.

    Of a body: height and g-force, yaw and tilt.
    """
    folder.mkdir(parents=True, exist_ok=True)
    bodies = [name.removesuffix(".z") for name in record.columns if name.endswith(".z")]
    bodies = sorted(bodies, key=lambda body: _way(record, body), reverse=True)[:MOST_BODIES]
    drawings = {"springs": ("springs and the facet pairs behind them", "springs", "facet_pairs")}
    for body in bodies:
        height = f"{body}: vertical position and g-force"
        drawings[f"{body}_height"] = (height, f"{body}.z", f"{body}.g_force")
        drawings[f"{body}_attitude"] = (f"{body}: yaw and tilt", f"{body}.yaw", f"{body}.tilt")
    paths = [
        _draw(record, folder / f"{_file_name(name)}.png", *what) for name, what in drawings.items()
    ]
    return [*paths, _draw_energies(record, folder / "energy.png")]


def _way(record: Record, body: str) -> float:
    p = np.stack([record[f"{body}.{axis}"] for axis in "xyz"])
    return float(np.linalg.norm(np.diff(p, axis=1), axis=0).sum())


def _file_name(name: str) -> str:
    return name.replace("::", "-").replace("/", "-")


def _draw_energies(record: Record, path: Path) -> Path:
    """Draw the ledger: where the energy is and where it went; the sum should be a straight line."""
    time = record["time"]
    potential = record["gravitational_energy"] - record["gravitational_energy"].min()
    ledger = {"kinetic": record["kinetic_energy"], "gravitational, above the lowest": potential}
    ledger |= {name.replace("_", " "): record[name] for name in _LEDGER if name in record.columns}
    figure = Figure(figsize=(7.0, 4.4), layout="constrained")
    axes = figure.subplots()
    for label, energy in ledger.items():
        axes.plot(time, energy, linewidth=0.9, label=label)
    axes.plot(time, sum(ledger.values()), color="black", linewidth=1.4, label="sum")
    axes.set(xlabel="time [s]", ylabel="energy [J]")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    figure.suptitle("energy ledger")
    figure.savefig(path, dpi=120)
    return path


def _draw(record: Record, path: Path, title: str, *columns: str) -> Path:
    figure = Figure(figsize=(7.0, 4.4), layout="constrained")
    panels = figure.subplots(len(columns), 1, sharex=True, squeeze=False)[:, 0]
    for axes, column in zip(panels, columns, strict=True):
        if column in record.columns:  # a body without mass has no g-force
            scale = _SCALES.get(record.units[column], 1.0)
            axes.plot(record["time"], scale * record[column], linewidth=0.9)
        axes.set_ylabel(_LABELS[column.rpartition(".")[2]])
        axes.grid(alpha=0.3)
    panels[-1].set_xlabel("time [s]")
    figure.suptitle(title)
    figure.savefig(path, dpi=120)
    return path
