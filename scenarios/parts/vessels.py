"""Hollow parts: mug, vibratory bowl feeder, collet."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from contact_toolkit.shapes.csg import difference, moved, union
from scenarios.parts.solids import box
from scenarios.parts.surface import Surface, loft, polygon, require, revolve


def mug(
    radius: float = 0.04,
    height: float = 0.095,
    wall: float = 0.004,
    handle: float = 0.006,
    sections: int = 48,
) -> Surface:
    """Return a mug about z standing on z = 0, its handle towards +x. Lengths in [m].

    `handle` is the radius of the handle's bow; the bottom is 1.5 walls thick.
    """
    require(0.0 < wall < radius / 2, "wall must be less than half the radius")
    require(0.0 < handle < height / 8, "handle must be less than an eighth of the height")
    inner, floor = radius - wall, 1.5 * wall
    outer = [(radius, z) for z in np.linspace(0.0, height, 9)]
    hollow = [(inner, z) for z in np.linspace(height, floor, 9)]
    cup = revolve([(0.0, 0.0), *outer, *hollow, (0.0, floor)], sections)
    bow = np.linspace(-np.pi / 2, np.pi / 2, 13)
    reach, middle = 0.3 * height, height / 2
    path = np.column_stack(
        [radius - wall / 2 + 0.75 * reach * np.cos(bow), 0.0 * bow, middle + reach * np.sin(bow)]
    )
    along = np.column_stack([-0.75 * np.sin(bow), 0.0 * bow, np.cos(bow)])
    return union(cup, _tube(path, along, handle, 12))


def bowl_feeder(
    radius: float = 0.12,
    turns: float = 1.5,
    pitch: float = 0.03,
    track: float = 0.02,
    sections: int = 72,
) -> Surface:
    """Return a bowl about z with a track that climbs its wall, counter-clockwise seen from above.

    The floor is z = 0; the track, `track` wide and rising `pitch` a turn, ends level with the rim.
    Lengths in [m]; the wall is 6 mm thick.
    """
    require(0.0 < track < radius / 2, "track must be less than half the radius")
    require(pitch > 0.006, "pitch must be more than the track's thickness of 3 mm, twice")
    require(turns > 0.0, f"turns must be positive, not {turns}")
    wall, height = 0.006, pitch * turns + 0.01
    profile = [
        (0.0, -wall), (radius + wall, -wall), (radius + wall, height), (radius, height),
        (radius, 0.0), (0.0, 0.0),
    ]  # fmt: skip
    bowl = revolve(profile, sections)
    steps = round(sections * turns)
    angle = np.linspace(0.0, 2 * np.pi * turns, steps + 1)
    low = np.linspace(-0.0035, pitch * turns - 0.0035, steps + 1)
    loops = [
        _radial_rectangle(a, z, radius - track, radius + wall / 2, 0.003)
        for a, z in zip(angle, low, strict=True)
    ]
    return union(bowl, loft(loops))


def collet(
    bore_radius: float = 0.005,
    wall: float = 0.002,
    length: float = 0.03,
    half_angle: float = np.deg2rad(8.0),
    slits: int = 4,
) -> Surface:
    """Return a collet ring about z: a cylindrical bore, a cone outside, slits from the thick end.

    The thin end lies at z = 0 with that wall; the cone widens by `half_angle` [rad] upwards; slits
    end at a quarter of the length. Lengths in [m].
    """
    require(min(bore_radius, wall, length) > 0.0, "lengths must be positive")
    require(0.0 < half_angle < np.pi / 4, "half_angle must be below 45°")
    require(slits >= 1, f"slits must be at least 1, not {slits}")
    z = np.linspace(0.0, length, 13)
    outside = np.column_stack([bore_radius + wall + z * np.tan(half_angle), z])
    bore = np.column_stack([np.full(13, bore_radius), z[::-1]])
    ring = revolve(np.concatenate([outside, bore]), 64, closed=True)
    reach = 2.0 * outside[-1, 0]
    width = 0.3 * bore_radius
    cuts = []
    for angle in 2 * np.pi * (np.arange(slits) + 0.5) / slits:
        c, s = np.cos(angle), np.sin(angle)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        blade = moved(box(reach, width, length), (reach / 2, 0.0, 0.75 * length))
        cuts.append(moved(blade, (0.0, 0.0, 0.0), turn))
    return difference(ring, *cuts)


def _tube(
    path: NDArray[np.float64], along: NDArray[np.float64], radius: float, corners: int
) -> Surface:
    """Return a round tube about a path in the x, z plane, its tangents given."""
    ring = radius * polygon(corners)
    tangent = along / np.linalg.norm(along, axis=1, keepdims=True)
    side = np.array([0.0, 1.0, 0.0])
    loops = []
    for point, t in zip(path, tangent, strict=True):
        across = np.cross(side, t)
        loops.append(point + ring[:, :1] * across + ring[:, 1:] * side)
    return loft(loops)


def _radial_rectangle(
    angle: float, z: float, inner: float, outer: float, thickness: float
) -> NDArray[np.float64]:
    """Return the corners of a track's cross-section, counter-clockwise seen along the track."""
    c, s = np.cos(angle), np.sin(angle)
    corners = [(inner, z), (outer, z), (outer, z + thickness), (inner, z + thickness)]
    return np.array([(r * c, r * s, h) for r, h in corners[::-1]])
