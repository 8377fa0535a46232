"""ContactGeometry and ContactPair: what may touch, and by what law."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from contact_toolkit.contact_law import NonlinearDamper
from contact_toolkit.friction import Friction
from contact_toolkit.mesh import CollisionMesh


@dataclass(frozen=True)
class ContactGeometry:
    """A mesh fixed to a body.

    Parameters
    ----------
    name
        For messages.
    body
        Name of the body, or its index.
    mesh
        The surface, in the geometry's own frame G.
    X_BG
        (4, 4) pose of G in the body frame B.
    """

    name: str
    body: str | int
    mesh: CollisionMesh
    X_BG: NDArray[np.float64] = field(default_factory=lambda: np.eye(4))


@dataclass(frozen=True)
class ContactPair:
    """Two geometries that may touch, and by what law.

    Parameters
    ----------
    a, b
        Indices of the geometries, on different bodies.
    damper
        The law of the springs; its `k` in the unit the web asks for.
    web
        "area": an elastic foundation; "facet": a spring for every witness pair.
    standoff
        Distance [m] at which contact begins: positive for the facet web, and for the area web where
        the probed surface is open.
    weighting
        Of the facet web's springs: "multiplicity" (each merged witness pair counts as often as the
        facet pairs behind it: continuous and conservative) or "unit" (once, as published).
    field
        How the area web sees the probed body: "smooth" (continuous forces, fast; convex edges
        slightly rounded) or "exact".
    resolution
        Spacing of the area web's nodes as a share of the smaller bounding box's diagonal.
    sampled
        Which body carries the area web's nodes: "thinner", "a" or "b".
    fillet
        Radius [m] of the sharp convex edges of both bodies, by which crossing edges bear load in
        the area web; 0: none.
    friction
        Between the two surfaces; none unless given.
    """

    a: int
    b: int
    damper: NonlinearDamper
    web: Literal["area", "facet"] = "area"
    standoff: float = 0.0
    weighting: Literal["multiplicity", "unit"] = "multiplicity"
    field: Literal["smooth", "exact"] = "smooth"
    resolution: float = 0.02
    sampled: Literal["thinner", "a", "b"] = "thinner"
    fillet: float = 0.0
    friction: Friction | None = None
