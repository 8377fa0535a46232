"""Find pairs of geometries that met somewhere on the way between two configurations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from contact_toolkit import ContactModel, ImpactStatus, time_of_impact

Floats = NDArray[np.float64]

# A search that gave up counts as met; a pair in touch at the start has been met before.
_MET = (ImpactStatus.IMPACT, ImpactStatus.ITERATION_LIMIT)


class SweptPasses:
    """Searches the pairs of a contact model; what cannot meet is left out by bounding spheres."""

    def __init__(self, model: ContactModel) -> None:
        self._geometries = model.geometries
        self._pairs = np.array([(pair.a, pair.b) for pair in model.pairs])
        self._body = np.array(model.geometry_bodies)
        self._X_BG = np.array([geometry.X_BG for geometry in model.geometries])
        meshes = [geometry.mesh for geometry in model.geometries]
        middles = np.array([(mesh.lower + mesh.upper) / 2 for mesh in meshes])
        self._p_BM = np.einsum("gij,gj->gi", self._X_BG[:, :3, :3], middles) + self._X_BG[:, :3, 3]
        self._radius = np.array([mesh.diagonal / 2 for mesh in meshes])

    def find(self, X_WB_start: Floats, X_WB_end: Floats, candidates: NDArray[np.intp]) -> list[int]:
        """Return the pairs, among candidates, that met on the way.

        Parameters
        ----------
        X_WB_start, X_WB_end
            (nb, 4, 4) poses of the bodies. In between, each pair's relative motion is taken as
            straight, with constant rotation.
        candidates
            Indices of pairs.

        Notes
        -----
        No pair that meets is missed, except one in touch at the very start; one that passes within
        a millionth of its size may be reported too.
        """
        met = []
        for pair in candidates[self._may_meet(X_WB_start, X_WB_end, candidates)]:
            a, b = self._pairs[pair]
            X_AB_start, X_AB_end = (
                np.linalg.inv(X_WB[self._body[a]] @ self._X_BG[a])
                @ X_WB[self._body[b]]
                @ self._X_BG[b]
                for X_WB in (X_WB_start, X_WB_end)
            )
            mesh_a, mesh_b = self._geometries[a].mesh, self._geometries[b].mesh
            if time_of_impact(mesh_a, mesh_b, X_AB_start, X_AB_end).status in _MET:
                met.append(int(pair))
        return met

    def _may_meet(
        self, X_WB_start: Floats, X_WB_end: Floats, candidates: NDArray[np.intp]
    ) -> NDArray[np.bool_]:
        """Tell which bounding spheres come within reach of each other."""
        starts, ends = (
            np.einsum("gij,gj->gi", X_WB[self._body, :3, :3], self._p_BM) + X_WB[self._body, :3, 3]
            for X_WB in (X_WB_start, X_WB_end)
        )
        # A middle off the body's origin leaves the straight line by at most the sagitta of its arc.
        cosine = (np.einsum("bij,bij->b", X_WB_start[:, :3, :3], X_WB_end[:, :3, :3]) - 1) / 2
        bulge = 1 - np.sqrt(np.clip((1 + cosine) / 2, 0, 1))
        reach = self._radius + np.linalg.norm(self._p_BM, axis=1) * bulge[self._body]
        a, b = self._pairs[candidates].T
        start, travel = starts[b] - starts[a], (ends[b] - starts[b]) - (ends[a] - starts[a])
        squared = np.einsum("ni,ni->n", travel, travel)
        fraction = np.divide(
            -np.einsum("ni,ni->n", start, travel),
            squared,
            where=squared > 0,
            out=np.zeros_like(squared),
        )
        nearest = start + np.clip(fraction, 0, 1)[:, None] * travel
        return np.linalg.norm(nearest, axis=1) <= reach[a] + reach[b]
