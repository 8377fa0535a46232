"""Queries of points against a mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contact_toolkit import _core
from contact_toolkit.mesh import CollisionMesh, MeshError

_MAX_COORDINATE = 1e15  # [m], as for meshes


@dataclass(frozen=True)
class SignedDistances:
    """Signed distances of points from a closed mesh A; row i belongs to point i.

    Attributes
    ----------
    distance
        (n,) [m]; negative inside.
    p_ACa
        (n, 3) closest points of the surface [m], in A.
    gradient_A
        (n, 3) unit gradients of the distance, outwards. On an edge or vertex of the surface: the
        pseudonormal. Where several closest points compete: that of the facet reported.
    facet
        (n,) facets the closest points lie on, the lowest index where there are several.
    """

    distance: NDArray[np.float64]
    p_ACa: NDArray[np.float64]
    gradient_A: NDArray[np.float64]
    facet: NDArray[np.int32]

    def __len__(self) -> int:
        return len(self.distance)


def signed_distance(A: CollisionMesh, points: ArrayLike, *, threads: int = 1) -> SignedDistances:
    """How far points are from the surface of a solid, negative inside.

    Exact up to rounding. The sign is the angle-weighted pseudonormal's (Bærentzen and Aanæs,
    "Signed distance computation using the angle weighted pseudonormal", IEEE TVCG 11(3), 2005).

    Parameters
    ----------
    A
        A closed mesh.
    points
        (n, 3) positions in A [m].
    threads
        Threads to share the points between; the answer does not depend on it.

    Raises
    ------
    MeshError
        If A is not closed, so that nothing is inside it.
    ValueError
        If `points` are not (n, 3) finite numbers, or `threads` is not positive.
    """
    defects = A.defects
    if not defects.closed:
        raise MeshError(
            f"signed_distance needs a closed mesh, and this one has {defects}; fill the holes and "
            f"unify the winding (for example trimesh.repair), or use distance, which has no sign"
        )
    p_AQ = np.ascontiguousarray(points, dtype=np.float64)
    if p_AQ.ndim != 2 or p_AQ.shape[1] != 3:
        raise ValueError(f"points must have shape (n, 3), not {p_AQ.shape}")
    bad = ~(np.abs(p_AQ) <= _MAX_COORDINATE).all(axis=1)
    if bad.any():
        first = int(np.argmax(bad))
        raise ValueError(
            f"point {first} is {p_AQ[first].tolist()}; coordinates must be finite and below 1e15 m"
        )
    if threads < 1:
        raise ValueError(f"threads must be at least 1, not {threads}")
    return SignedDistances(*_core.signed_distance(A._core, p_AQ, threads))
