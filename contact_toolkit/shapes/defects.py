"""What is wrong with a mesh, and what a query makes of it all the same."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]

SolidKind = Literal["closed", "nearly closed", "open", "inside out"]


@dataclass(frozen=True)
class MeshDefects:
    """What is wrong with a mesh but tolerated; each field but the last is an array of indices.

    Attributes
    ----------
    open_edges, non_manifold_edges, inconsistent_edges
        Into `CollisionMesh.edges`: edges of one facet (the boundary of an open surface), of three
        or more, and of two facets whose windings disagree.
    zero_area_facets, duplicate_facets
        Into `CollisionMesh.faces`; a duplicate has the three vertices of an earlier facet.
    unused_vertices
        Into `CollisionMesh.vertices`: vertices that no facet touches; no query sees them.
    inside_out
        Whether the surface is closed and its facets face inwards: its volume is negative.
    """

    open_edges: Ints
    non_manifold_edges: Ints
    inconsistent_edges: Ints
    zero_area_facets: Ints
    duplicate_facets: Ints
    unused_vertices: Ints
    inside_out: bool = False

    @property
    def closed(self) -> bool:
        """Whether every edge joins two facets that agree which side is out.

        What is not closed in this sense may bound a solid all the same: see `CollisionMesh.solid`.
        """
        return not (
            self.open_edges.size or self.non_manifold_edges.size or self.inconsistent_edges.size
        )

    def counts(self) -> dict[str, int]:
        """Return how many there are of each kind of which there are any."""
        sizes = {name: np.size(value) for name, value in vars(self).items() if name != "inside_out"}
        return {name.replace("_", " "): size for name, size in sizes.items() if size}

    def __str__(self) -> str:
        found = [f"{count} {name}" for name, count in self.counts().items()]
        return ", ".join(found + ["wound inside out"] * self.inside_out) or "none"


@dataclass(frozen=True)
class MeshSolid:
    """The solid that a mesh bounds, as contact and `signed_distance` take it.

    What is doubled, turned or stray is set right for this, on a copy: the mesh keeps its facets.

    Attributes
    ----------
    kind
        "closed"; "nearly closed": with holes or cracks that hardly show from most of the surface,
        where the generalized winding number tells inside from outside; "open": without an inside;
        "inside out": closed, but facing inwards, so it is taken to have no inside.
    volume
        [m³]; of a nearly closed one as if its holes were closed from the box's centre. What
        overlapping parts share counts for each.
    openness
        How far, on average over the surface, the winding number next to it is off that of a closed
        one [-]: 0 closed, 0.1 a box without its lid, 0.5 a flat sheet. Nearly closed: up to 0.05.
    turned_facets, duplicate_facets, collapsed_facets, inner_facets
        Into `CollisionMesh.faces`: what is taken the other way round; what is left out because it
        is there already, because it has no width and closes nothing, or because the solid is on
        both its sides.
    """

    kind: SolidKind
    volume: float
    openness: float
    turned_facets: Ints
    duplicate_facets: Ints
    collapsed_facets: Ints
    inner_facets: Ints

    @property
    def has_inside(self) -> bool:
        """Whether a point can be inside it."""
        return self.kind in ("closed", "nearly closed")

    @property
    def repairs(self) -> str:
        """What has been set right, in words; empty if nothing."""
        listed = {
            "turned round": self.turned_facets,
            "left out as duplicates": self.duplicate_facets,
            "left out without width": self.collapsed_facets,
            "left out within the solid": self.inner_facets,
        }
        return ", ".join(
            f"{len(facets)} facet{'s' * (len(facets) > 1)} {what} (first: facet {facets[0]})"
            for what, facets in listed.items()
            if len(facets)
        )


def describe_defects(
    defects: MeshDefects, vertices: Floats, edges: Ints, face_edges: Ints, volume: float
) -> list[str]:
    """Say of each kind of defect how many there are and where the first is."""

    def place(point: Floats) -> str:
        return f"({point[0]:.4g}, {point[1]:.4g}, {point[2]:.4g}) m"

    said = []
    for kind, count in defects.counts().items():
        first = int(getattr(defects, kind.replace(" ", "_"))[0])
        name = kind if count > 1 else kind[:-1].removesuffix("ice") + "ex" * kind.endswith("ices")
        if kind.endswith("edges"):
            facet = int(np.argmax((face_edges == first).any(axis=1)))
            where = f"facet {facet}, at {place(vertices[edges[first]].mean(axis=0))}"
        elif kind.endswith("facets"):
            corners = np.unique(edges[face_edges[first]])
            where = f"facet {first}, at {place(vertices[corners].mean(axis=0))}"
        else:
            where = f"vertex {first}, at {place(vertices[first])}"
        said.append(f"{count} {name}, the first {'of ' * kind.endswith('edges')}{where}")
    if defects.inside_out:
        said.append(f"wound inside out: its volume is {volume:.3g} m³")
    return said
