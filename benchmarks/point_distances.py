"""Signed distances of points from a mesh, against Embree's unsigned ones and libigl's.

Why: the area web asks for the signed distance of every node, so its cost is that of forces. Embree
(through Open3D, in single precision, one thread) is the fastest there is at finding the closest
point, without a sign; libigl finds the same sign as we do, in double precision. Points near the
surface are what contact asks for; points all around are for comparison.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness import Row, Stopwatch
from benchmarks.real_parts import scan
from contact_toolkit import CollisionMesh, signed_distance
from scenarios.parts import Surface, bolt, doughnut, involute_gear

NAME = "signed distance"
TARGET = 1 / 3
_POINTS = 2000
_NEAR = 0.01  # [-] of the diagonal
_SINGLE_PRECISION = 3e-4  # [-] of the diagonal: what Embree's distances are off on long facets


def measure(watch: Stopwatch, coarser: int = 1) -> Iterator[Row]:
    """Compare closed parts, near the surface and all around."""
    parts = {
        "doughnut": doughnut(major_sections=64 // coarser, minor_sections=32 // coarser),
        "gear": involute_gear(0.002, 24, flank_points=max(2, 8 // coarser)),
        "bolt": bolt(sections=144 // coarser),
        "scan": scan(32 // coarser),
    }
    for name, surface in parts.items():
        mesh = CollisionMesh(*surface)
        for where, points in points_about(mesh, np.random.default_rng(8)).items():
            for yardstick, (theirs, target) in yardsticks(surface, points).items():
                row = watch.row(
                    NAME,
                    f"{name}, {where}, {yardstick}",
                    partial(signed_distance, mesh, points),
                    {yardstick: theirs},
                    target=target if where == "near" else None,
                    size=len(mesh.faces),
                    output=len(points),
                )
                ours = signed_distance(mesh, points).distance
                np.testing.assert_allclose(
                    np.abs(np.ravel(theirs())), np.abs(ours), atol=_SINGLE_PRECISION * mesh.diagonal
                )
                yield row


def points_about(mesh: CollisionMesh, rng: np.random.Generator) -> dict[str, NDArray[np.float64]]:
    """Return points near the surface, in no order, and all around it."""
    facets = mesh.vertices[mesh.faces]
    areas = np.linalg.norm(
        np.cross(facets[:, 1] - facets[:, 0], facets[:, 2] - facets[:, 0]), axis=1
    )
    chosen = facets[rng.choice(len(facets), _POINTS, p=areas / areas.sum())]
    on_surface = np.einsum("nk,nki->ni", rng.dirichlet(np.ones(3), _POINTS), chosen)
    off = rng.normal(size=(_POINTS, 3))
    off *= (
        _NEAR
        * mesh.diagonal
        * rng.uniform(size=(_POINTS, 1))
        / np.linalg.norm(off, axis=1)[:, None]
    )
    around = rng.uniform(mesh.lower, mesh.upper, (_POINTS, 3))
    return {"near": on_surface + off, "around": around}


def yardsticks(
    surface: Surface, points: NDArray[np.float64]
) -> dict[str, tuple[Callable[[], NDArray[np.floating]], float | None]]:
    """Return what is called, and the least acceptable ratio, by name."""
    import igl
    import open3d as o3d

    vertices, faces = surface
    scene = o3d.t.geometry.RaycastingScene(nthreads=1)
    scene.add_triangles(vertices.astype(np.float32), faces.astype(np.uint32))
    queries = o3d.core.Tensor(points.astype(np.float32))
    wide = faces.astype(np.int64)
    return {
        "Embree": (lambda: scene.compute_distance(queries, nthreads=1).numpy(), TARGET),
        "libigl": (lambda: igl.signed_distance(points, vertices, wide)[0], 1.0),
    }
