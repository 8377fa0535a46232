"""The pairs of meshes that the queries are measured on, and the poses they are measured at.

All are made by the project's own generators. Each has an aligned pose, where boxes along the axes
fit best, and general ones, where they do not.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from contact_toolkit import CollisionMesh, distance
from scenarios.parts import (
    Surface,
    bolt,
    bumpy_sphere,
    doughnut,
    hole_plate,
    involute_gear,
    nut,
    peg,
    truncated_cone,
)

Pose = NDArray[np.float64]


@dataclass(frozen=True)
class MeshPair:
    """Two surfaces, poses of B in A by name, and the standoffs [m] of interest."""

    name: str
    A: Surface
    B: Surface
    poses: dict[str, Pose]
    standoffs: tuple[float, ...]

    @property
    def facets(self) -> int:
        """Of both."""
        return len(self.A[1]) + len(self.B[1])

    def meshes(self) -> tuple[CollisionMesh, CollisionMesh]:
        """Return both as collision meshes."""
        return CollisionMesh(*self.A), CollisionMesh(*self.B)


def pose(rotation: Rotation, translation: ArrayLike) -> Pose:
    """Return a rotation and a translation [m] as a (4, 4) matrix."""
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = rotation.as_matrix(), translation
    return X


def approach(
    A: CollisionMesh, B: CollisionMesh, X_AB: Pose, direction_A: ArrayLike, gap: float
) -> Pose | None:
    """Return where B, moving from X_AB along a unit vector, is first `gap` [m] from A, if anywhere.

    Conservative advancement: B moves as far as it certainly may, until they are certainly past.
    """
    X_AB, direction_A = X_AB.copy(), np.asarray(direction_A)
    past = np.linalg.norm(X_AB[:3, 3]) + A.diagonal + B.diagonal
    while X_AB[:3, 3] @ direction_A < past:
        free = distance(A, B, X_AB).distance - gap
        if free < 1e-3 * gap:
            return X_AB
        X_AB[:3, 3] += free * direction_A
    return None


def doughnut_on_cone(coarser: int = 1) -> MeshPair:
    """The Rock-N-Stack: upright and just off centre, tilted, thrown over at random, beside."""
    A = truncated_cone(sections=128 // coarser, rings=40 // coarser)
    B = doughnut(major_sections=64 // coarser, minor_sections=32 // coarser)
    meshes = CollisionMesh(*A), CollisionMesh(*B)
    above, aside, gap = [0.001, 0.0, 0.4], [0.3, 0.0, 0.12], 0.0005
    tilt = Rotation.from_euler("zyx", [25.0, 12.0, -7.0], degrees=True)
    askew = Rotation.random(2, np.random.default_rng(1))
    return MeshPair(
        "doughnut on cone",
        A,
        B,
        {
            "aligned": pose(Rotation.identity(), [0.001, 0.0, 0.178]),
            "tilted": approach(*meshes, pose(tilt, above), [0.0, 0.0, -1.0], gap),
            "askew on top": approach(*meshes, pose(askew[0], above), [0.0, 0.0, -1.0], gap),
            "askew beside": approach(*meshes, pose(askew[1], aside), [-1.0, 0.0, 0.0], gap),
        },
        (0.002, 0.004, 0.008),
    )


def nut_on_bolt(coarser: int = 1) -> MeshPair:
    """M16 nut on its bolt with true helical threads: contact all along the helix."""
    pitch, turn = 0.002, 1.234
    screwed = Rotation.from_euler("z", turn)
    tilted = Rotation.from_euler("xy", [0.0015, -0.001]) * screwed
    height = pitch * (6 + turn / (2 * np.pi))
    return MeshPair(
        "nut on bolt",
        bolt(sections=144 // coarser),
        nut(sections=144 // coarser),
        {
            "aligned": pose(Rotation.identity(), [0.0, 0.0, 6 * pitch]),
            "screwed": pose(screwed, [0.0, 0.0, height]),
            "screwed, tilted": pose(tilted, [1e-5, 2e-5, height + 1e-5]),
        },
        (0.0002,),
    )


def meshing_gears(coarser: int = 1) -> MeshPair:
    """Two involute gears of 24 and 36 teeth; the second sits π/36 on, a gap against a tooth."""
    module, teeth, fine = 0.002, (24, 36), 8 // coarser
    A, B = (
        involute_gear(module, n, backlash=1e-4, flank_points=max(2, fine), rows=max(1, fine))
        for n in teeth
    )
    apart = module * sum(teeth) / 2

    def meshed(angle: float, tilt: float = 0.0) -> Pose:
        """B's pose in A with A turned by `angle` [rad], the line of centres tilted a little."""
        R_WA = Rotation.from_euler("z", angle)
        R_WB = Rotation.from_euler("z", np.pi / teeth[1] - angle * teeth[0] / teeth[1])
        lean = Rotation.from_euler("xy", [tilt, 0.5 * tilt])
        return pose(R_WA.inv() * lean * R_WB, R_WA.inv().apply([apart, 0.0, 10 * tilt * module]))

    poses = {"aligned": meshed(0.0), "turned": meshed(0.3), "turned, tilted": meshed(0.8, 0.003)}
    return MeshPair("meshing gears", A, B, poses, (0.0002,))


def peg_in_hole(coarser: int = 1) -> MeshPair:
    """A peg 25 mm deep in a hole with 0.05 mm clearance all round; long thin facets."""
    A = hole_plate(sections=96 // coarser, rings=12 // coarser)
    B = peg(sections=96 // coarser, rings=20 // coarser, radius=0.00995 if coarser == 1 else 0.0097)
    turned = Rotation.from_euler("z", 0.7)
    return MeshPair(
        "peg in hole",
        A,
        B,
        {
            "aligned": pose(Rotation.identity(), [0.0, 0.0, -0.025]),
            "turned": pose(turned, [5e-6, -1e-5, -0.0251]),
            "turned, tilted": pose(
                Rotation.from_euler("xy", [0.001, -0.0005]) * turned, [1e-5, 2e-5, -0.0252]
            ),
        },
        (0.0002,),
    )


def bumpy_spheres(frequency: int = 32, standoff: float = 0.001) -> MeshPair:
    """Two bumpy spheres of 20 frequency² facets each, 0.1 mm apart."""
    surface = bumpy_sphere(frequency=frequency)
    mesh, rng = CollisionMesh(*surface), np.random.default_rng(3)
    poses = {
        name: approach(mesh, mesh, pose(rotation, [0.2, 0.0, 0.0]), [-1.0, 0.0, 0.0], 1e-4)
        for name, rotation in zip(
            ("aligned", "askew 1", "askew 2", "askew 3"),
            (Rotation.identity(), *Rotation.random(3, rng)),
            strict=True,
        )
    }
    return MeshPair(
        f"bumpy spheres, {len(surface[1])} facets", surface, surface, poses, (standoff,)
    )


def reframed(pair: MeshPair) -> MeshPair:
    """Return the same bodies at the same poses, B's mesh in a frame that no feature follows."""
    X_BC = pose(Rotation.from_rotvec([0.4, 0.8, -0.5]), [0.01, -0.02, 0.005])
    vertices, faces = pair.B
    return replace(
        pair,
        name=f"{pair.name}, frames askew",
        B=((vertices - X_BC[:3, 3]) @ X_BC[:3, :3], faces),
        poses={name: X_AB @ X_BC for name, X_AB in pair.poses.items() if name != "aligned"},
    )


def all_pairs(coarser: int = 1) -> list[MeshPair]:
    """Return every pair; `coarser` divides the number of sections."""
    fitted = [nut_on_bolt(coarser), meshing_gears(coarser), peg_in_hole(coarser)]
    return [
        doughnut_on_cone(coarser),
        *fitted,
        *(reframed(pair) for pair in fitted),
        bumpy_spheres(32 // coarser),
    ]
