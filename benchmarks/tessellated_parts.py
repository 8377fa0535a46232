"""Parts as a CAD kernel tessellates them: Open CASCADE, whose meshes many exporters write.

Its triangulations are what the project's own generators never make: fans about a corner, slivers
along fillets and holes, a few facets on a plane beside thousands on a thread.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
from OCP.BRepBuilderAPI import (
    BRepBuilderAPI_MakeEdge,
    BRepBuilderAPI_MakeFace,
    BRepBuilderAPI_MakePolygon,
    BRepBuilderAPI_MakeWire,
)
from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
from OCP.BRepLib import BRepLib
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.BRepOffsetAPI import BRepOffsetAPI_ThruSections
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder, BRepPrimAPI_MakePrism
from OCP.Geom import Geom_CylindricalSurface
from OCP.Geom2d import Geom2d_Ellipse, Geom2d_Line, Geom2d_TrimmedCurve
from OCP.gp import gp_Ax2, gp_Ax2d, gp_Ax3, gp_Dir, gp_Dir2d, gp_Pnt, gp_Pnt2d, gp_Vec
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE, TopAbs_REVERSED
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Shape

from scenarios.parts import Surface

_DEFLECTION = 5e-5  # [m] of the triangles from the surface
_TURN = 0.2  # [rad] between neighbouring triangles
_UP = gp_Dir(0.0, 0.0, 1.0)
_Triple = tuple[float, float, float]


def tessellated_parts(coarser: int = 1) -> list[tuple[str, Surface]]:
    """Return the parts by name; `coarser` multiplies what triangles may stray."""
    parts = {"bracket": _bracket(), "hub gear": _gear(), "bolt": _bolt(), "mould": _mould()}
    return [(name, _surface(shape, coarser)) for name, shape in parts.items()]


def _surface(shape: TopoDS_Shape, coarser: int) -> Surface:
    """Tessellate; the triangles of all faces, each by its own nodes."""
    BRepMesh_IncrementalMesh(shape, _DEFLECTION * coarser, False, min(1.0, _TURN * coarser), False)
    points: list[_Triple] = []
    triangles: list[Sequence[int]] = []
    for found in _faces(shape):
        location = TopLoc_Location()
        mesh = BRep_Tool.Triangulation_s(found, location)
        first = len(points) - 1  # its nodes count from 1
        for node in range(1, mesh.NbNodes() + 1):
            p = mesh.Node(node).Transformed(location.Transformation())
            points.append((p.X(), p.Y(), p.Z()))
        for index in range(1, mesh.NbTriangles() + 1):
            a, b, c = (first + mesh.Triangle(index).Value(k) for k in (1, 2, 3))
            triangles.append((a, c, b) if found.Orientation() == TopAbs_REVERSED else (a, b, c))
    return np.array(points), np.array(triangles, dtype=np.int32)


def _faces(shape: TopoDS_Shape) -> Iterator[TopoDS_Shape]:
    explorer = TopExp_Explorer(shape, TopAbs_FACE)
    while explorer.More():
        yield TopoDS.Face(explorer.Current())
        explorer.Next()


def _box(corner: _Triple, sides: _Triple) -> TopoDS_Shape:
    return BRepPrimAPI_MakeBox(gp_Pnt(*corner), *sides).Shape()


def _cylinder(centre: _Triple, radius: float, height: float, along: gp_Dir = _UP) -> TopoDS_Shape:
    return BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(*centre), along), radius, height).Shape()


def _joined(shape: TopoDS_Shape, *others: TopoDS_Shape) -> TopoDS_Shape:
    for other in others:
        shape = BRepAlgoAPI_Fuse(shape, other).Shape()
    return shape


def _cut(shape: TopoDS_Shape, *others: TopoDS_Shape) -> TopoDS_Shape:
    for other in others:
        shape = BRepAlgoAPI_Cut(shape, other).Shape()
    return shape


def _filleted(shape: TopoDS_Shape, radius: float) -> TopoDS_Shape:
    """Round all edges."""
    fillet = BRepFilletAPI_MakeFillet(shape)
    explorer = TopExp_Explorer(shape, TopAbs_EDGE)
    while explorer.More():
        fillet.Add(radius, TopoDS.Edge(explorer.Current()))
        explorer.Next()
    return fillet.Shape()


def _bracket() -> TopoDS_Shape:
    """An angle of 8 mm plates, rounded all over, with six holes."""
    angle = _joined(_box((0, 0, 0), (0.08, 0.05, 0.008)), _box((0, 0, 0), (0.008, 0.05, 0.06)))
    body = _filleted(angle, 0.002)
    ways = [(0.03 + 0.018 * k, 0.012 + 0.026 * side) for k in range(2) for side in range(2)]
    upright = gp_Dir(1.0, 0.0, 0.0)
    return _cut(
        body,
        *(_cylinder((x, y, -0.01), 0.004, 0.03) for x, y in ways),
        *(_cylinder((-0.01, y, 0.04), 0.005, 0.03, upright) for y in (0.013, 0.037)),
    )


def _gear() -> TopoDS_Shape:
    """24 teeth with rounded flanks, a hub, a bore, and six holes in the web."""
    teeth, root, tip = 24, 0.0215, 0.026
    outline = BRepBuilderAPI_MakePolygon()
    profile = [(-0.46, root), (-0.30, root), (-0.24, 0.4 * root + 0.6 * tip), (-0.12, tip)]
    for tooth in range(teeth):
        for share, radius in profile + [(-share, radius) for share, radius in profile[::-1]]:
            angle = 2 * math.pi * (tooth + share) / teeth
            outline.Add(gp_Pnt(radius * math.cos(angle), radius * math.sin(angle), 0.0))
    outline.Close()
    face = BRepBuilderAPI_MakeFace(outline.Wire()).Face()
    blank = BRepPrimAPI_MakePrism(face, gp_Vec(0.0, 0.0, 0.01)).Shape()
    body = _joined(blank, _cylinder((0, 0, 0), 0.009, 0.018))
    holes = [
        (0.0145 * math.cos(k * math.pi / 3), 0.0145 * math.sin(k * math.pi / 3)) for k in range(6)
    ]
    return _cut(
        body,
        _cylinder((0, 0, -0.01), 0.005, 0.04),
        *(_cylinder((x, y, -0.01), 0.003, 0.03) for x, y in holes),
    )


def _bolt() -> TopoDS_Shape:
    """A shank with a ridge wound around it like a thread, under a hexagonal head."""
    radius, pitch, turns, length = 0.008, 0.002, 8, 0.03
    head = BRepBuilderAPI_MakePolygon()
    for corner in range(6):
        angle = corner * math.pi / 3
        head.Add(gp_Pnt(0.0139 * math.cos(angle), 0.0139 * math.sin(angle), length))
    head.Close()
    face = BRepBuilderAPI_MakeFace(head.Wire()).Face()
    blank = BRepPrimAPI_MakePrism(face, gp_Vec(0.0, 0.0, 0.01)).Shape()
    body = _joined(blank, _cylinder((0, 0, 0), radius, length))
    return _joined(body, _ridge(radius, pitch, turns))


def _ridge(radius: float, pitch: float, turns: int) -> TopoDS_Shape:
    """Two ellipses, drawn on unrolled cylinders, between whose wound-up arcs the ridge lies."""
    around, rise = 2 * math.pi * turns, pitch * turns
    half = 0.5 * math.hypot(around, rise)
    axis = gp_Ax2d(gp_Pnt2d(0.5 * around, 0.5 * rise + pitch), gp_Dir2d(around, rise))
    sections = BRepOffsetAPI_ThruSections(True)
    for surface_radius, height in ((0.99 * radius, 0.4 * pitch), (1.08 * radius, 0.1 * pitch)):
        surface = Geom_CylindricalSurface(gp_Ax3(gp_Pnt(0, 0, 0), _UP), surface_radius)
        ellipse = Geom2d_Ellipse(axis, half, height)
        arc = Geom2d_TrimmedCurve(ellipse, 0.0, math.pi)
        start = ellipse.Value(0.0)
        back = Geom2d_Line(start, gp_Dir2d(-around, -rise))
        chord = Geom2d_TrimmedCurve(back, 0.0, 2 * half)
        edges = (BRepBuilderAPI_MakeEdge(curve, surface).Edge() for curve in (arc, chord))
        wire = BRepBuilderAPI_MakeWire(*edges).Wire()
        BRepLib.BuildCurves3d_s(wire)
        sections.AddWire(wire)
    sections.CheckCompatibility(False)
    return sections.Shape()


def _mould() -> TopoDS_Shape:
    """A rounded tray with a rib in every direction and bosses between them."""
    block = _filleted(_box((0, 0, 0), (0.1, 0.07, 0.025)), 0.004)
    cavity = _filleted(_box((0.006, 0.006, 0.005), (0.088, 0.058, 0.04)), 0.003)
    ribs = [_box((0.005, 0.012 + 0.0115 * k, 0.004), (0.09, 0.0015, 0.012)) for k in range(5)]
    ribs += [_box((0.018 + 0.0155 * k, 0.005, 0.004), (0.0015, 0.06, 0.009)) for k in range(5)]
    spots = [(0.0265 + 0.0155 * k, 0.0185 + 0.023 * row) for k in range(4) for row in range(2)]
    bosses = [_cylinder((x, y, 0.004), 0.003, 0.014) for x, y in spots]
    tray = _joined(_cut(block, cavity), *ribs, *bosses)
    return _cut(tray, *(_cylinder((x, y, 0.008), 0.0015, 0.02) for x, y in spots))
