"""A bin filling up with non-convex parts: 25, 50, 100 and 200 bodies, any of which may touch any.

Why: many bodies are cheap only if the pairs that do not touch are. Cost must grow as the number of
touching pairs, so the time per touching pair is compared with that in bins of 25 bodies.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, cycle

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.harness import Row, Stopwatch
from benchmarks.mesh_pairs import Pose, approach, pose
from contact_toolkit import (
    CollisionMesh,
    ContactGeometry,
    ContactModel,
    ContactPair,
    FacetWeb,
    NonlinearDamper,
)
from scenarios.parts import box, bumpy_sphere, doughnut, hole_plate, involute_gear

NAME = "bin of parts"
COUNTS = (25, 50, 100, 200)
_WIDTH = 0.07  # [m] of the bin, square
_STANDOFF = 0.0005  # [m]
_GAP = 0.0001  # [m] at which a falling part comes to rest
_STEP = 1e-6  # [m] from evaluation to evaluation


def measure(watch: Stopwatch, coarser: int = 1) -> Iterator[Row]:
    """Evaluate the contact in 8 bins of 25 bodies, 4 of 50, 2 of 100 and one of 200.

    The same number of bodies each time, as the few pairs of one small bin prove nothing.
    """
    first = None
    for bodies in (count // coarser for count in COUNTS):
        bins = [filling(bodies, seed) for seed in range(COUNTS[-1] // coarser // bodies)]
        models = [contact_model(meshes) for meshes, _ in bins]
        paths = [cycle([jolted(X_WB, seed) for seed in range(8)]) for _, X_WB in bins]
        V_WB = np.zeros((bodies, 6))

        def evaluate(models=models, paths=paths, V_WB=V_WB) -> None:
            for model, path in zip(models, paths, strict=True):
                model.evaluate(next(path), V_WB)

        touching = sum(
            len(model.find(X_WB).pairs) for model, (_, X_WB) in zip(models, bins, strict=True)
        )
        (seconds,) = watch.medians(evaluate)
        first = first or seconds / touching
        yield Row(
            NAME,
            f"{len(bins)} × {bodies} bodies, per touching pair",
            f"{COUNTS[0] // coarser} bodies",
            seconds / touching,
            first,
            target=0.8,
            size=bodies,
            output=touching,
        )


def contact_model(meshes: list[CollisionMesh], *, threads: int = 1) -> ContactModel:
    """Return a model in which each body wears a facet web, and all may touch."""
    names = [f"body {i}" for i in range(len(meshes))]
    damper = NonlinearDamper(k=1e4, alpha=0.3)
    return ContactModel(
        names,
        [ContactGeometry(name, name, mesh) for name, mesh in zip(names, meshes, strict=True)],
        [
            ContactPair(a, b, damper, FacetWeb(_STANDOFF))
            for a, b in combinations(range(len(meshes)), 2)
        ],
        threads=threads,
    )


def filling(bodies: int, seed: int = 0) -> tuple[list[CollisionMesh], Pose]:
    """Return each body's mesh and pose in W, (bodies, 4, 4).

    Each part falls straight down, turned at random, onto the first it meets. The floor it may meet
    is none of the bodies: contact with it is cheaper, and rarer the fuller the bin.
    """
    shapes = [
        CollisionMesh(*surface)
        for surface in (
            doughnut(0.009, 0.003, 32, 16),
            involute_gear(0.001, 20, width=0.006, bore_radius=0.004, flank_points=4, rows=2),
            bumpy_sphere(0.009, frequency=7),
            hole_plate(0.004, size=0.016, thickness=0.004, sections=32, rings=4),
        )
    ]
    meshes = [CollisionMesh(*box(2 * _WIDTH, 2 * _WIDTH, 0.01))]
    poses = [pose(Rotation.identity(), [0.0, 0.0, -0.005])]
    rng = np.random.default_rng(seed)
    for i in range(bodies):
        mesh = shapes[i % len(shapes)]
        top = max(X[2, 3] for X in poses) + 0.05
        across = rng.uniform(-0.5, 0.5, 2) * _WIDTH
        X_WB = pose(Rotation.random(rng=rng), [*across, top])
        landed = [
            X_WA @ X_AB
            for X_WA, other in zip(poses, meshes, strict=True)
            if (X_AB := _fallen(other, mesh, X_WA, X_WB)) is not None
        ]
        meshes.append(mesh)
        poses.append(max(landed, key=lambda X: X[2, 3]))
    return meshes[1:], np.stack(poses[1:])


def jolted(X_WB: Pose, seed: int) -> Pose:
    """Return the poses, each body shifted by a micrometre or so."""
    X_WB = X_WB.copy()
    X_WB[:, :3, 3] += _STEP * np.random.default_rng(seed).standard_normal((len(X_WB), 3))
    return X_WB


def _fallen(A: CollisionMesh, B: CollisionMesh, X_WA: Pose, X_WB: Pose) -> Pose | None:
    """Return the pose in A at which B, falling along -z of W, comes to rest on A, if it does."""
    if np.linalg.norm(X_WA[:2, 3] - X_WB[:2, 3]) > (A.diagonal + B.diagonal) / 2:
        return None
    X_AW = np.linalg.inv(X_WA)
    return approach(A, B, X_AW @ X_WB, X_AW[:3, :3] @ [0.0, 0.0, -1.0], _GAP)
