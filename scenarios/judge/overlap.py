"""How deep solids are in each other: by distances of points, without any contact force."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from contact_toolkit import CollisionMesh, signed_distance

Floats = NDArray[np.float64]

SPACING = 5e-4  # [m] between the points looked at along an edge


def deepest_overlap(
    meshes: Sequence[CollisionMesh], X_WB: Sequence[Floats], moving: NDArray[np.bool_]
) -> float:
    """Return how deep the edges of any solid are in any other [m]; 0 if all are apart.

    Of poses (4, 4) in the world. Pairs of which neither moves are left out.
    """
    edges = [_points_along_edges(mesh) for mesh in meshes]
    in_world = [points @ X[:3, :3].T + X[:3, 3] for points, X in zip(edges, X_WB, strict=True)]
    low = [points.min(axis=0) for points in in_world]
    high = [points.max(axis=0) for points in in_world]
    deepest = 0.0
    for i, j in combinations(range(len(meshes)), 2):
        if not (moving[i] or moving[j]) or (low[i] > high[j]).any() or (low[j] > high[i]).any():
            continue
        for solid, other in ((i, j), (j, i)):
            near = np.all(
                (in_world[other] >= low[solid]) & (in_world[other] <= high[solid]), axis=1
            )
            points = (in_world[other][near] - X_WB[solid][:3, 3]) @ X_WB[solid][:3, :3]
            distance = signed_distance(meshes[solid], points).distance
            deepest = max(deepest, -float(distance.min(initial=0.0)))
    return deepest


def _points_along_edges(mesh: CollisionMesh) -> Floats:
    """Return points (n, 3) along all edges, ends included."""
    starts, ends = mesh.vertices[mesh.edges[:, 0]], mesh.vertices[mesh.edges[:, 1]]
    counts = 1 + np.ceil(np.linalg.norm(ends - starts, axis=1) / SPACING).astype(int)
    return np.concatenate(
        [np.linspace(a, b, n) for a, b, n in zip(starts, ends, counts, strict=True)]
    )
