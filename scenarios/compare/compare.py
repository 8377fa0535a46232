"""Run one scenario under every engine there is: a table, a plot, a playback side by side."""

from __future__ import annotations

import importlib.util
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from pydrake.geometry import Meshcat, Rgba, TriangleSurfaceMesh
from rich.table import Table
from rich.text import Text

from scenarios.compare.drake_engines import builtin, ours
from scenarios.compare.outcome import Outcome
from scenarios.compare.placements import body_names, placements
from scenarios.format.models import surface_of
from scenarios.format.scenario import Scenario
from scenarios.report.provenance import commit, host, now, versions
from scenarios.run_folder import RunFolder
from scenarios.runner import unwatched_meshcat

Floats = NDArray[np.float64]
_FRAME_RATE = 32.0  # [1/s]
_CAPTION = "position: fixed; left: 1em; z-index: 1; font-family: sans-serif"


def engines() -> Mapping[str, Callable[[Scenario], Outcome]]:
    """Return the engines that are installed here, by name."""
    found: dict[str, Callable[[Scenario], Outcome]] = {
        "ours, implicit": lambda scenario: ours(scenario, implicit=True),
        "ours, continuous": lambda scenario: ours(scenario, implicit=False),
        "Drake point": lambda scenario: builtin(scenario, hydroelastic=False),
        "Drake hydroelastic": lambda scenario: builtin(scenario, hydroelastic=True),
    }
    if importlib.util.find_spec("mujoco") is not None:
        from scenarios.compare.mujoco_engine import mujoco_engine

        found["MuJoCo"] = mujoco_engine
    return found


def absent_engines() -> list[str]:
    """Return what would bring further engines, a line each."""
    if "MuJoCo" in engines():
        return []
    return ["MuJoCo is not installed: pip install 'contact-toolkit[compare]'"]


def compare(
    name: str,
    scenario: Scenario,
    folder: Path,
    *,
    replace: bool = False,
    only: Sequence[str] = (),
    begin: Callable[[str], None] = lambda _: None,
) -> tuple[list[Outcome], Path]:
    """Run it under every engine into `folder`: comparison.json, comparison.png, comparison.html.

    An engine that fails is an outcome with its error. `begin` is called with each engine's name.
    """
    target = RunFolder(folder, replace=replace)
    partial = target.open()
    try:
        outcomes = []
        for engine, simulate in engines().items():
            if only and engine not in only:
                continue
            begin(engine)
            try:
                outcomes.append(simulate(scenario))
            except Exception as error:  # noqa: BLE001  what an engine cannot do is a result
                said = str(error).splitlines()[0] if str(error) else type(error).__name__
                outcomes.append(Outcome(engine, verdict="cannot", error=said))
        from scenarios.format.loading import dump

        (partial / "scenario.yaml").write_text(dump(name, scenario), encoding="utf-8")
        _save(name, scenario, outcomes, partial / "comparison.json")
        draw_outcomes(name, scenario, outcomes, partial / "comparison.png")
        html = playback(scenario, outcomes)
        (partial / "comparison.html").write_text(html, encoding="utf-8")
        return outcomes, target.keep()
    finally:
        target.discard()


def comparison_table(name: str, scenario: Scenario, outcomes: Sequence[Outcome]) -> Table:
    """Return one column an engine: verdict, the figures judged, and what any run can be asked."""
    heads, rows = _rows(scenario, outcomes)
    table = Table(title=name, title_justify="left")
    for head in ("", *(row[0] for row in rows)):
        table.add_column(head)
    verdicts = (Text(row[1], "green" if row[1] == "passed" else "red") for row in rows)
    table.add_row(heads[1], *verdicts)
    for number, head in enumerate(heads[2:], start=2):
        table.add_row(Text(head), *(row[number] for row in rows))
    for outcome in outcomes:
        if outcome.error:
            table.caption = f"{table.caption or ''}{outcome.engine}: {outcome.error}\n"
    return table


def comparison_markdown(scenario: Scenario, outcomes: Sequence[Outcome]) -> str:
    """Return the rows of `comparison_table` for a document, and what the engines said."""
    heads, rows = _rows(scenario, outcomes)
    lines = [heads, ["---"] * len(heads), *rows]
    table = "\n".join(f"| {' | '.join(line)} |" for line in lines)
    said = "".join(
        f"\n{outcome.engine}: {outcome.error}.  " for outcome in outcomes if outcome.error
    )
    return f"Truth: {scenario.acceptance.truth}\n\n{table}\n{said}\n"


def _rows(scenario: Scenario, outcomes: Sequence[Outcome]) -> tuple[list[str], list[list[str]]]:
    acceptance = scenario.acceptance
    judged = [name for name in acceptance.limits if any(name in o.figures for o in outcomes)]
    rows, values = [], dict[str, str]()
    for outcome in outcomes:
        of_any = {
            "creep [µm/s]": outcome.creep(acceptance.window),
            "energy gained [J]": outcome.energy_gained(),
            "deepest overlap [mm]": 1e3 * outcome.penetration,
            "wall-clock [s]": outcome.wall_time if outcome.record is not None else np.nan,
            "× real time": outcome.real_time_factor,
        }
        values = {
            f"{name} ({acceptance.limits[name]})": f"{outcome.figures.get(name, np.nan):.5g}"
            for name in judged
        } | {name: f"{value:.2g}" for name, value in of_any.items() if name not in judged}
        cells = ["–" if value == "nan" else value for value in values.values()]
        rows.append([outcome.engine, outcome.verdict, *cells])
    return ["engine", "verdict", *values], rows


def draw_outcomes(name: str, scenario: Scenario, outcomes: Sequence[Outcome], path: Path) -> None:
    """Draw height, distance gone and speed of the body looked at, one line an engine."""
    body = scenario.acceptance.body or _most_telling_body(outcomes)
    figure = Figure(figsize=(7.5, 7.0), layout="constrained")
    panels = figure.subplots(3, 1, sharex=True)
    styles = ("-", "--", "-.", ":", (0, (1, 3)))
    for outcome, style in zip(outcomes, styles, strict=False):
        if outcome.record is None or f"{body}.z" not in outcome.record.columns:
            continue
        record = outcome.record
        p = np.stack([record[f"{body}.{axis}"] for axis in "xyz"])
        speed = np.linalg.norm([record[f"{body}.v{axis}"] for axis in "xyz"], axis=0)
        gone = np.linalg.norm(p - p[:, :1], axis=0)
        panels[0].plot(record["time"], 1e3 * p[2], linestyle=style, label=outcome.engine)
        panels[1].plot(record["time"], 1e3 * gone, linestyle=style)
        panels[2].semilogy(record["time"], np.maximum(speed, 1e-12), linestyle=style)
    for axes, label in zip(
        panels, ("height [mm]", "distance from the start [mm]", "speed [m/s]"), strict=True
    ):
        axes.set_ylabel(label)
        axes.grid(alpha=0.3)
    if panels[0].lines:
        panels[0].legend(fontsize=8)
    panels[2].set_xlabel("time [s]")
    figure.suptitle(f"{name}: {body}")
    figure.savefig(path, dpi=120)


def playback(scenario: Scenario, outcomes: Sequence[Outcome]) -> str:
    """Return a self-contained page with all engines' runs beside each other, along y."""
    meshcat = unwatched_meshcat()
    for scenery in ("/Grid", "/Axes"):
        meshcat.SetProperty(scenery, "visible", False)
    shown = [outcome for outcome in outcomes if outcome.poses]
    tracks = [X[:, :3, 3] for outcome in shown for X in outcome.poses.values()]
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
    away = 0.6 * gap * len(shown) + 0.3 * np.ptp(points[:, 2])
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


def _most_telling_body(outcomes: Sequence[Outcome]) -> str:
    """Return the body on which the engines agree least."""
    shown = [outcome.poses for outcome in outcomes if outcome.poses]
    if not shown:
        return ""

    def spread(name: str) -> float:
        ends = [poses[name][-1, :3, 3] for poses in shown if name in poses]
        return float(np.ptp(np.stack(ends), axis=0).max())

    return max(shown[0], key=spread)


def _save(name: str, scenario: Scenario, outcomes: Sequence[Outcome], path: Path) -> None:
    rows = [
        {
            "engine": outcome.engine,
            "verdict": outcome.verdict,
            "error": outcome.error,
            "wall_time": outcome.wall_time,
            "real_time_factor": _number(outcome.real_time_factor),
            "creep [um/s]": _number(outcome.creep(scenario.acceptance.window)),
            "energy gained [J]": _number(outcome.energy_gained()),
            "deepest overlap [mm]": _number(1e3 * outcome.penetration),
            "figures": {key: _number(value) for key, value in outcome.figures.items()},
        }
        for outcome in outcomes
    ]
    contents = {
        "scenario": name, "truth": scenario.acceptance.truth, "cannot": scenario.cannot,
        "engines": rows, "date": now(), "commit": commit(), "host": host(),
        "versions": versions(),
    }  # fmt: skip
    path.write_text(json.dumps(contents, indent=2) + "\n", encoding="utf-8")


def _number(value: float) -> float | None:
    return value if np.isfinite(value) else None
