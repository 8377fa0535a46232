"""Least distance over a translation: from the facets of A to the prisms that those of B sweep.

A prism's surface is eight triangles, whose distances come from `oracle_brute_force`, in extended
precision; beyond these a facet can only lie wholly inside.
"""

import numpy as np
from numpy.typing import NDArray
from oracle_brute_force import Mesh, triangle_distances
from scipy.spatial.distance import cdist


def swept_by_prisms(A: Mesh, B: Mesh, X0: NDArray[np.float64], X1: NDArray[np.float64]) -> float:
    """Least distance of A's facets from the prisms that B's facets sweep."""
    S = A.vertices[A.faces]
    start = B.vertices[B.faces] @ X0[:3, :3].T + X0[:3, 3]
    way = X1[:3, 3] - X0[:3, 3]
    end = start + way
    sides = [start, end]
    for i in range(3):
        k = (i + 1) % 3
        sides.append(np.stack([start[:, i], start[:, k], end[:, k]], axis=1))
        sides.append(np.stack([start[:, i], end[:, k], end[:, i]], axis=1))
    if _any_inside(S[:, 0], start, way):
        return 0.0
    a, b = _near(S, np.concatenate([start, end], axis=1))
    return float(min(triangle_distances(S[a], side[b])[0].min() for side in sides))


def _near(S, P):
    """Indices of the point sets S (m,3,3) and P (n,6,3) that may be closest, by their spheres."""
    centres = [points.mean(axis=1) for points in (S, P)]
    radii = [
        np.linalg.norm(points - centre[:, None], axis=2).max(axis=1)
        for points, centre in zip((S, P), centres, strict=True)
    ]
    apart = np.linalg.norm(centres[0][:, None] - centres[1][None], axis=2)
    reach = radii[0][:, None] + radii[1][None]
    least = cdist(S.reshape(-1, 3), P.reshape(-1, 3)).min()
    return np.nonzero(apart - reach <= least * (1 + 1e-9))


def _any_inside(points, start, way):
    """Whether a point lies in a prism, away from its walls."""
    a, b, c = (start[None, :, k] for k in range(3))
    p = points[:, None]
    volume = np.cross(b - a, c - a) @ way
    with np.errstate(divide="ignore", invalid="ignore"):
        u = np.cross(p - a, c - a) @ way / volume
        v = np.cross(b - a, p - a) @ way / volume
        s = np.einsum("mni,mni->mn", np.cross(b - a, c - a), p - a) / volume
    return bool(((u > 0) & (v > 0) & (u + v < 1) & (s > 0) & (s < 1)).any())
