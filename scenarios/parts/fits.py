"""Parts that go into each other: peg and hole, Morse taper, wedge and groove."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.parts.surface import Surface, loft, polygon, prism, require, revolve

MORSE_HALF_ANGLE = np.deg2rad(1.45)


def peg(
    radius: float = 0.00995,
    length: float = 0.05,
    chamfer: float = 0.001,
    sections: int = 96,
    rings: int = 20,
) -> Surface:
    """Return a round peg about z, its chamfered (45°) tip at z = 0. Lengths in [m]."""
    require(0.0 <= chamfer < min(radius, length), "chamfer must be less than radius and length")
    shaft = [(radius, z) for z in np.linspace(chamfer, length, rings + 1)]
    tip = [(radius - chamfer, 0.0)] if chamfer > 0.0 else []
    return revolve(tip + shaft, sections)


def hole_plate(
    hole_radius: float = 0.01,
    *,
    size: float = 0.06,
    thickness: float = 0.03,
    chamfer: float = 0.0,
    sections: int = 96,
    rings: int = 12,
) -> Surface:
    """Return a square plate, top at z = 0, with a round through-hole about z. Lengths in [m].

    `chamfer` breaks the hole's upper edge at 45°; `rings` cut the hole's wall.
    """
    require(sections % 8 == 0, f"sections must be 8, 16, 24 …, not {sections}")  # plate corners
    require(0.0 <= chamfer < thickness, "chamfer must be less than the thickness")
    require(hole_radius + chamfer < size / 2, "the hole does not fit in the plate")
    ring = polygon(sections)
    square = ring / np.abs(ring).max(axis=1, keepdims=True) * (size / 2)

    def at(loop: NDArray[np.float64], z: float) -> NDArray[np.float64]:
        return np.column_stack([loop, np.full(sections, z)])

    mouth = [at((hole_radius + chamfer) * ring, 0.0)] if chamfer > 0.0 else []
    wall = [at(hole_radius * ring, z) for z in np.linspace(-chamfer, -thickness, rings + 1)]
    return loft([at(square, -thickness), at(square, 0.0), *mouth, *wall], closed=True)


def taper_plug(
    large_radius: float = 0.009,
    length: float = 0.05,
    half_angle: float = MORSE_HALF_ANGLE,
    sections: int = 96,
    rings: int = 40,
) -> Surface:
    """Return a conical plug about z, its large end at z = 0, narrowing to z = -length.

    Lengths in [m], half-angle in [rad].
    """
    small = large_radius - length * np.tan(half_angle)
    require(length > 0.0 and small > 0.0, "the plug comes to a point: shorten it")
    z = np.linspace(-length, 0.0, rings + 1)
    return revolve(np.column_stack([large_radius + z * np.tan(half_angle), z]), sections)


def taper_socket(
    large_radius: float = 0.009,
    length: float = 0.04,
    *,
    outer_radius: float = 0.015,
    half_angle: float = MORSE_HALF_ANGLE,
    sections: int = 96,
    rings: int = 32,
) -> Surface:
    """Return a sleeve about z whose conical bore fits `taper_plug` with the frames coincident.

    Mouth at z = 0; lengths in [m], half-angle in [rad].
    """
    require(length > 0.0, f"length must be positive, not {length}")
    require(large_radius - length * np.tan(half_angle) > 0.0, "the bore comes to a point")
    require(outer_radius > large_radius, "outer_radius must be more than the bore's")
    z = np.linspace(0.0, -length, rings + 1)
    bore = np.column_stack([large_radius + z * np.tan(half_angle), z])
    profile = np.concatenate([[(outer_radius, -length), (outer_radius, 0.0)], bore])
    return revolve(profile, sections, closed=True)


def v_groove(
    half_angle: float = np.deg2rad(15.0),
    depth: float = 0.03,
    width: float = 0.06,
    height: float = 0.05,
    length: float = 0.04,
) -> Surface:
    """Return a block with a V-shaped groove, extruded along z; the groove's bottom is the origin.

    The groove opens towards +y, its faces at ± `half_angle` [rad] to the x = 0 plane. Lengths [m].
    """
    mouth = depth * np.tan(half_angle)
    require(0.0 < mouth < width / 2, "the groove is wider than the block")
    require(0.0 < depth < height, "the groove is deeper than the block")
    x, top, bottom = width / 2, depth, depth - height
    outline = [(0.0, 0.0), (mouth, top), (x, top), (x, bottom), (-x, bottom), (-x, top)]
    return prism([*outline, (-mouth, top)][::-1], length, apex=6)


def wedge(
    half_angle: float = np.deg2rad(15.0),
    depth: float = 0.03,
    nose: float = 0.005,
    length: float = 0.03,
) -> Surface:
    """Return a wedge that fits `v_groove` with the frames coincident, blunt below y = `nose` [m].

    It ends at y = `depth` [m]; half-angle in [rad].
    """
    require(0.0 < nose < depth, "nose must be between 0 and the depth")
    low, high = nose * np.tan(half_angle), depth * np.tan(half_angle)
    return prism([(-low, nose), (low, nose), (high, depth), (-high, depth)], length)
