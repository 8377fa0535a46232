"""The hierarchy's own axes: a part costs the same however it lies in its file."""

import mesh_shapes
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from contact_toolkit import CollisionMesh

pytestmark = pytest.mark.engine


def box_volumes(mesh, depth):
    """The volumes of the boxes at a depth, from their corners 1, 2 and 4 seen from corner 0."""
    corners = mesh.hierarchy_boxes(depth)
    return np.abs(np.linalg.det(corners[:, [1, 2, 4]] - corners[:, :1]))


def plate():
    """A flat box of many facets: 4 × 3 × 0.1."""
    vertices, faces = mesh_shapes.cube()
    for _ in range(4):
        vertices, faces = mesh_shapes.subdivided(vertices, faces)
    return (vertices - vertices.min(axis=0)) * [4.0, 3.0, 0.1] / np.ptp(vertices, axis=0), faces


@pytest.mark.parametrize("seed", range(5))
def test_boxes_turn_with_the_part(seed):
    # Along the file's axes a plate that lies askew would fill a few per cent of its boxes.
    vertices, faces = plate()
    turned = vertices @ Rotation.random(rng=np.random.default_rng(seed)).as_matrix().T
    aligned, askew = (CollisionMesh(points, faces) for points in (vertices, turned))
    for depth in range(2):
        assert box_volumes(askew, depth).sum() < 1.5 * box_volumes(aligned, depth).sum()


@pytest.mark.parametrize("offset", [0.0, 1e4])
def test_boxes_hold_the_part(offset):
    # A box too small by a rounding, far from the origin above all, would lose pairs.
    vertices, faces = plate()
    turned = vertices @ Rotation.random(rng=np.random.default_rng(9)).as_matrix().T + offset
    mesh = CollisionMesh(turned, faces)
    corners = mesh.hierarchy_boxes(0)
    axes = (corners[:, [1, 2, 4]] - corners[:, :1]).transpose(1, 0, 2)[:, 0]
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    along = (mesh.vertices - offset) @ axes.T
    low, high = ((corners - offset)[:, k] @ axes.T for k in (0, 7))
    slack = 4e-16 * offset
    inside = (along[:, None] >= low - slack) & (along[:, None] <= high + slack)
    assert inside.all(axis=2).any(axis=1).all()


def test_a_part_along_its_files_axes_keeps_them():
    # Other axes for nothing would make boxes of parts that line up overlap where they touch.
    corners = CollisionMesh(*plate()).hierarchy_boxes(0)
    sides = corners[:, [1, 2, 4]] - corners[:, :1]
    off_axis = sides - np.einsum("nii->ni", sides)[:, :, None] * np.eye(3)
    np.testing.assert_allclose(off_axis, 0.0, atol=1e-6)
