"""NativeWebs: the webs of a contact model's pairs, as the core has them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from weakref import WeakKeyDictionary

from contact_toolkit import _core
from contact_toolkit.contact.contact_pair import ContactGeometry, ContactPair
from contact_toolkit.contact.inside import require_inside
from contact_toolkit.contact.spring_webs import AreaWeb, FacetWeb, PointWeb
from contact_toolkit.shapes.mesh import CollisionMesh

# What webs prepare for a mesh, for as long as the mesh lives.
_area_bodies: WeakKeyDictionary[CollisionMesh, _core.AreaBody] = WeakKeyDictionary()


class NativeWebs:
    """Makes the pairs' webs; what they prepare for a mesh is shared by all that touch with it."""

    def __init__(self, geometries: Sequence[ContactGeometry]) -> None:
        self._geometries = geometries

    def make(self, pair: ContactPair) -> _core.SpringWeb:
        """Return the pair's web; raise ValueError for what it cannot be made of."""
        match pair.web:
            case AreaWeb() as web:
                require_inside(web, self._geometries[pair.a], self._geometries[pair.b])
                return _core.AreaWeb(
                    self._area_body(pair.a),
                    self._area_body(pair.b),
                    pair.damper.k,
                    pair.damper.n,
                    web.standoff,
                    _core.AreaField[web.field],
                    -1.0 if web.resolution is None else web.resolution,
                    _core.AreaSide[web.sampled],
                    web.fillet,
                    web.nominal_force or 0.0,
                )
            case FacetWeb() as web:
                return _core.FacetWeb(
                    self._mesh(pair.a),
                    self._mesh(pair.b),
                    pair.damper.k,
                    pair.damper.n,
                    web.standoff,
                    _core.Weighting[web.weighting],
                )
            case PointWeb() as web:
                return self._point_web(pair, web)
        raise ValueError(f"web must be an AreaWeb, a FacetWeb or a PointWeb, not {pair.web!r}")

    def _point_web(self, pair: ContactPair, web: PointWeb) -> _core.PointWeb:
        radii = {side: _radius_of(self._geometries[side].mesh) for side in (pair.a, pair.b)}
        ball = min(radii, key=radii.__getitem__)
        other = pair.b if ball == pair.a else pair.a
        if not math.isfinite(radii[ball]):
            raise ValueError("a PointWeb needs a sphere, CollisionMesh.from_primitive; use AreaWeb")
        if pair.damper.n != 1:
            raise ValueError(f"a PointWeb is linear, n = 1, not {pair.damper.n}; use AreaWeb")
        if not self._geometries[other].mesh.solid.has_inside:
            raise ValueError(
                f"a PointWeb needs a solid beside the sphere, and geometry "
                f"{self._geometries[other].name!r} has no inside; mend it, or use AreaWeb"
            )
        body = self._area_body(other)
        return _core.PointWeb(ball == pair.a, radii[ball], body, pair.damper.k, web.standoff)

    def _mesh(self, geometry: int) -> _core.Mesh:
        return self._geometries[geometry].mesh._core

    def _area_body(self, geometry: int) -> _core.AreaBody:
        mesh = self._geometries[geometry].mesh
        if mesh not in _area_bodies:
            _area_bodies[mesh] = mesh._area_body()
        return _area_bodies[mesh]


def _radius_of(mesh: CollisionMesh) -> float:
    """Return the radius [m] of a primitive sphere; infinite of what is none."""
    primitive = mesh.primitive
    return primitive.size[0] if primitive and primitive.kind == "sphere" else math.inf
