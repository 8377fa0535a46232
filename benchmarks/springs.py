"""How many springs a contact takes by default, how far its force is from the truth, what it costs.

Run from the root of the project: `python -m benchmarks.springs [--out FILE]`. Prints a Markdown
table and writes it where asked: `benchmarks/SPRINGS.md` is such a file. Beside each figure stands
what the former rule gave: nodes at 2 % of the smaller diagonal everywhere, a quarter of that along
sharp edges, primitives as their meshes, a spline for a field throughout. Takes about a minute.
"""

from __future__ import annotations

import argparse
import math
import statistics
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

from area_experiments import doughnut_and_cone, pose

from contact_toolkit import (
    CollisionMesh,
    ContactGeometry,
    ContactModel,
    ContactPair,
    NonlinearDamper,
)
from contact_toolkit.shapes.primitives import Primitive
from scenarios import parts

HEADING = """# Springs of a contact: how many, how right, what they cost

Made by `python -m benchmarks.springs --out benchmarks/SPRINGS.md`. Errors are of the force at the
depth where the contact bears its usual load; cold: nothing remembered; times are of the thread, on
this machine. "Before" is the rule before nodes followed need, measured by the same program.

"""

# name: (springs, error, cold evaluation [µs]) of the former rule
BEFORE: dict[str, tuple[int, str, int]] = {"the same, of meshes": (9152, "+0.01 %", 915)}


def primitive(kind: str, *size: float) -> CollisionMesh:
    return CollisionMesh.from_primitive(Primitive(kind, size))


def cases() -> Iterator[tuple[str, CollisionMesh, CollisionMesh, np.ndarray, float, float | None]]:
    """Name, floor, body, pose of the body, K and the true force upwards [N], if it is known."""
    slab, K = primitive("box", 4, 2, 0.2), 1e9
    depth = 5e-6
    box = primitive("box", 0.2, 0.2, 0.1)
    yield "box face on a slab", slab, box, pose([0.0123, 0.0077, 0.15 - depth]), K, K * 0.04 * depth
    yield (
        "the same, of meshes",
        CollisionMesh(*parts.box(4, 2, 0.2)),
        CollisionMesh(*parts.box(0.2, 0.2, 0.1)),
        pose([0.0123, 0.0077, 0.15 - depth]),
        K,
        K * 0.04 * depth,
    )
    cube = primitive("box", 0.1, 0.1, 0.1)
    mesh_cube = CollisionMesh(*parts.box())
    for name, each in (("flush cubes", cube), ("flush cubes, of meshes", mesh_cube)):
        yield name, each, each, pose([0, 0, 0.1 - depth]), K, K * 0.01 * depth
    yield (
        "cube half over another",
        cube,
        cube,
        pose([0.0505, 0, 0.1 - depth]),
        K,
        K * 0.00495 * depth,
    )
    on_edge = pose([0.01, 0.02, 0.1 + 0.05 * math.sqrt(2) - 1e-4], _turned([math.pi / 4, 0, 0]))
    yield "cube edge on a slab", slab, cube, on_edge, K, math.sqrt(2) * K * 0.1 * 1e-8
    tilt = math.atan(math.sqrt(2))
    corner = _turned([0, 0, 0.3]) @ _turned(tilt * np.array([1, -1, 0]) / math.sqrt(2))
    on_corner = pose([0.01, 0.02, 0.1 + 0.05 * math.sqrt(3) - 1e-3], corner)
    yield "cube corner on a slab", slab, cube, on_corner, K, 1.5 * K * 1e-9
    for R in (0.05, 0.005):
        K_ball = 1e7 / (0.01 * 2 * R * math.sqrt(3))
        load = 9.8e3 * 4 / 3 * math.pi * R**3
        depth_ball = math.sqrt(load / (math.pi * K_ball * R))
        at = pose([0.3, 0.11, 0.1 + R - depth_ball])
        yield f"ball of {R * 1e3:g} mm on a slab", slab, primitive("sphere", R), at, K_ball, load
    for kind, R, L in (("cylinder", 0.1, 0.2), ("capsule", 0.03, 0.1)):
        body = primitive(kind, R, L)
        K_body = 1e7 / (0.01 * body.diagonal)
        d = (0.75 * 9.8e3 * math.pi * R * R * L / (K_body * L * math.sqrt(2 * R))) ** (2 / 3)
        truth = 4 / 3 * K_body * L * math.sqrt(2 * R) * d**1.5
        if kind == "capsule":
            truth += math.pi * K_body * R * d * d
        at = pose([0.3, 0.11, 0.1 + R - d], _turned([math.pi / 2, 0, 0]))
        yield f"{kind} on its side", slab, body, at, K_body, truth
    doughnut, cone = (CollisionMesh(*surface) for surface in doughnut_and_cone(64))
    yield "doughnut on a cone", cone, doughnut, pose([2e-4, 1e-4, 0.1663]), 1e8, None


def _turned(rotation: object) -> np.ndarray:
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(np.asarray(rotation, dtype=float)).as_matrix()


def measured() -> Iterator[tuple[str, int, str, float]]:
    V = np.zeros((2, 6))
    for name, floor, body, X_FB, K, truth in cases():
        model = ContactModel(
            ["floor", "body"],
            [ContactGeometry("floor", 0, floor), ContactGeometry("body", 1, body)],
            [ContactPair(0, 1, NonlinearDamper(k=K, alpha=0.0, n=1.0))],
        )
        X = np.array([np.eye(4), X_FB])
        force = model.evaluate(X, V).body_wrenches[1][5]
        times = []
        for _ in range(60):
            start = time.thread_time()
            model.evaluate(X, V)
            times.append(time.thread_time() - start)
        error = "–" if truth is None else f"{100 * (force / truth - 1):+.2f} %"
        yield name, int(model.find(X).num_springs.sum()), error, statistics.median(times) * 1e6


def lines() -> Iterator[str]:
    yield "| contact | springs | error | cold [µs] | before: springs | error | cold [µs] |"
    yield "|---|---|---|---|---|---|---|"
    for name, springs, error, cold in measured():
        before = BEFORE.get(name)
        old = " | ".join(map(str, before)) if before else "– | – | –"
        yield f"| {name} | {springs} | {error} | {cold:.0f} | {old} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, help="Markdown file to write the table to")
    options = parser.parse_args()
    table = []
    for line in lines():
        print(line, flush=True)
        table.append(line)
    if options.out:
        options.out.write_text(HEADING + "\n".join(table) + "\n")


if __name__ == "__main__":
    main()
