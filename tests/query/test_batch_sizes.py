"""Batches of no, one and two rows: each row is the single query's answer."""

import mesh_shapes
import numpy as np
import pytest

from contact_toolkit import (
    CollisionMesh,
    CSpaceClass,
    CSpaceModel,
    classify,
    classify_motions,
    distance,
    distance_batch,
    intersects,
    intersects_batch,
    signed_distance,
    swept_distance,
    swept_distance_batch,
    swept_intersects,
    swept_intersects_batch,
    time_of_impact,
    time_of_impact_batch,
)

pytestmark = pytest.mark.engine

CUBE = CollisionMesh(*mesh_shapes.cube())
SIDE = float(CUBE.upper[0] - CUBE.lower[0])


def _along_x(positions):
    X = np.tile(np.eye(4), (len(positions), 1, 1))
    X[:, 0, 3] = positions
    return X


START = _along_x(SIDE * np.array([1.5, 4.0]))
END = _along_x(SIDE * np.array([1.25, 0.5]))


@pytest.mark.parametrize("n", [0, 1, 2])
def test_queries_at_few_poses(n):
    """A batch that fails, or answers otherwise than one query, where it has next to no rows."""
    X = START[:n]
    found = distance_batch(CUBE, CUBE, X)
    assert found.distance.tolist() == [distance(CUBE, CUBE, each).distance for each in X]
    assert found.p_ACa.shape == (n, 3)
    touching = intersects_batch(CUBE, CUBE, X)
    assert touching.tolist() == [intersects(CUBE, CUBE, each) for each in X]
    points = SIDE * np.array([[3.0, 0.1, 0.2], [0.9, 0.1, 0.2]])[:n]
    assert signed_distance(CUBE, points).distance.tolist() == [
        float(signed_distance(CUBE, [each]).distance[0]) for each in points
    ]


@pytest.mark.parametrize("n", [0, 1, 2])
def test_queries_over_few_motions(n):
    """The same, of motions."""
    motions = list(zip(START[:n], END[:n], strict=True))
    found = swept_distance_batch(CUBE, CUBE, START[:n], END[:n])
    assert found.distance.tolist() == [swept_distance(CUBE, CUBE, *m).distance for m in motions]
    touching = swept_intersects_batch(CUBE, CUBE, START[:n], END[:n])
    assert touching.tolist() == [swept_intersects(CUBE, CUBE, *m) for m in motions]
    impacts = time_of_impact_batch(CUBE, CUBE, START[:n], END[:n])
    assert impacts.time.tolist() == [time_of_impact(CUBE, CUBE, *m).time for m in motions]


@pytest.mark.parametrize("n", [0, 1, 2])
@pytest.mark.parametrize("upper_bound", [np.inf, 100 * SIDE])
def test_classification_of_few_configurations(n, upper_bound):
    """One configuration, or one motion, whose bound was a view that cannot be written to."""
    model = CSpaceModel.from_shapes({"fixed": CUBE, "moving": CUBE})
    X = np.stack([_along_x([0.0] * 2), START], axis=1)[:n]
    found = classify(model, X, upper_bound=upper_bound)
    assert found.kind.tolist() == [CSpaceClass.FREE] * n
    assert found.distance == pytest.approx((SIDE * np.array([0.5, 3.0]))[:n])
    path = np.stack([_along_x([0.0] * 3), _along_x(SIDE * np.array([4.0, 2.0, 0.5]))], axis=1)
    motions = classify_motions(model, path[: n + 1], upper_bound=upper_bound)
    assert motions.kind.tolist() == [CSpaceClass.FREE, CSpaceClass.COLLIDING][:n]
    assert motions.distance == pytest.approx((SIDE * np.array([1.0, 0.0]))[:n])
