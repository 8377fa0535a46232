"""An involute spur gear."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scenarios.parts.surface import Surface, loft, require


def involute_gear(
    module: float = 0.002,
    teeth: int = 24,
    *,
    width: float = 0.012,
    bore_radius: float = 0.006,
    pressure_angle: float = np.deg2rad(20.0),
    backlash: float = 0.0,
    flank_points: int = 8,
    rows: int = 8,
) -> Surface:
    """Return a spur gear about z, centred on the origin, one tooth pointing along +x.

    Module, width, bore radius and backlash (clearance along the pitch circle when meshed with its
    like) in [m], pressure angle in [rad]. Addendum 1 and dedendum 1.25 modules; flanks are true
    involutes of the base circle with `flank_points` points, faces are cut in `rows`. Two gears of
    one module mesh at the distance module (teeth_a + teeth_b) / 2.
    """
    pitch = module * teeth / 2
    root = pitch - 1.25 * module
    require(min(module, width) > 0.0, "module and width must be positive")
    require(teeth >= 8, f"teeth must be at least 8, not {teeth}")
    require(0.0 < bore_radius < root, f"bore_radius must be in (0, {root}) m, not {bore_radius}")
    require(flank_points >= 2, f"flank_points must be at least 2, not {flank_points}")
    tooth = _tooth(module, teeth, pressure_angle, backlash, flank_points)
    turn = 2 * np.pi * np.arange(teeth) / teeth
    radius = np.tile(tooth[:, 0], teeth)
    angle = (turn[:, None] + tooth[:, 1]).reshape(-1)
    direction = np.column_stack([np.cos(angle), np.sin(angle)])
    outer, inner = radius[:, None] * direction, bore_radius * direction
    levels = np.linspace(-width / 2, width / 2, rows + 1)

    def at(loop: NDArray[np.float64], z: float) -> NDArray[np.float64]:
        return np.column_stack([loop, np.full(len(loop), z)])

    walls = [at(outer, z) for z in levels] + [at(inner, z) for z in levels[::-1]]
    return loft(walls, closed=True)


def _tooth(
    module: float, teeth: int, pressure_angle: float, backlash: float, flank_points: int
) -> NDArray[np.float64]:
    """Return one tooth's (radius, angle) points, counter-clockwise, from root to root."""
    pitch = module * teeth / 2
    base, tip, root = pitch * np.cos(pressure_angle), pitch + module, pitch - 1.25 * module
    radius = np.linspace(max(base, root), tip, flank_points)
    roll = np.arccos(np.minimum(base / radius, 1.0))
    at_pitch = np.pi / (2 * teeth) - backlash / (4 * pitch)
    half = at_pitch + np.tan(pressure_angle) - pressure_angle - (np.tan(roll) - roll)
    require(half[-1] > 0.0, f"{teeth} teeth come to a point below the tip; use more or blunter")
    require(half[0] < np.pi / teeth, f"{teeth} teeth leave no gap at the root")
    flank = np.column_stack([radius, half])
    foot = [(root, half[0] + 0.3 * (np.pi / teeth - half[0]))]  # stands in for the root fillet
    rising = np.concatenate([foot, flank])
    return np.concatenate([rising * [1.0, -1.0], rising[::-1]])
