"""Draw the web of proximity edges at moments of a run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection
from pydrake.systems.framework import Context

from scenarios.simulation.assembly import Assembly
from scenarios.simulation.record import Record


def moments(record: Record) -> dict[str, int]:
    """Return up to four samples that tell the story: before, at, in and after contact."""
    springs = record["springs"]
    touching = np.flatnonzero(springs)
    if not len(touching):
        return {"out of range": 0}
    deepest = touching[0] + int(np.argmax(springs[touching[0] :]))
    found = {"first lines": int(touching[0]), "a web": deepest, "at the end": len(springs) - 1}
    return {"out of range": 0, **found} if springs[0] == 0 else found


def draw_web(record: Record, assembly: Assembly, root: Context, folder: Path) -> Path:
    """Draw the lines between witness points, among the facets around them; return the PNG file."""
    folder.mkdir(parents=True, exist_ok=True)
    views = {title: _View(record, assembly, root, at) for title, at in moments(record).items()}
    points = np.concatenate([view.lines.reshape(-1, 3) for view in views.values()])
    if not len(points):
        points = np.concatenate([view.facets.reshape(-1, 3) for view in views.values()])
    margin = 0.4 * np.linalg.norm(np.ptp(points, axis=0))
    box = np.stack([points.min(axis=0) - margin, points.max(axis=0) + margin])
    figure = Figure(figsize=(4.6 * len(views), 4.8), layout="constrained")
    for panel, (title, view) in enumerate(views.items(), start=1):
        axes = figure.add_subplot(1, len(views), panel, projection="3d")
        axes.set_title(
            f"{title}: t = {view.time:.2f} s, {len(view.lines)} springs", fontsize=11, y=0.02
        )
        centre = view.facets.mean(axis=1)
        near = view.facets[np.all((centre > box[0]) & (centre < box[1]), axis=1)]
        style = {"facecolor": (0.5, 0.6, 0.7, 0.03), "edgecolor": (0.3, 0.35, 0.4, 0.12)}
        axes.add_collection3d(Poly3DCollection(1e3 * near, linewidth=0.15, **style))
        if len(view.lines):  # matplotlib fails on collections of nothing
            axes.add_collection3d(
                Line3DCollection(1e3 * view.lines, colors="crimson", linewidths=0.8)
            )
        axes.set(xlim=1e3 * box[:, 0], ylim=1e3 * box[:, 1], zlim=1e3 * box[:, 2])
        axes.set(xlabel="x [mm]", ylabel="y [mm]", zlabel="z [mm]")
        axes.locator_params(nbins=4)
        axes.tick_params(labelsize=7, pad=0)
        axes.set_box_aspect(np.maximum(box[1] - box[0], 0.05 * np.ptp(box)), zoom=0.85)
        axes.view_init(elev=25.0, azim=-60.0)
    path = folder / "web.png"
    figure.savefig(path, dpi=100)
    return path


class _View:
    """The facets (n, 3, 3) of all bodies in contact and the lines (m, 2, 3) at one sample, in W."""

    def __init__(self, record: Record, assembly: Assembly, root: Context, sample: int) -> None:
        context = assembly.diagram.CreateDefaultContext()
        plant, contact = assembly.plant, assembly.contact
        state = assembly.logs["state"].FindLog(root).data()[:, sample]
        plant_context = plant.GetMyMutableContextFromRoot(context)
        plant.SetPositionsAndVelocities(plant_context, state)
        port = contact.get_contacts_output_port()
        contacts = port.Eval(contact.GetMyContextFromRoot(context))
        self.time = record["time"][sample]
        self.lines = np.stack([contacts.p_FCa, contacts.p_FCb], axis=1)
        surfaces = []
        model = contact.model
        for geometry, row in zip(model.geometries, model.geometry_bodies, strict=True):
            body = plant.get_body(contact.bodies[row])
            X_WG = plant.EvalBodyPoseInWorld(plant_context, body).GetAsMatrix4() @ geometry.X_BG
            vertices = geometry.mesh.vertices @ X_WG[:3, :3].T + X_WG[:3, 3]
            surfaces.append(vertices[geometry.mesh.faces])
        self.facets = np.concatenate(surfaces)
