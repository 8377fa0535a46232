"""The mass and inertia of a solid of uniform density."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from contact_toolkit.shapes.mesh import CollisionMesh

Floats = NDArray[np.float64]


def mass_properties(mesh: CollisionMesh, density: float) -> tuple[float, Floats, Floats]:
    """Return mass [kg], centre of mass (3,) [m] and inertia about it (3, 3) [kg m²].

    Of a closed mesh at a uniform density [kg/m³], by tetrahedra from the vertices' mean.
    """
    if not (np.isfinite(density) and density > 0):
        raise ValueError(f"density must be positive, not {density}")
    middle = mesh.vertices.mean(axis=0)
    corners = mesh.vertices[mesh.faces] - middle
    sixfold = np.einsum("ni,ni->n", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    volume = sixfold.sum() / 6
    total = corners.sum(axis=1)
    center = (sixfold[:, None] * total).sum(axis=0) / 24 / volume
    # ∫ x xᵀ over a tetrahedron with a corner at the origin: det/120 (Σ c cᵀ + s sᵀ), s = Σ c.
    second = np.einsum("n,nki,nkj->ij", sixfold, corners, corners)
    second = (second + np.einsum("n,ni,nj->ij", sixfold, total, total)) / 120
    second -= volume * np.outer(center, center)
    inertia = density * (np.trace(second) * np.eye(3) - second)
    return density * volume, center + middle, inertia
