"""What the engines made of a scenario: a figure, and a playback side by side."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image
from pydrake.geometry import Meshcat, Rgba, TriangleSurfaceMesh

from scenarios.compare.outcome import Outcome
from scenarios.compare.placements import body_names, placements
from scenarios.format.models import surface_of
from scenarios.format.scenario import Scenario
from scenarios.judge.expressions import columns_in
from scenarios.judge.verdicts import PASSED
from scenarios.runner import unwatched_meshcat

Floats = NDArray[np.float64]
_FRAME_RATE = 32.0  # [1/s]
_COLOURS = 64  # lines need no more, and a document keeps its pictures
_LEAST_REACH = 5.0  # [mm] above and below
_STYLES = ("-", "--", "-.", ":", (0, (6, 2, 1, 2, 1, 2)))
_CAPTION = "position: fixed; left: 1em; z-index: 1; font-family: sans-serif"


def draw_outcomes(name: str, scenario: Scenario, outcomes: Sequence[Outcome], path: Path) -> None:
    """Draw height, distance gone and speed of the body looked at, one line an engine."""
    body = _most_telling_body(scenario, outcomes)
    figure = Figure(figsize=(9.5, 3.2), layout="constrained")
    panels = dict(
        zip(("height [mm]", "gone [mm]", "speed [m/s]"), figure.subplots(1, 3), strict=True)
    )
    for number, outcome in enumerate(outcomes):
        if outcome.record is None or f"{body}.z" not in outcome.record.columns:
            continue
        record = outcome.record
        p, v = (np.stack([record[f"{body}.{c}{axis}"] for axis in "xyz"]) for c in ("", "v"))
        gone = np.linalg.norm(p - p[:, :1], axis=0)
        lines = (1e3 * p[2], 1e3 * gone, np.linalg.norm(v, axis=0))
        for axes, line, least in zip(panels.values(), lines, (-np.inf, 1e-9, 1e-12), strict=True):
            seen = np.where(line > least, line, np.nan)  # what has not moved has no logarithm
            axes.plot(record["time"], seen, label=outcome.engine, color=f"C{number}",
                      linestyle=_STYLES[number % len(_STYLES)], linewidth=1.2)  # fmt: skip
    if heights := [1e3 * o.record[f"{body}.z"] for o in _right(outcomes) if o.record is not None]:
        low, high = float(np.min(heights)), float(np.max(heights))
        reach, axes = max(high - low, _LEAST_REACH), panels["height [mm]"]
        shown = axes.get_ylim()  # but not of what falls for ever
        axes.set_ylim(max(low - reach, shown[0]), min(high + reach, shown[1]))
    for label, axes in panels.items():
        axes.set(xlabel="time [s]", ylabel=label, yscale="linear" if "height" in label else "log")
        axes.grid(alpha=0.3)
    handles, labels = panels["speed [m/s]"].get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="outside lower center", ncols=len(handles), fontsize=8)
    figure.suptitle(f"{name}: {body}", fontsize=10)
    drawn = BytesIO()
    figure.savefig(drawn, dpi=90)
    Image.open(drawn).convert("RGB").quantize(_COLOURS).save(path, optimize=True)


def _right(outcomes: Sequence[Outcome]) -> list[Outcome]:
    """Return those that passed, if any: by their motion a picture is framed."""
    shown = [outcome for outcome in outcomes if outcome.poses]
    return [outcome for outcome in shown if outcome.verdict == PASSED] or shown


def playback(scenario: Scenario, outcomes: Sequence[Outcome]) -> str:
    """Return a self-contained page with all engines' runs beside each other, along y."""
    meshcat = unwatched_meshcat()
    for scenery in ("/Grid", "/Axes"):
        meshcat.SetProperty(scenery, "visible", False)
    shown = [outcome for outcome in outcomes if outcome.poses]
    tracks = [X[:, :3, 3] for outcome in _right(outcomes) for X in outcome.poses.values()]
    if not tracks:
        return str(meshcat.StaticHtml())
    placed = placements(scenario)
    called = body_names(placed)
    of_parts = {name: surface_of(part) for name, part in scenario.parts.items()}
    surfaces = {called[model]: of_parts[placed[model].part] for model in placed}
    starts = {called[model]: placed[model].X_WB for model in placed}
    colours = {called[model]: scenario.parts[placed[model].part].rgba for model in placed}
    points = np.concatenate(tracks)
    sizes = {name: float(np.ptp(v, axis=0).max()) for name, (v, _) in surfaces.items()}
    moving = [name for name in surfaces if any(name in o.poses for o in shown)]
    width = np.ptp(np.percentile(points, [5, 95], axis=0)[:, 1])
    gap = 1.6 * (width + max((sizes[name] for name in moving), default=0.1))
    meshcat.StartRecording(_FRAME_RATE)
    recording = meshcat.get_mutable_recording()
    for column, outcome in enumerate(shown):
        assert outcome.record is not None
        time = outcome.record["time"]
        frames = np.arange(0.0, time[-1], 1.0 / _FRAME_RATE)
        for name, (vertices, faces) in surfaces.items():
            path = f"{outcome.engine}/{name}"
            _show(meshcat, path, vertices, faces, colours[name])
            X = outcome.poses.get(name)
            if X is None:
                X = np.broadcast_to(starts[name], (len(time), 4, 4))
            for frame, moment in enumerate(frames):
                at = X[min(int(np.searchsorted(time, moment)), len(time) - 1)].copy()
                at[1, 3] += gap * column
                recording.SetTransform(frame, path, _rigid(at))
    meshcat.StopRecording()
    meshcat.PublishRecording()
    centre = np.median(points, axis=0) + np.array([0.0, gap * (len(shown) - 1) / 2, 0.0])
    away = 0.5 * gap * len(shown) + 0.3 * np.ptp(points[:, 2])
    meshcat.SetCameraPose(centre + away * np.array([0.85, -0.1, 0.45]), centre)
    names = "; ".join(f"{outcome.engine} ({outcome.verdict})" for outcome in shown)
    caption = f'<p style="{_CAPTION}">From left to right: {names}</p>'
    return str(meshcat.StaticHtml()).replace("<body>", f"<body>{caption}", 1)


def _show(
    meshcat: Meshcat, path: str, vertices: Floats, faces: NDArray[np.int32], rgba: list[float]
) -> None:
    from pydrake.geometry import SurfaceTriangle

    mesh = TriangleSurfaceMesh(
        triangles=[SurfaceTriangle(*map(int, face)) for face in faces], vertices=list(vertices)
    )
    meshcat.SetObject(path, mesh, Rgba(*rgba))


def _rigid(X: Floats):  # type: ignore[no-untyped-def]
    from pydrake.math import RigidTransform, RotationMatrix

    return RigidTransform(RotationMatrix.ProjectToRotationMatrix(X[:3, :3]), X[:3, 3])


def _most_telling_body(scenario: Scenario, outcomes: Sequence[Outcome]) -> str:
    """Return the body looked at: of those that figures are of, on which the engines agree least."""
    acceptance = scenario.acceptance
    shown = [outcome.poses for outcome in outcomes if outcome.poses]
    if acceptance.body or not shown:
        return acceptance.body
    read = {
        column.rpartition(".")[0]
        for figure in acceptance.figures.values()
        for column in columns_in(figure)
    }

    def disagreement(name: str) -> float:
        moves = [np.linalg.norm(poses[name][-1, :3, 3] - poses[name][0, :3, 3]) for poses in shown]
        return float(max(moves) / (min(moves) + 1e-12))

    common = [name for name in shown[0] if all(name in poses for poses in shown)]
    return max([name for name in common if name in read] or common, key=disagreement, default="")
