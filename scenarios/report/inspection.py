"""Questions about meshes, for the terminal: closest points, defects, hierarchy, a picture."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection
from numpy.typing import ArrayLike
from rich.table import Table
from rich.text import Text
from scipy.spatial.transform import Rotation

from contact_toolkit import (
    CollisionMesh,
    MeshError,
    MeshSolid,
    distance,
    signed_distance,
    witness_pairs,
)
from scenarios.format.errors import ScenarioError
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


def open_mesh(file_or_part: str, scale: float = 1.0) -> CollisionMesh:
    """Return the mesh of a file, scaled to metres, or of a part in its default dimensions."""
    if file_or_part in PARTS:
        return CollisionMesh(*make_part(file_or_part))
    if not Path(file_or_part).suffix:
        raise ScenarioError(
            f"'{file_or_part}' is neither a mesh file nor one of {', '.join(PARTS)}"
        )
    return CollisionMesh.from_file(file_or_part, scale)


def distance_table(
    a: str,
    b: str,
    position: ArrayLike,
    rpy_degrees: ArrayLike,
    standoff: float | None,
    *,
    scale: float = 1.0,
) -> Table:
    """Return the closest points of two meshes, B at a position [m] and attitude in A.

    `scale` is that of mesh files. For overlapping bodies the depth is printed.
    """
    X_AB = np.eye(4)
    X_AB[:3, :3] = Rotation.from_euler("xyz", rpy_degrees, degrees=True).as_matrix()
    X_AB[:3, 3] = position
    mesh_a, mesh_b = open_mesh(a, scale), open_mesh(b, scale)
    try:
        pair = distance(mesh_a, mesh_b, X_AB)
        near = None if standoff is None else witness_pairs(mesh_a, mesh_b, X_AB, standoff)
        overlap = overlap_rows(mesh_a, mesh_b, X_AB, pair.distance)
    except ValueError as error:
        raise ScenarioError(str(error)) from error
    apart = "distance between the surfaces [m]" if overlap else "distance [m]"
    rows = {**overlap, apart: f"{pair.distance:.9g}"}
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


def overlap_rows(
    A: CollisionMesh, B: CollisionMesh, X_AB: np.ndarray, gap: float
) -> dict[str, str]:
    """Say how two bodies share space, if they do: one inside the other, or crossing; how deep.

    The depth is that of the deepest vertex of either mesh below the other's surface.
    """
    p_AB = B.vertices @ X_AB[:3, :3].T + X_AB[:3, 3]
    X_BA = np.linalg.inv(X_AB)
    p_BA = A.vertices @ X_BA[:3, :3].T + X_BA[:3, 3]
    depth = {
        name: signed_distance(mesh, points).distance if mesh.solid.has_inside else None
        for name, mesh, points in (("A", A, p_AB), ("B", B, p_BA))
    }
    within = 1e-9 * max(A.diagonal, B.diagonal) if gap == 0.0 else 0.0
    for outer, inner in (("A", "B"), ("B", "A")):
        below = depth[outer]
        if below is not None and below.max() <= within and below.min() < -within:
            how = "wholly" if gap > 0.0 else "touching it from within"
            return {
                "B in A": f"{inner} is inside {outer}, {how}",
                "deepest vertex [m]": f"{-below.min():.6g} below the surface of {outer}",
            }
    if gap > 0.0:
        return {}
    deepest = max((-below.min() for below in depth.values() if below is not None), default=0.0)
    if deepest <= 0.0 and any(below is None for below in depth.values()):
        return {"B in A": "the surfaces meet; how deep is unknown: a mesh is not closed"}
    kind = "A and B cross" if deepest > 0.0 else "A and B touch, or cross only by their edges"
    return {"B in A": kind, "deepest vertex [m]": f"{abs(max(deepest, 0.0)):.6g}"}


def parts_table() -> Table:
    """Return the parts that there are, and what they are."""
    table = Table("part", "what it is", box=None, pad_edge=False)
    for name, generator in PARTS.items():
        line = (inspect.getdoc(generator) or "").partition("\n")[0]
        table.add_row(Text(name, "bold"), Text(line.removeprefix("Return ")))
    return table


def part_table(name: str) -> Table:
    """Return the parameters of a part with their defaults, under what its docstring says."""
    if name not in PARTS:
        raise ScenarioError(f"no part is called '{name}'; there are: {', '.join(PARTS)}")
    vertices, faces = make_part(name)
    rows = {
        key: f"{parameter.default:.9g}"
        for key, parameter in inspect.signature(PARTS[name]).parameters.items()
    }
    rows["facets with these defaults"] = str(len(faces))
    size = vertices.max(axis=0) - vertices.min(axis=0)
    rows["size with these defaults [m]"] = _vector(size)
    table = _table(name, rows)
    table.caption = Text(inspect.getdoc(PARTS[name]) or "")
    table.caption_justify = "left"
    return table


def inspection_table(name: str, mesh: CollisionMesh) -> Table:
    """Return the size, defects and hierarchy of a mesh."""
    solid = mesh.solid
    rows = {
        "vertices": str(len(mesh.vertices)),
        "facets": str(len(mesh.faces)),
        "edges": str(len(mesh.edges)),
        "lower corner [m]": _vector(mesh.lower),
        "upper corner [m]": _vector(mesh.upper),
        "area [m²]": f"{mesh.area:.6g}",
        "volume [m³]": f"{solid.volume:.6g}" if solid.kind != "open" else "none, it is open",
        "defects": "\n".join(mesh.describe_defects()) or "none",
        "solid": _verdict(solid),
    }
    rows |= {
        f"hierarchy: {key.replace('_', ' ')}": f"{value:.4g}" if value % 1 else f"{value:.0f}"
        for key, value in mesh.hierarchy.items()
    }
    rows["hierarchy: bytes per facet"] = f"{mesh.hierarchy['bytes'] / len(mesh.faces):.0f}"
    return _table(name, rows)


def _verdict(solid: MeshSolid) -> str:
    """Say what contact makes of the mesh."""
    said = {
        "closed": "closed",
        "nearly closed": f"nearly closed: off by {solid.openness:.2g} of at most 0.05; next to the "
        "holes, inside is decided by the winding number",
        "open": f"open, without an inside: off by {solid.openness:.2g}, at most 0.05 would do; it "
        "can touch what is closed, and anything with a standoff",
        "inside out": "wound inside out, so taken to have no inside; reverse its facets",
    }[solid.kind]
    return said + (f"\n{solid.repairs}" if solid.repairs else "")


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
    ends = [(i, i | (1 << axis)) for i in range(8) for axis in range(3) if not i >> axis & 1]
    return np.asarray(boxes[:, ends].reshape(-1, 2, 3))


def _vector(values: np.ndarray) -> str:
    return " ".join(f"{value:.6g}" for value in values)
