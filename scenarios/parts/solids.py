"""Plain solids: box, doughnut, cone, cylinder, capsule, bracket."""

from __future__ import annotations

import numpy as np

from contact_toolkit.shapes import primitives
from scenarios.parts.surface import Surface, polygon, prism, require, revolve


def box(
    size_x: float = 0.1, size_y: float = 0.1, size_z: float = 0.1, divisions: int = 1
) -> Surface:
    """Return a box centred on the origin; each face is `divisions` × `divisions` cells.

    Sizes in [m]. 12 divisions² facets.
    """
    require(min(size_x, size_y, size_z) > 0.0, "sizes must be positive")
    require(divisions >= 1, f"divisions must be at least 1, not {divisions}")
    return primitives.box((size_x, size_y, size_z), divisions)


def doughnut(
    major_radius: float = 0.05,
    minor_radius: float = 0.02,
    major_sections: int = 64,
    minor_sections: int = 32,
) -> Surface:
    """Return a torus about z; vertices lie on the exact surface.

    Major radius [m] from the axis to the tube's centre, minor radius [m] of the tube.
    2 major_sections minor_sections facets.
    """
    require(0.0 < minor_radius < major_radius, "need 0 < minor_radius < major_radius")
    tube = minor_radius * polygon(minor_sections) + [major_radius, 0.0]
    return revolve(tube, major_sections, closed=True)


def truncated_cone(
    bottom_radius: float = 0.05,
    top_radius: float = 0.02,
    height: float = 0.25,
    sections: int = 128,
    rings: int = 40,
) -> Surface:
    """Return a closed truncated cone about z, from z = 0 to `height` [m], in `rings` rings.

    2 sections (rings + 1) facets; a cylinder if the radii [m] are equal.
    """
    require(min(bottom_radius, top_radius, height) > 0.0, "radii and height must be positive")
    require(rings >= 1, f"rings must be at least 1, not {rings}")
    rise = np.linspace(0.0, 1.0, rings + 1)
    radius = bottom_radius + (top_radius - bottom_radius) * rise
    return revolve(np.column_stack([radius, height * rise]), sections)


def rod(length: float = 0.3, radius: float = 0.005, sections: int = 24, rings: int = 30) -> Surface:
    """Return a slender cylinder about z, centred on the origin. Lengths in [m]."""
    vertices, faces = truncated_cone(radius, radius, length, sections, rings)
    return vertices - [0.0, 0.0, length / 2], faces


def capsule(
    length: float = 0.02, radius: float = 0.004, sections: int = 32, cap_rings: int = 8
) -> Surface:
    """Return a cylinder about z with hemispherical ends, centred on the origin.

    `length` [m] is the cylinder's alone; vertices lie on the exact surface.
    """
    require(min(length, radius) > 0.0, "length and radius must be positive")
    require(cap_rings >= 1, f"cap_rings must be at least 1, not {cap_rings}")
    require(sections >= 3, f"a closed ring needs at least 3 sections, not {sections}")
    return primitives.capsule_of_rings(radius, length, sections, cap_rings)


def l_bracket(
    width: float = 0.06, height: float = 0.08, depth: float = 0.03, thickness: float = 0.01
) -> Surface:
    """Return an L in the x, y plane, extruded `depth` [m] along z; the origin is its outer corner.

    Legs `width` along x and `height` along y, `thickness` thick [m].
    """
    require(0.0 < thickness < min(width, height), "thickness must be less than both legs")
    t = thickness
    outline = [(0.0, 0.0), (width, 0.0), (width, t), (t, t), (t, height), (0.0, height)]
    return prism(outline, depth, apex=3)
