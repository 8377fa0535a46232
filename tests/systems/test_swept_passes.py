"""SweptPasses: what meets on an arc, off the straight line between the ends, is found."""

import mesh_shapes
import numpy as np
from scipy.spatial.transform import Rotation

from contact_toolkit import (
    CollisionMesh,
    ContactGeometry,
    ContactModel,
    ContactPair,
    NonlinearDamper,
)
from systems.monitors.swept_passes import SweptPasses


def test_a_geometry_on_a_long_arm_meets_what_lies_beyond_the_chord():
    """A bounding sphere moved straight, which the geometry leaves by the sagitta of its arc."""
    vertices, faces = mesh_shapes.cube()
    vertices = 0.02 * (vertices - vertices.mean(axis=0))
    geometries = [
        ContactGeometry("post", "world", CollisionMesh(vertices, faces)),
        ContactGeometry("hand", "arm", CollisionMesh(vertices + np.array([1.0, 0, 0]), faces)),
    ]
    model = ContactModel(["arm", "world"], geometries, [ContactPair(0, 1, NonlinearDamper(1e6))])
    angle = 2.5
    start, end = np.tile(np.eye(4), (2, 2, 1, 1))
    end[0, :3, :3] = Rotation.from_rotvec([0, 0, angle]).as_matrix()
    for radius, met in ((1.0, [0]), (1.1, []), (np.cos(angle / 2), [])):
        start[1, :3, 3] = radius * np.array([np.cos(angle / 2), np.sin(angle / 2), 0])
        end[1] = start[1]
        assert SweptPasses(model).find(start, end, np.array([0])) == met
