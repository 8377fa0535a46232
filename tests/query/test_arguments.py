"""What queries say of arguments that are not what they take, and what else they take."""

from pathlib import Path

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

import contact_toolkit as ct
from contact_toolkit.shapes.primitives import box

CUBE = ct.CollisionMesh(*box([0.1, 0.1, 0.1]))
X_AB = np.eye(4)

QUERIES = [
    lambda A, B: ct.distance(A, B, X_AB),
    lambda A, B: ct.intersects(A, B, X_AB),
    lambda A, B: ct.witness_pairs(A, B, X_AB, 0.01),
    lambda A, B: ct.swept_distance(A, B, X_AB, X_AB),
    lambda A, B: ct.swept_intersects(A, B, X_AB, X_AB),
    lambda A, B: ct.time_of_impact(A, B, X_AB, X_AB),
    lambda A, B: ct.distance_batch(A, B, X_AB[None]),
    lambda A, B: ct.intersects_batch(A, B, X_AB[None]),
    lambda A, B: ct.swept_distance_batch(A, B, X_AB[None], X_AB[None]),
    lambda A, B: ct.swept_intersects_batch(A, B, X_AB[None], X_AB[None]),
    lambda A, B: ct.time_of_impact_batch(A, B, X_AB[None], X_AB[None]),
]


@pytest.mark.parametrize("query", QUERIES)
def test_a_file_name_is_answered_with_what_to_write(query):
    # Otherwise: 'str' has no attribute '_core'.
    with pytest.raises(TypeError, match=r"A must be .* try CollisionMesh.from_file\('a.stl'\)"):
        query("a.stl", CUBE)
    with pytest.raises(TypeError, match=r"B must be .* try CollisionMesh.from_file\('a.stl'\)"):
        query(CUBE, Path("a.stl"))


def test_a_pose_may_be_drakes():
    X = RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [0.3, 0, 0])
    expected = ct.distance(CUBE, CUBE, X.GetAsMatrix4()).distance
    assert ct.distance(CUBE, CUBE, X).distance == expected
    assert ct.distance_batch(CUBE, CUBE, [X, X]).distance.tolist() == [expected, expected]
