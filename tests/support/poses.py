"""Poses to try queries at, as (4,4) homogeneous matrices."""

import numpy as np
from numpy.typing import NDArray


def random_rotation(rng: np.random.Generator) -> NDArray[np.float64]:
    """A rotation matrix, uniform over the rotations."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    q[:, 0] *= np.sign(np.linalg.det(q))
    return q


def pose(
    R: NDArray[np.float64] | None = None, p: tuple[float, ...] = (0, 0, 0)
) -> NDArray[np.float64]:
    """The pose with rotation `R` (identity by default) and position `p` [m]."""
    X = np.eye(4)
    X[:3, :3] = np.eye(3) if R is None else R
    X[:3, 3] = p
    return X


def random_pose(rng: np.random.Generator, reach: float) -> NDArray[np.float64]:
    """Any rotation, and a position no further than `reach` [m] away."""
    direction = rng.normal(size=3)
    length = reach * rng.uniform() / np.linalg.norm(direction)
    return pose(random_rotation(rng), tuple(length * direction))


def inverse(X: NDArray[np.float64]) -> NDArray[np.float64]:
    """The inverse of a rigid transform."""
    return pose(X[:3, :3].T, tuple(-X[:3, :3].T @ X[:3, 3]))
