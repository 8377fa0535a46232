"""Discrete plants as users have them: real-time factor and rest, beside Drake's own contact.

`python -m benchmarks.discrete_steps --out benchmarks/DISCRETE_STEPS.md`. Every model has Drake's
tags and nothing set by hand; every engine takes the same plant, at the same step, in one process.
"""

from __future__ import annotations

import argparse
import itertools
import math
import statistics
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    Box,
    ProximityProperties,
)
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    ContactModel,
    CoulombFriction,
    MultibodyPlant,
    MultibodyPlantConfig,
)
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from systems import AddNonlinearDamperContact

HEADING = """# Discrete plants: real-time factor and rest

Made by `python -m benchmarks.discrete_steps --out benchmarks/DISCRETE_STEPS.md`: medians of
interleaved runs in one process. Drake's tags (friction 0.5, hydroelastic modulus 1e7 Pa, 5 mm
resolution), nothing else set. Creep: how far the last body moves in the last half of the run.

"""
MU = 0.5
ENGINES = ("ours", "Drake hydroelastic", "Drake point")
ROUNDS = 3


@dataclass(frozen=True)
class Case:
    name: str
    step: float  # [s]
    duration: float  # [s]
    bodies: Callable[[MultibodyPlant], None]
    truth: Callable[[float, float], str]  # of what it moves in each half [m]


def tags() -> ProximityProperties:
    properties = ProximityProperties()
    AddContactMaterial(friction=CoulombFriction(MU, MU), properties=properties)
    AddCompliantHydroelasticProperties(0.005, 1e7, properties)
    return properties


def slope(plant: MultibodyPlant, tangent: float) -> None:
    X_WR = RigidTransform(RollPitchYaw(0, math.atan(tangent), 0), [0, 0, 0])
    ground = X_WR @ RigidTransform([0, 0, -0.1])
    plant.RegisterCollisionGeometry(plant.world_body(), ground, Box(4, 2, 0.2), "ramp", tags())
    body = plant.AddRigidBody("box", SpatialInertia.SolidBoxWithMass(1.0, 0.2, 0.2, 0.1))
    plant.RegisterCollisionGeometry(body, RigidTransform(), Box(0.2, 0.2, 0.1), "box", tags())
    plant.SetDefaultFloatingBaseBodyPose(body, X_WR @ RigidTransform([-1, 0, 0.05]))


def stack(plant: MultibodyPlant, count: int) -> None:
    ground = RigidTransform([0, 0, -0.1])
    plant.RegisterCollisionGeometry(plant.world_body(), ground, Box(2, 2, 0.2), "table", tags())
    for i in range(count):
        body = plant.AddRigidBody(f"box{i}", SpatialInertia.SolidBoxWithMass(1.0, 0.1, 0.1, 0.1))
        plant.RegisterCollisionGeometry(body, RigidTransform(), Box(0.1, 0.1, 0.1), f"{i}", tags())
        plant.SetDefaultFloatingBaseBodyPose(body, RigidTransform([0, 0, 0.05 + 0.1 * i]))


def cases() -> Iterator[Case]:
    def creep(_: float, late: float) -> str:
        return f"{1e6 * late:.2g} µm"

    for step in (1e-3, 2e-3, 5e-3, 1e-2):
        held = lambda plant: slope(plant, 0.99 * MU)  # noqa: E731
        yield Case("box on a ramp at 0.99 μ", step, 2.0, held, creep)
    for count, step in itertools.product((5, 10), (1e-3, 5e-3)):
        boxes = lambda plant, count=count: stack(plant, count)  # noqa: E731
        yield Case(f"stack of {count} boxes", step, 1.0, boxes, creep)


def run(case: Case, engine: str) -> tuple[float, float, float]:
    """Return the real-time factor, and how far the last body moves in each half of the run [m]."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlant(MultibodyPlantConfig(time_step=case.step), builder)
    case.bodies(plant)
    if engine == "Drake point":
        plant.set_contact_model(ContactModel.kPoint)
    plant.Finalize()
    if engine == "ours":
        AddNonlinearDamperContact(builder, plant, scene_graph)
    simulator = Simulator(builder.Build())
    simulator.Initialize()
    context = plant.GetMyContextFromRoot(simulator.get_context())
    places = [plant.GetPositions(context)[-3:]]
    start = time.thread_time()
    for share in (0.5, 1.0):
        simulator.AdvanceTo(share * case.duration)
        places.append(plant.GetPositions(context)[-3:])
    taken = time.thread_time() - start
    moved = np.linalg.norm(np.diff(places, axis=0), axis=1)
    return case.duration / taken, float(moved[0]), float(moved[1])


def lines() -> Iterator[str]:
    columns = [f"{engine}: real-time factor | creep" for engine in ENGINES]
    yield f"| case | step | {' | '.join(columns)} |"
    yield "|---|---|" + "---|---|" * len(ENGINES)
    for case in cases():
        runs = {engine: [] for engine in ENGINES}
        for _ in range(ROUNDS):
            for engine in ENGINES:
                runs[engine].append(run(case, engine))
        cells = []
        for results in runs.values():
            factor = statistics.median(result[0] for result in results)
            cells += [f"{factor:.3g}", case.truth(*results[0][1:])]
        yield f"| {case.name} | {1e3 * case.step:g} ms | {' | '.join(cells)} |"


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
