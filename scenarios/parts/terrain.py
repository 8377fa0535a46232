"""Ground to drop robots on: seeded height fields, stairs, rocks on a hill."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from contact_toolkit.shapes.csg import moved, union
from scenarios.parts.spheres import icosphere
from scenarios.parts.surface import Surface, prism, require, strips


def height_field(
    size: float = 4.0,
    cells: int = 40,
    *,
    slope: float = 0.0,
    roughness: float = 0.05,
    wavelength: float = 1.0,
    base: float = 1.0,
    seed: int = 0,
) -> Surface:
    """Return square ground centred on the z axis, its surface at z = 0 on average.

    It falls towards +x by `slope` [rad] and undulates by ± `roughness` [m] with waves of random
    direction, none shorter than `wavelength` [m]; the same seed gives the same ground. It reaches
    `base` [m] below its lowest point. 4 cells² facets and a skirt.
    """
    require(size > 0.0 and wavelength > 0.0 and base > 0.0, "lengths must be positive")
    require(cells >= 1, f"cells must be at least 1, not {cells}")
    require(0.0 <= slope < np.pi / 2, "slope must be between 0 and a quarter turn")
    require(roughness >= 0.0, f"roughness must not be negative, as {roughness} is")
    line = np.linspace(-size / 2, size / 2, cells + 1)
    x, y = np.meshgrid(line, line)
    return _over_base(x, y, _waves(x, y, roughness, wavelength, seed) - x * np.tan(slope), base)


def stairs(
    steps: int = 5, rise: float = 0.17, run: float = 0.28, width: float = 1.2, landing: float = 1.0
) -> Surface:
    """Return stairs that climb towards +x from the origin's plane z = 0, extruded along y.

    The first riser stands at x = 0; a landing of that length [m] lies before it. Lengths in [m].
    """
    require(min(rise, run, width, landing) > 0.0, "lengths must be positive")
    require(steps >= 1, f"steps must be at least 1, not {steps}")
    flights = [_block(-landing, steps * run, -rise, 0.0, width)]
    flights += [
        _block(i * run, steps * run, -rise / 2, (i + 1) * rise, width) for i in range(steps)
    ]
    return union(*flights)


def rock(
    radius: float = 0.2, seed: int = 0, frequency: int = 6, ruggedness: float = 0.25
) -> Surface:
    """Return a boulder about the origin, with faces like broken stone; 20 frequency² facets.

    `ruggedness` is by how much its radius varies, relative to `radius` [m].
    """
    require(0.0 <= ruggedness < 0.6, f"ruggedness must be in [0, 0.6), not {ruggedness}")
    vertices, faces = icosphere(radius, frequency)
    random = np.random.default_rng(seed)
    direction = vertices / np.linalg.norm(vertices, axis=1, keepdims=True)
    normals = random.normal(size=(14, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    reach = radius * (1.0 - ruggedness * random.uniform(0.0, 1.0, 14))
    cosine = direction @ normals.T
    cut = np.where(cosine > 0.3, reach / np.maximum(cosine, 0.3), radius)  # planes cut a ball
    return direction * np.minimum(radius, cut.min(axis=1))[:, None], faces


def boulder_field(
    size: float = 4.0,
    slope: float = 0.2,
    rocks: int = 24,
    smallest: float = 0.1,
    *,
    largest: float = 0.3,
    seed: int = 0,
) -> Surface:
    """Return a hill like `height_field`, with half-buried rocks of these radii [m] on it."""
    require(0.0 < smallest <= largest < size / 4, "need 0 < smallest ≤ largest < size / 4")
    require(rocks >= 0, f"rocks must not be negative, as {rocks} is")
    random = np.random.default_rng(seed)
    ground = height_field(size, 20, slope=slope, roughness=0.03, seed=seed)
    stones = []
    for number in range(rocks):
        radius = random.uniform(smallest, largest)
        x, y = random.uniform(-size / 2 + largest, size / 2 - largest, 2)
        z = -x * np.tan(slope) - random.uniform(0.0, 0.4) * radius
        stones.append(moved(rock(radius, seed + number + 1, 4), (x, y, z)))
    return union(ground, *stones)


def _waves(
    x: NDArray[np.float64], y: NDArray[np.float64], roughness: float, shortest: float, seed: int
) -> NDArray[np.float64]:
    random = np.random.default_rng(seed)
    height = np.zeros_like(x)
    for _ in range(12):
        length = shortest * random.uniform(1.0, 4.0)
        angle, phase = random.uniform(0.0, 2.0 * np.pi, 2)
        height += np.sin(2 * np.pi / length * (x * np.cos(angle) + y * np.sin(angle)) + phase)
    return roughness * height / 12


def _over_base(
    x: NDArray[np.float64], y: NDArray[np.float64], z: NDArray[np.float64], base: float
) -> Surface:
    """Close a height field by walls and a floor."""
    rows, columns = z.shape
    top = np.arange(rows * columns, dtype=np.int32).reshape(rows, columns)
    rim = np.concatenate([top[0, :-1], top[:-1, -1], top[-1, :0:-1], top[:0:-1, 0]])
    upper = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    floor = upper[rim] * [1.0, 1.0, 0.0] + [0.0, 0.0, z.min() - base]
    low = np.arange(len(rim), dtype=np.int32) + len(upper)
    centre = np.int32(len(upper) + len(rim))
    walls = strips(np.stack([np.append(low, low[0]), np.append(rim, rim[0])]))
    fan = np.stack([np.full(len(rim), centre), np.roll(low, -1), low], axis=-1)
    vertices = np.concatenate([upper, floor, [[0.0, 0.0, z.min() - base]]])
    return vertices, np.concatenate([strips(top), walls, fan]).astype(np.int32)


def _block(x0: float, x1: float, z0: float, z1: float, width: float) -> Surface:
    outline = [(x0, z0), (x1, z0), (x1, z1), (x0, z1)]
    vertices, faces = prism(outline, width)
    return np.column_stack([vertices[:, 0], -vertices[:, 2], vertices[:, 1]]), faces
