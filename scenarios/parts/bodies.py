"""Bodies of experiments: a tracked robot's hull, a spinning top, an arch's stone."""

from __future__ import annotations

import numpy as np

from contact_toolkit.shapes.csg import moved, union
from scenarios.parts.solids import box
from scenarios.parts.surface import Surface, prism, require, revolve


def tracked_robot(
    length: float = 0.6, width: float = 0.45, height: float = 0.3, track_width: float = 0.09
) -> Surface:
    """Return the hull of a tracked robot: two tracks, a chassis between them, a mast.

    Not convex: the belly stands clear of the ground, and the mast of the chassis. Forward is +x,
    the tracks stand on z = 0. Lengths in [m]; the mast reaches `height`.
    """
    require(0.0 < track_width < width / 3, "track_width must be less than a third of the width")
    require(0.0 < height < length, "height must be less than the length")
    wheel = 0.3 * height
    tracks = [
        moved(_track(length, wheel, track_width), (0.0, side * (width - track_width) / 2, wheel))
        for side in (-1.0, 1.0)
    ]
    chassis = moved(box(0.8 * length, width - track_width, 0.9 * wheel), (0.0, 0.0, 1.35 * wheel))
    deck = moved(box(0.45 * length, 0.5 * width, 0.6 * wheel), (-0.05 * length, 0.0, 2.0 * wheel))
    tall = height - 1.8 * wheel
    mast = moved(box(0.06 * length, 0.06 * length, tall), (0.1 * length, 0.0, height - tall / 2))
    head = moved(
        box(0.12 * length, 0.3 * width, 0.35 * wheel), (0.1 * length, 0.0, height - 0.175 * wheel)
    )
    return union(*tracks, chassis, deck, mast, head)


def spinning_top(
    radius: float = 0.03, height: float = 0.05, tip_radius: float = 0.003, sections: int = 48
) -> Surface:
    """Return a top about z, its round tip (a sphere's cap) touching z = 0. Lengths in [m]."""
    require(0.0 < tip_radius < radius / 3, "tip_radius must be less than a third of the radius")
    require(height > radius, "height must be more than the radius")
    bow = np.linspace(0.0, np.pi / 3, 9)
    tip = np.column_stack([tip_radius * np.sin(bow), tip_radius * (1.0 - np.cos(bow))])
    stem = 0.15 * radius
    rest = [
        (radius, 0.45 * height), (radius, 0.6 * height), (stem, 0.65 * height), (stem, height),
    ]  # fmt: skip
    return revolve(np.concatenate([tip, rest]), sections)


def voussoir(
    inner_radius: float = 0.5,
    outer_radius: float = 0.6,
    angle: float = np.pi / 9,
    depth: float = 0.15,
) -> Surface:
    """Return a stone of a round arch about y, its middle at the top; `angle` [rad] is its share.

    Lengths in [m].
    """
    require(0.0 < inner_radius < outer_radius, "need 0 < inner_radius < outer_radius")
    require(0.0 < angle < np.pi / 2, "angle must be less than a quarter turn")
    ends = np.pi / 2 + np.array([angle / 2, -angle / 2])
    inner = [(inner_radius * np.cos(a), inner_radius * np.sin(a)) for a in ends]
    outer = [(outer_radius * np.cos(a), outer_radius * np.sin(a)) for a in ends[::-1]]
    vertices, faces = prism([*inner, *outer], depth)
    return np.column_stack([vertices[:, 0], -vertices[:, 2], vertices[:, 1]]), faces


def _track(length: float, wheel: float, width: float) -> Surface:
    """Return a track: the outline of two wheels and the belt around them, extruded along y."""
    arc = np.linspace(-np.pi / 2, np.pi / 2, 13)
    middle = length / 2 - wheel
    front = np.column_stack([middle + wheel * np.cos(arc), wheel * np.sin(arc)])
    vertices, faces = prism(np.concatenate([front, -front]), width)
    return np.column_stack([vertices[:, 0], -vertices[:, 2], vertices[:, 1]]), faces
