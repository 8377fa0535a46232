"""Questions about meshes, for the terminal: closest points, defects, hierarchy, a picture."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection
from numpy.typing import ArrayLike
from rich.table import Table
from rich.text import Text
from scipy.spatial.transform import Rotation

from contact_toolkit import CollisionMesh, MeshError, distance, witness_pairs
from scenarios.errors import ScenarioError
from scenarios.parts import PARTS, make_part

_KINDS = ("vertex", "edge", "facet")
_DEFECT_COLOURS = {
    "open_edges": "red",
    "non_manifold_edges": "magenta",
    "inconsistent_edges": "orange",
    "zero_area_facets": "green",
    "duplicate_facets": "blue",
}
_MOST_FACETS_DRAWN = 200_000  # matplotlib takes seconds beyond


def open_mesh(file_or_part: str) -> CollisionMesh:
    """Return the mesh of a file, or of a part in its default dimensions."""
    if file_or_part in PARTS:
        return CollisionMesh(*make_part(file_or_part))
    if not Path(file_or_part).suffix:
        raise ScenarioError(
            f"'{file_or_part}' is neither a mesh file nor one of {', '.join(PARTS)}"
        )
    return CollisionMesh.from_file(file_or_part)


def distance_table(
    a: str, b: str, position: ArrayLike, rpy_degrees: ArrayLike, standoff: float | None
) -> Table:
    """Return the closest points of two meshes, B at a position [m] and attitude in A."""
    X_AB = np.eye(4)
    X_AB[:3, :3] = Rotation.from_euler("xyz", rpy_degrees, degrees=True).as_matrix()
    X_AB[:3, 3] = position
    mesh_a, mesh_b = open_mesh(a), open_mesh(b)
    try:
        pair = distance(mesh_a, mesh_b, X_AB)
        near = None if standoff is None else witness_pairs(mesh_a, mesh_b, X_AB, standoff)
    except ValueError as error:
        raise ScenarioError(str(error)) from error
    rows = {"distance [m]": f"{pair.distance:.9g}"}
    for name, point, feature, facet in (
        ("A", pair.p_ACa, pair.feature_a, pair.facet_a),
        ("B", pair.p_ACb, pair.feature_b, pair.facet_b),
    ):
        where = f"{_KINDS[feature[0]]} {feature[1]}, facet {facet}"
        rows[f"witness point on {name}, in A [m]"] = f"{_vector(point)} ({where})"
    if near is not None:
        rows[f"facet pairs within {standoff:g} m"] = str(near.multiplicity.sum())
        rows["witness pairs, merged"] = str(len(near))
    return _table(f"{a} (A) and {b} (B)", rows)


def inspection_table(name: str, mesh: CollisionMesh) -> Table:
    """Return the size, defects and hierarchy of a mesh."""
    rows = {
        "vertices": str(len(mesh.vertices)),
        "facets": str(len(mesh.faces)),
        "edges": str(len(mesh.edges)),
        "lower corner [m]": _vector(mesh.lower),
        "upper corner [m]": _vector(mesh.upper),
        "area [m²]": f"{mesh.area:.6g}",
        "volume [m³]": f"{mesh.volume:.6g}" if mesh.defects.closed else "none, it is not closed",
        "defects": str(mesh.defects),
    }
    rows |= {
        f"hierarchy: {key.replace('_', ' ')}": f"{value:.4g}" if value % 1 else f"{value:.0f}"
        for key, value in mesh.hierarchy.items()
    }
    rows["hierarchy: bytes per facet"] = f"{mesh.hierarchy['bytes'] / len(mesh.faces):.0f}"
    return _table(name, rows)


def draw_mesh(mesh: CollisionMesh, path: Path) -> Path:
    """Draw the facets, the boxes two levels below the hierarchy's root, and defects in colour."""
    if len(mesh.faces) > _MOST_FACETS_DRAWN:
        raise MeshError(f"{len(mesh.faces)} facets are too many to draw; simplify the mesh")
    figure = Figure(figsize=(7.0, 7.0), layout="constrained")
    axes = figure.add_subplot(projection="3d")
    facets = mesh.vertices[mesh.faces]
    shade = 0.55 + 0.35 * mesh.face_normals @ np.array([0.3, -0.5, 0.8])
    colours = np.clip(shade[:, None], 0.2, 0.95) * [0.75, 0.85, 1.0]
    axes.add_collection3d(
        Poly3DCollection(facets, facecolors=colours, edgecolors=0.8 * colours, linewidths=0.1)
    )
    boxes = mesh.hierarchy_boxes(min(1, int(mesh.hierarchy["depth"]) - 1))
    lines = {"hierarchy, two levels down": (_box_edges(boxes), "0.4", 0.4)}
    for name, colour in _DEFECT_COLOURS.items():
        found = getattr(mesh.defects, name)
        edges = np.unique(mesh.face_edges[found]) if name.endswith("facets") else found
        label = f"{len(found)} {name.replace('_', ' ')}"
        lines[label] = (mesh.vertices[mesh.edges[edges]], colour, 2.0)
    for label, (segments, colour, width) in lines.items():
        if len(segments):  # matplotlib fails on collections of nothing
            axes.add_collection3d(
                Line3DCollection(segments, colors=colour, linewidths=width, label=label)
            )
    limits = np.stack([mesh.lower, mesh.upper])
    axes.set(xlim=limits[:, 0], ylim=limits[:, 1], zlim=limits[:, 2])
    axes.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")
    axes.locator_params(nbins=5)
    axes.set_box_aspect(np.maximum(limits[1] - limits[0], 0.01 * mesh.diagonal), zoom=0.9)
    axes.legend(loc="upper left")
    try:
        figure.savefig(path, dpi=130)
    except ValueError as error:  # a suffix that matplotlib does not write
        raise ScenarioError(f"{path}: {error}") from error
    return path


def _table(title: str, rows: Mapping[str, str]) -> Table:
    table = Table(box=None, pad_edge=False, show_header=False, title=title, title_justify="left")
    for key, value in rows.items():
        table.add_row(Text(key), Text(value))
    return table


def _box_edges(boxes: np.ndarray) -> np.ndarray:
    corner = np.array([[(i >> axis) & 1 for axis in range(3)] for i in range(8)])
    ends = [(i, i | (1 << axis)) for i in range(8) for axis in range(3) if not i >> axis & 1]
    points = np.where(corner[None], boxes[:, None, 1], boxes[:, None, 0])
    return np.asarray(points[:, ends].reshape(-1, 2, 3))


def _vector(values: np.ndarray) -> str:
    return " ".join(f"{value:.6g}" for value in values)
