"""A metric bolt and its nut, with true helical threads.

Profile of ISO 68-1: flanks at 60° to each other, H = √3/2 pitch; the external thread has a crest
flat of pitch/8 at the major diameter d and a root flat of pitch/4 at d − 5/4 H, the internal one
the reverse. Vertex rows follow the helix, so crests and roots are sharp lines, not staircases.
With their frames coincident, bolt and nut mate with equal play on both flanks; they still do after
a turn φ about z with a rise of pitch φ / 2π.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from scenarios.parts.surface import Faces, Surface, polygon, require, strips


@dataclass(frozen=True)
class _Thread:
    """A helical wall between z = bottom and top, seen from outside (faces point away from z)."""

    pitch: float
    root_radius: float
    crest_radius: float
    root_flat: float  # fraction of the pitch
    crest_flat: float
    phase: float  # where on the x axis a tooth's centre lies, z / pitch
    sections: int
    flank_rows: int  # facet rows on each flank
    bottom: float
    top: float

    def wall(self) -> tuple[NDArray[np.float64], Faces, NDArray[np.int32], NDArray[np.int32]]:
        """Return vertices, faces, and the vertex indices of the bottom and top ring.

        At both ends the tooth fades into the root cylinder over half a turn.
        """
        n, tooth = self.sections, self._tooth()
        m = len(tooth)
        margin = 0.02 * self.pitch  # keeps the rings clear of the first and last row
        first = np.ceil((self.bottom + margin) / self.pitch - tooth[0, 0])
        turns = int((self.top - margin) / self.pitch - tooth[0, 0] - first) - 1
        require(turns >= 1, "the thread is too short: it needs at least two pitches")
        # Vertex (i, j): section i, row j, m rows a turn. Section n is section 0, one turn up, so
        # section 0 carries m rows more than the others.
        rows = turns * m + 1
        seam = np.arange(rows + m, dtype=np.int32)
        others = (rows + m + np.arange((n - 1) * rows, dtype=np.int32)).reshape(n - 1, rows)
        ids = np.concatenate([seam[None, :rows], others, seam[None, m:]])

        section = np.concatenate([np.zeros(rows + m), np.repeat(np.arange(1, n), rows)])
        row = np.concatenate([np.arange(rows + m), np.tile(np.arange(rows), n - 1)])
        turn = row // m
        z = self.pitch * (first + turn + tooth[row % m, 0] + section / n)
        along = turn + section / n
        fade = np.clip(2.0 * np.minimum(along, turns - along), 0.0, 1.0)
        height = fade * tooth[row % m, 1]
        radius = self.root_radius + (self.crest_radius - self.root_radius) * height
        ring = polygon(n)
        walls = np.column_stack([radius[:, None] * ring[section.astype(int)], z])
        lower, upper = (
            np.column_stack([self.root_radius * ring, np.full(n, level)])
            for level in (self.bottom, self.top)
        )
        low = (len(walls) + np.arange(n)).astype(np.int32)
        high = low + np.int32(n)
        faces = np.concatenate([strips(ids.T), self._ends(ids, seam, low, high, m)])
        return np.concatenate([walls, lower, upper]), faces, low, high

    def _tooth(self) -> NDArray[np.float64]:
        """Return one pitch of the profile as (z / pitch, height from root 0 to crest 1) rows."""
        foot, shoulder = (1.0 - self.root_flat) / 2, self.crest_flat / 2
        fraction = np.linspace(0.0, 1.0, self.flank_rows + 1)
        rise = np.column_stack([foot + (shoulder - foot) * fraction, fraction])
        centre = np.array([self.phase, 0.0])
        return np.concatenate([centre + rise * [-1.0, 1.0], (centre + rise)[::-1]])

    @staticmethod
    def _ends(
        ids: NDArray[np.int32],
        seam: NDArray[np.int32],
        low: NDArray[np.int32],
        high: NDArray[np.int32],
        m: int,
    ) -> Faces:
        """Close the wall down to the bottom ring and up to the top ring.

        Beside the seam the helix ends one pitch higher than it begins: the cell there is a fan.
        """
        start, stop = ids[:, 0], ids[:, -1]
        below = strips(np.stack([low, start[:-1]]))
        fan_below = _fan(start[-2], np.concatenate([[low[-1], low[0]], seam[: m + 1]]))
        above = strips(np.stack([stop[1:], np.append(high[1:], high[0])]))
        fan_above = _fan(stop[1], np.concatenate([[high[1], high[0]], seam[-m - 1 :][::-1]]))
        return np.concatenate([below, fan_below, above, fan_above])


def _fan(apex: np.int32, path: NDArray[np.int32]) -> Faces:
    return np.stack([np.full(len(path) - 1, apex), path[:-1], path[1:]], axis=-1).astype(np.int32)


def _hexagon(across_flats: float, sections: int, z: float) -> NDArray[np.float64]:
    """Return `sections` points (n, 3) around a hexagon, its corners among them."""
    angle = 2 * np.pi * np.arange(sections) / sections
    from_flat = angle % (np.pi / 3) - np.pi / 6  # zero in the middle of a flat
    radius = 0.5 * across_flats / np.cos(from_flat)
    return np.column_stack([radius[:, None] * polygon(sections), np.full(sections, z)])


def _check(diameter: float, pitch: float, across_flats: float, sections: int) -> float:
    """Return the height H of the fundamental triangle [m]."""
    require(min(diameter, pitch) > 0.0, "diameter and pitch must be positive")
    require(across_flats > diameter, "across_flats must be more than the diameter")
    require(sections >= 6 and sections % 6 == 0, f"sections must be 6, 12, 18 …, not {sections}")
    height = np.sqrt(0.75) * pitch
    require(diameter > 2.0 * height, "the pitch is too coarse for the diameter")
    return float(height)


def bolt(
    diameter: float = 0.016,
    pitch: float = 0.002,
    *,
    length: float = 0.024,
    across_flats: float = 0.024,
    head_height: float = 0.01,
    allowance: float = 0.0002,
    sections: int = 144,
    flank_rows: int = 3,
) -> Surface:
    """Return a fully threaded hexagon bolt about z: head below z = 0, thread from 0 to `length`.

    Defaults: M16 × 2 (about 25 000 facets). All in [m]; `allowance` is taken off the diameters
    (0.2 mm is about the middle of the 6H/6g fit).
    """
    height = _check(diameter, pitch, across_flats, sections)
    require(head_height > 0.0, "head_height must be positive")
    crest = (diameter - allowance) / 2
    thread = _Thread(
        pitch=pitch,
        root_radius=crest - 0.625 * height,
        crest_radius=crest,
        root_flat=0.25,
        crest_flat=0.125,
        phase=0.5,
        sections=sections,
        flank_rows=flank_rows,
        bottom=0.0,
        top=length,
    )
    walls, faces, low, high = thread.wall()
    n, count = sections, len(walls)
    levels = np.concatenate(
        [_hexagon(across_flats, n, -head_height), _hexagon(across_flats, n, 0.0)]
    )
    bottom, under = (count + np.arange(2 * n)).reshape(2, n).astype(np.int32)
    centres = np.array([[0.0, 0.0, -head_height], [0.0, 0.0, length]])
    foot, tip = np.int32(count + 2 * n), np.int32(count + 2 * n + 1)
    closing = [
        strips(_wrap(np.stack([bottom, under, low]))),
        _fan(foot, np.append(bottom, bottom[0])[::-1]),
        _fan(tip, np.append(high, high[0])),
    ]
    return np.concatenate([walls, levels, centres]), np.concatenate([faces, *closing])


def nut(
    diameter: float = 0.016,
    pitch: float = 0.002,
    *,
    height: float = 0.0148,
    across_flats: float = 0.024,
    sections: int = 144,
    flank_rows: int = 3,
) -> Surface:
    """Return a hexagon nut about z, from -height/2 to height/2.

    Defaults: M16 × 2, ISO 4032 (about 15 000 facets). All in [m].
    """
    triangle = _check(diameter, pitch, across_flats, sections)
    thread = _Thread(
        pitch=pitch,
        root_radius=diameter / 2,
        crest_radius=diameter / 2 - 0.625 * triangle,
        root_flat=0.125,
        crest_flat=0.25,
        phase=0.0,
        sections=sections,
        flank_rows=flank_rows,
        bottom=-height / 2,
        top=height / 2,
    )
    walls, faces, low, high = thread.wall()
    n, count = sections, len(walls)
    levels = np.concatenate(
        [_hexagon(across_flats, n, -height / 2), _hexagon(across_flats, n, height / 2)]
    )
    bottom, top = (count + np.arange(2 * n)).reshape(2, n).astype(np.int32)
    outside = strips(_wrap(np.stack([low, bottom, top, high])))
    return np.concatenate([walls, levels]), np.concatenate([faces[:, ::-1], outside])


def _wrap(rings: NDArray[np.int32]) -> NDArray[np.int32]:
    return np.concatenate([rings, rings[:, :1]], axis=1)
