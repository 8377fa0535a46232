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
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    Box,
    DefaultProximityProperties,
    ProximityProperties,
    SceneGraphConfig,
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
from pydrake.systems.framework import Context, DiagramBuilder

from benchmarks import panda_and_mug
from systems import AddNonlinearDamperContact

HEADING = """# Discrete plants: real-time factor and rest

Made by `python -m benchmarks.discrete_steps --out benchmarks/DISCRETE_STEPS.md`: medians of
interleaved runs in one process. Drake's tags (friction 0.5, hydroelastic modulus 1e7 Pa, 5 mm
resolution), nothing else set. Creep: how fast the last body moves over the last quarter of the run.
The arm: a Panda of robosuite's that holds a mug of 0.25 kg by its wall and shook it at 5 Hz before;
geometry is compliant by Drake's default properties, creep is the mug's in the hand. Drake's point
contact loses it, for it sees a solid hull; hydroelastic sees a compliant one.

"""
MU = 0.5
ENGINES = ("ours", "Drake hydroelastic", "Drake point")
ROUNDS = 3


Place = NDArray[np.float64]


def no_inputs(builder: DiagramBuilder, plant: MultibodyPlant) -> None:
    del builder, plant


def last_body(plant: MultibodyPlant, context: Context) -> Place:
    return plant.GetPositions(context)[-3:]


@dataclass(frozen=True)
class Case:
    name: str
    step: float  # [s]
    duration: float  # [s]
    bodies: Callable[[MultibodyPlant], None]
    connect: Callable[[DiagramBuilder, MultibodyPlant], None] = no_inputs
    place: Callable[[MultibodyPlant, Context], Place] = last_body  # (3,) [m] of what is watched


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


def cases(folder: Path) -> Iterator[Case]:
    for step in (1e-3, 2e-3, 5e-3, 1e-2):
        held = lambda plant: slope(plant, 0.99 * MU)  # noqa: E731
        yield Case("box on a ramp at 0.99 μ", step, 10.0, held)
    for count, step in itertools.product((5, 10), (1e-3, 5e-3)):
        boxes = lambda plant, count=count: stack(plant, count)  # noqa: E731
        yield Case(f"stack of {count} boxes", step, 5.0, boxes)
    if panda_and_mug.installed():
        for step in (1e-3, 5e-3):
            yield Case(
                "arm that holds a mug",
                step,
                panda_and_mug.DURATION,
                lambda plant: panda_and_mug.add_bodies(plant, folder),
                panda_and_mug.connect,
                panda_and_mug.place,
            )


def run(case: Case, engine: str) -> tuple[float, float]:
    """Return the real-time factor, and how fast what is watched moves in the last quarter [m/s]."""
    builder = DiagramBuilder()
    defaults = DefaultProximityProperties(compliance_type="compliant")
    plant, scene_graph = AddMultibodyPlant(
        MultibodyPlantConfig(time_step=case.step),
        SceneGraphConfig(default_proximity_properties=defaults),
        builder,
    )
    case.bodies(plant)
    if engine == "Drake point":
        plant.set_contact_model(ContactModel.kPoint)
    plant.Finalize()
    case.connect(builder, plant)
    if engine == "ours":
        AddNonlinearDamperContact(builder, plant, scene_graph)
    simulator = Simulator(builder.Build())
    simulator.Initialize()
    context = plant.GetMyContextFromRoot(simulator.get_context())
    start = time.thread_time()
    simulator.AdvanceTo(0.75 * case.duration)
    before = case.place(plant, context)
    simulator.AdvanceTo(case.duration)
    taken = time.thread_time() - start
    way = float(np.linalg.norm(case.place(plant, context) - before))
    return case.duration / taken, way / (0.25 * case.duration)


def lines(folder: Path) -> Iterator[str]:
    columns = [f"{engine}: real-time factor | creep" for engine in ENGINES]
    yield f"| case | step | {' | '.join(columns)} |"
    yield "|---|---|" + "---|---|" * len(ENGINES)
    for case in cases(folder):
        runs = {engine: [] for engine in ENGINES}
        for _ in range(ROUNDS):
            for engine in ENGINES:
                runs[engine].append(run(case, engine))
        cells = []
        for results in runs.values():
            factor = statistics.median(result[0] for result in results)
            cells += [f"{factor:.3g}", f"{1e6 * results[0][1]:.2g} µm/s"]
        yield f"| {case.name} | {1e3 * case.step:g} ms | {' | '.join(cells)} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, help="Markdown file to write the table to")
    options = parser.parse_args()
    table = []
    with TemporaryDirectory() as folder:
        for line in lines(Path(folder)):
            print(line, flush=True)
            table.append(line)
    if options.out:
        options.out.write_text(HEADING + "\n".join(table) + "\n")


if __name__ == "__main__":
    main()
