"""Distances where the line of the best pair bounds what boxes cannot: askew faces, far away."""

import mesh_shapes
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from contact_toolkit import CollisionMesh, _core, distance, swept_distance

pytestmark = pytest.mark.engine

CUBE = mesh_shapes.cube()
for _ in range(3):
    CUBE = mesh_shapes.subdivided(*CUBE)
SHAPES = {"doughnut": mesh_shapes.doughnut(24, 16), "cone": mesh_shapes.cone(64, 6), "cube": CUBE}


def least_of_all(A, B, X_AB):
    """The least distance of every facet of A to every facet of B."""
    facets = np.meshgrid(*(np.arange(len(mesh.faces), dtype=np.int32) for mesh in (A, B)))
    a, b = (np.ascontiguousarray(indices.reshape(-1)) for indices in facets)
    return _core.facet_distances(A._core, B._core, X_AB, a, b).min()


@pytest.mark.parametrize("apart", [0.0, 1e-9, 0.01, 1.0, 30.0, 1e7])
@pytest.mark.parametrize("name", SHAPES)
def test_no_closer_facets_are_passed_over(name, apart):
    rng = np.random.default_rng(7)
    vertices, faces = SHAPES[name]
    A = CollisionMesh(vertices @ Rotation.random(rng=rng).as_matrix(), faces)
    B = CollisionMesh(vertices @ Rotation.random(rng=rng).as_matrix() + 0.3, faces)
    for _ in range(4):
        X_AB = np.eye(4)
        X_AB[:3, :3] = Rotation.random(rng=rng).as_matrix()
        direction = rng.standard_normal(3)
        direction /= np.linalg.norm(direction)
        X_AB[:3, 3] = A.diagonal * direction - X_AB[:3, :3] @ [0.3, 0.3, 0.3]
        for _ in range(20):
            X_AB[:3, 3] += (apart - distance(A, B, X_AB).distance) * direction
        assert distance(A, B, X_AB).distance == least_of_all(A, B, X_AB)


@pytest.mark.parametrize("far", [1e2, 1e3, 1e4, 1e5])
def test_far_bodies_of_many_facets(far):
    """Other facets are closer, or so many are measured (seconds a query) that this never ends."""
    rng = np.random.default_rng(8)
    A, B = (CollisionMesh(*mesh_shapes.doughnut(160, 80, major=0.1, minor=0.05)) for _ in range(2))
    for _ in range(20):
        X_AB = np.eye(4)
        X_AB[:3, :3] = Rotation.random(rng=rng).as_matrix()
        direction = rng.standard_normal(3)
        X_AB[:3, 3] = far * direction / np.linalg.norm(direction)
        X_end = X_AB.copy()
        X_end[:3, 3] += 0.05 * rng.standard_normal(3)
        for ends, found in (
            ((X_AB,), distance(A, B, X_AB)),
            ((X_AB, X_end), swept_distance(A, B, X_AB, X_end)),
        ):
            n = (found.p_ACa - found.p_ACb) / found.distance
            b_A = [B.vertices @ X[:3, :3].T + X[:3, 3] for X in ends]
            separation = (A.vertices @ n).min() - max((b @ n).max() for b in b_A)
            assert abs(found.distance - separation) < 1e-15 * far
