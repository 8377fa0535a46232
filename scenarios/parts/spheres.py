"""Spheres of any number of facets, smooth and bumpy."""

from __future__ import annotations

import numpy as np

from contact_toolkit.shapes import primitives
from scenarios.parts.surface import Surface, require


def icosphere(radius: float = 0.05, frequency: int = 8) -> Surface:
    """Return a sphere about the origin: an icosahedron, each edge cut in `frequency` parts.

    20 frequency² facets of nearly equal size (7 gives 980, 224 gives 1 003 520); vertices lie on
    the exact sphere. Radius in [m].
    """
    require(radius > 0.0, f"radius must be positive, not {radius}")
    require(frequency >= 1, f"frequency must be at least 1, not {frequency}")
    return primitives.icosphere(frequency, radius)


def bumpy_sphere(
    radius: float = 0.05, frequency: int = 32, amplitude: float = 0.1, bumps: float = 6.0
) -> Surface:
    """Return a sphere whose radius varies by ± `amplitude` (relative), not convex.

    `bumps` is the number of waves across the diameter. 20 frequency² facets.
    """
    require(0.0 <= amplitude < 1.0, f"amplitude must be in [0, 1), not {amplitude}")
    vertices, faces = icosphere(radius, frequency)
    phase = np.pi * bumps * vertices / radius + [0.3, 0.7, 1.1]  # off every symmetry plane
    return vertices * (1.0 + amplitude * np.sin(phase).prod(axis=1, keepdims=True)), faces
