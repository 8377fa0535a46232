"""CommonInside: how much of two geometries lies within both, whatever their surfaces do."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from contact_toolkit import CollisionMesh, ContactModel, signed_distance

Floats = NDArray[np.float64]

_VERTICES = 16  # of a geometry, towards which points are tried
_SHARES = np.array([0.25, 0.5, 0.75])  # [-] of the way from its middle to them


class CommonInside:
    """Finds pairs of a contact model that lie in each other.

    Surfaces that coincide, as of a robot's two legs drawn at one place, or of a pin in a bore drawn
    as a solid, are nowhere deep in each other, and their springs hardly push; yet each is inside
    the other. Points inside of the smaller one tell.

    Parameters
    ----------
    model
        The contact model.
    """

    def __init__(self, model: ContactModel) -> None:
        self._model = model
        self._body_of = np.array(model.geometry_bodies)
        self._pairs = np.array([(pair.a, pair.b) for pair in model.pairs])
        meshes = [geometry.mesh for geometry in model.geometries]
        self._middle_G = np.array([(mesh.lower + mesh.upper) / 2 for mesh in meshes])
        self._radius = np.array([mesh.diagonal / 2 for mesh in meshes])
        self._X_BG = np.array([geometry.X_BG for geometry in model.geometries])
        self._inside: dict[CollisionMesh, tuple[Floats, Floats]] = {}

    def find(self, X_FB: Floats) -> dict[int, float]:
        """Return the radius [m] of the largest ball found within both sides of a pair, by pair."""
        X_FG = X_FB[self._body_of] @ self._X_BG
        middle = np.einsum("nij,nj->ni", X_FG[:, :3, :3], self._middle_G) + X_FG[:, :3, 3]
        a, b = self._pairs.T
        apart = np.linalg.norm(middle[a] - middle[b], axis=1)
        near = np.flatnonzero(apart < self._radius[a] + self._radius[b])
        radii = {int(pair): self._ball_in(a[pair], b[pair], X_FG) for pair in near}
        return {pair: radius for pair, radius in radii.items() if radius > 0}

    def _ball_in(self, a: int, b: int, X_FG: Floats) -> float:
        small, large = sorted((a, b), key=lambda side: self._radius[side])
        other = self._model.geometries[large].mesh
        points, depths = self._inside_of(self._model.geometries[small].mesh)
        if not len(points) or not other.solid.has_inside:
            return 0.0
        X_LS = np.linalg.inv(X_FG[large]) @ X_FG[small]
        posed = points @ X_LS[:3, :3].T + X_LS[:3, 3]
        bounded = ((posed > other.lower) & (posed < other.upper)).all(axis=1)
        if not bounded.any():
            return 0.0
        within = -signed_distance(other, posed[bounded]).distance
        return float(np.minimum(within, depths[bounded]).max())

    def _inside_of(self, mesh: CollisionMesh) -> tuple[Floats, Floats]:
        """Return points (n, 3) inside of a mesh, in its frame, and how deep they are (n,)."""
        if mesh not in self._inside:
            points = np.zeros((0, 3))
            depths = np.zeros(0)
            if mesh.solid.has_inside:
                middle = (mesh.lower + mesh.upper) / 2
                chosen = np.linspace(0, len(mesh.vertices) - 1, _VERTICES).astype(int)
                ways = _SHARES[:, None, None] * (mesh.vertices[chosen] - middle)
                points = middle + np.concatenate([np.zeros((1, 3)), ways.reshape(-1, 3)])
                depths = -signed_distance(mesh, points).distance
                points, depths = points[depths > 0], depths[depths > 0]
            self._inside[mesh] = points, depths
        return self._inside[mesh]
