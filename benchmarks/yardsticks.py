"""coal and python-fcl, each on its fastest hierarchy of oriented boxes, asked what we are asked."""

from __future__ import annotations

import coal
import fcl
import numpy as np
from numpy.typing import NDArray

from scenarios.parts import Surface

_UNLIMITED = 2**31 - 1  # contacts


class Coal:
    """Two meshes in coal: oriented boxes with swept spheres (OBBRSS)."""

    def __init__(self, A: Surface, B: Surface) -> None:
        self._A = self.build(A)
        self._B = self._A if B is A else self.build(B)
        self._X_A = coal.Transform3s()
        self._contacts, self._closest = coal.CollisionResult(), coal.DistanceResult()
        self._distance = coal.DistanceRequest()

    @staticmethod
    def build(surface: Surface) -> coal.BVHModelOBBRSS:
        """Return a mesh with its hierarchy."""
        vertices, faces = surface
        mesh = coal.BVHModelOBBRSS()
        mesh.beginModel(len(faces), len(vertices))
        mesh.addVertices(vertices)
        mesh.addTriangles(faces.astype(np.int64))
        mesh.endModel()
        return mesh

    def witness_pairs(self, X_AB: NDArray[np.float64], standoff: float) -> int:
        """Find all facet pairs within the standoff; return their number."""
        request = coal.CollisionRequest()
        request.enable_contact = True
        request.security_margin = standoff
        request.num_max_contacts = _UNLIMITED
        self._contacts.clear()
        coal.collide(self._A, self._X_A, self._B, _coal_pose(X_AB), request, self._contacts)
        return self._contacts.numContacts()

    def facets(self) -> set[tuple[int, int]]:
        """Return the facet pairs of the last call of `witness_pairs`."""
        return {(contact.b1, contact.b2) for contact in self._contacts.getContacts()}

    def distance(self, X_AB: NDArray[np.float64]) -> float:
        """Return the least distance [m]."""
        self._closest.clear()
        return coal.distance(
            self._A, self._X_A, self._B, _coal_pose(X_AB), self._distance, self._closest
        )


class Fcl:
    """Two meshes in FCL."""

    def __init__(self, A: Surface, B: Surface) -> None:
        self._A, self._B = (fcl.CollisionObject(_fcl_mesh(surface)) for surface in (A, B))
        self._request = fcl.DistanceRequest(enable_nearest_points=True)

    def distance(self, X_AB: NDArray[np.float64]) -> float:
        """Return the least distance [m]."""
        self._B.setTransform(fcl.Transform(X_AB[:3, :3], X_AB[:3, 3]))
        return fcl.distance(self._A, self._B, self._request, fcl.DistanceResult())


def _coal_pose(X: NDArray[np.float64]) -> coal.Transform3s:
    return coal.Transform3s(X[:3, :3].copy(), X[:3, 3].copy())


def _fcl_mesh(surface: Surface) -> fcl.BVHModel:
    vertices, faces = surface
    mesh = fcl.BVHModel()
    mesh.beginModel(len(faces), len(vertices))
    mesh.addSubModel(vertices, faces)
    mesh.endModel()
    return mesh
