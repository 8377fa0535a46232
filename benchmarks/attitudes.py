"""Parts as they come, in attitudes that nobody chose.

A pair of generated parts is measured where its features line up or nearly so. Here B is turned at
random and comes from a random side: near A, into A, and far from it. Any folder of mesh files can
be measured like that.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.mesh_pairs import MeshPair, Pose, approach, pose
from contact_toolkit import CollisionMesh, MeshError
from scenarios.parts import Surface

_STANDOFF = 0.01  # [-] of the smaller part's diagonal
_DEPTHS = (0.02, 0.15)  # [-] of the same: how far B goes on beyond where it is near


def in_any_attitude(name: str, A: Surface, B: Surface, seed: int) -> MeshPair:
    """Return two parts with B at random near A, crossing it, and far from it."""
    meshes = CollisionMesh(*A), CollisionMesh(*B)
    size = min(mesh.diagonal for mesh in meshes)
    rng = np.random.default_rng(seed)
    poses: dict[str, Pose] = {}
    for index, depth in enumerate(_DEPTHS, start=1):
        near, direction = _near(*meshes, 0.3 * _STANDOFF * size, rng)
        crossing = near.copy()
        crossing[:3, 3] += depth * size * direction
        poses |= {f"near {index}": near, f"crossing {index}": crossing}
    far = poses["near 1"].copy()
    far[:3, 3] *= 1.0 + 2.0 * sum(mesh.diagonal for mesh in meshes) / np.linalg.norm(far[:3, 3])
    return MeshPair(name, A, B, {**poses, "far": far}, (_STANDOFF * size,))


def _near(
    A: CollisionMesh, B: CollisionMesh, gap: float, rng: np.random.Generator
) -> tuple[Pose, np.ndarray]:
    """Return a pose of B `gap` [m] from A, and the direction it came from its random side."""
    middles = [0.5 * (mesh.lower + mesh.upper) for mesh in (A, B)]
    while True:
        turn = Rotation.random(rng=rng)
        towards_A = rng.normal(size=3)
        towards_A /= np.linalg.norm(towards_A)
        aim = 0.2 * A.diagonal * rng.uniform(-1.0, 1.0, 3)
        start = middles[0] + aim - (A.diagonal + B.diagonal) * towards_A - turn.apply(middles[1])
        X_AB = approach(A, B, pose(turn, start), towards_A, gap)
        if X_AB is not None:
            return X_AB, towards_A


def translated_at_random(X_AB: Pose, size: float, rng: np.random.Generator) -> Pose:
    """Return a pose some way off, between a ten-thousandth of the size [m] and all of it."""
    way = rng.normal(size=3)
    X_end = X_AB.copy()
    X_end[:3, 3] += size * 10.0 ** rng.uniform(-4.0, 0.0) * way / np.linalg.norm(way)
    return X_end


def parts_in_folder(folder: Path) -> Iterator[tuple[str, Surface]]:
    """Read all mesh files of a folder, in the order of their names; say which cannot be used."""
    for path in sorted(folder.iterdir()):
        try:
            mesh = CollisionMesh.from_file(path)
        except (MeshError, ValueError) as error:
            print(f"  {path.name} is left out: {error}")
            continue
        yield path.stem, (mesh.vertices, mesh.faces)


def each_with_itself_and_the_next(parts: Iterable[tuple[str, Surface]]) -> Iterator[MeshPair]:
    """Pair every part with a copy of itself, and with the one that follows."""
    parts = list(parts)
    for index, (name, surface) in enumerate(parts):
        yield in_any_attitude(f"{name} on itself", surface, surface, seed=2 * index)
        other, following = parts[(index + 1) % len(parts)]
        if other != name:
            pair_name = f"{name} and {other}"
            yield in_any_attitude(pair_name, surface, following, seed=2 * index + 1)
