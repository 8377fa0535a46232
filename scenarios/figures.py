"""Draw the time series of a run."""

from __future__ import annotations

from math import pi
from pathlib import Path

from matplotlib.figure import Figure

from scenarios.record import Record

_LABELS = {
    "z": "height [mm]",
    "g_force": "g-force",
    "yaw": "yaw [deg]",
    "tilt": "tilt [deg]",
    "springs": "springs",
    "facet_pairs": "facet pairs",
}
_SCALES = {"m": 1e3, "rad": 180.0 / pi}  # to mm and degrees


def draw_series(record: Record, folder: Path) -> list[Path]:
    """Draw height and g-force, yaw and tilt of every body, and the counts; return the PNG files."""
    folder.mkdir(parents=True, exist_ok=True)
    bodies = [name.removesuffix(".z") for name in record.columns if name.endswith(".z")]
    drawings = {"springs": ("springs and the facet pairs behind them", "springs", "facet_pairs")}
    for body in bodies:
        height = f"{body}: vertical position and g-force"
        drawings[f"{body}_height"] = (height, f"{body}.z", f"{body}.g_force")
        drawings[f"{body}_attitude"] = (f"{body}: yaw and tilt", f"{body}.yaw", f"{body}.tilt")
    return [_draw(record, folder / f"{name}.png", *what) for name, what in drawings.items()]


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
