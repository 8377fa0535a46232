"""Queries of points against a mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contact_toolkit import _core
from contact_toolkit.query.arguments import as_points, as_threads
from contact_toolkit.shapes.mesh import CollisionMesh, MeshError


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


def signed_distance(
    A: CollisionMesh, points: ArrayLike, *, threads: int | None = 1
) -> SignedDistances:
    """How far points are from the surface of a solid, negative inside.

    Exact up to rounding. The sign is the angle-weighted pseudonormal's (Bærentzen and Aanæs,
    "Signed distance computation using the angle weighted pseudonormal", IEEE TVCG 11(3), 2005).

    Parameters
    ----------
    A
        A mesh that bounds a solid, if need be once nearly clean facets are set right: see
        `CollisionMesh.solid`. Next to the hole of a nearly closed one the sign is the generalized
        winding number's (Jacobson et al., ACM TOG 32(4), 2013).
    points
        (n, 3) positions in A [m].
    threads
        How many share the work; None: as many as the process may use.

    Raises
    ------
    MeshError
        If A bounds no solid, so that nothing is inside it.
    ValueError
        If `points` are not (n, 3) finite numbers, or `threads` is not positive.

    Examples
    --------
    >>> from contact_toolkit import CollisionMesh, signed_distance
    >>> from contact_toolkit.shapes.primitives import box
    >>> cube = CollisionMesh(*box([0.1, 0.1, 0.1]))
    >>> found = signed_distance(cube, [[0.0, 0.0, 0.04], [0.0, 0.0, 0.06]])
    >>> found.distance.round(12)
    array([-0.01,  0.01])
    >>> found.gradient_A.round(12) + 0.0
    array([[0., 0., 1.],
           [0., 0., 1.]])
    """
    if not A.solid.has_inside:
        defects = "; ".join(A.describe_defects())
        raise MeshError(
            f"signed_distance needs a mesh with an inside, and {A.source or 'this one'} has none: "
            f"{defects}; fill the holes and unify the winding (for example trimesh.repair), or use "
            f"distance, which has no sign"
        )
    p_AQ = as_points(points)
    return SignedDistances(*_core.signed_distance(A._solid, p_AQ, as_threads(threads)))
