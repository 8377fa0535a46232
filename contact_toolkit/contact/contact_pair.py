"""ContactGeometry and ContactPair: what may touch, and by what law."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from contact_toolkit.contact.contact_law import NonlinearDamper
from contact_toolkit.contact.friction import Friction
from contact_toolkit.contact.spring_webs import AreaWeb, SpringWeb
from contact_toolkit.shapes.mesh import CollisionMesh


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
        Where the springs are: an `AreaWeb` (the default), a `FacetWeb` or a `PointWeb`.
    friction
        Between the two surfaces; none unless given.
    """

    a: int
    b: int
    damper: NonlinearDamper
    web: SpringWeb = AreaWeb()  # noqa: RUF009  immutable
    friction: Friction | None = None
