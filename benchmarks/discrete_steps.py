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
    Mesh,
    ProximityProperties,
    SceneGraph,
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
from pydrake.multibody.tree import CalcSpatialInertia, SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder, EventStatus

from benchmarks import panda_and_mug
from scenarios import runner
from scenarios.format.loading import load
from scenarios.parts import voussoir, write_obj
from systems import AddNonlinearDamperContact

HEADING = """# Discrete plants: real-time factor and rest

Made by `python -m benchmarks.discrete_steps --out benchmarks/DISCRETE_STEPS.md`: medians of
interleaved runs in one process. Drake's tags (friction 0.5, hydroelastic modulus 1e7 Pa, 5 mm
resolution), nothing else set. Way: how far the last body is from where it began, at the end of the
run; creep: how fast it moves over the last quarter. Speed: the fastest of all velocities at the
end, in m/s or rad/s. Unsolved: steps whose forces do not balance. What stands for a minute is run
once. The arch has friction 0.7; in the house of cards two pairs lean on each other and bear two
more, so that edges rest on edges. Rock-N-Stack is the scenario of that name.
The arm: a Panda of robosuite's that holds a mug of 0.25 kg by its wall and shook it at 5 Hz before;
geometry is compliant by Drake's default properties, creep is the mug's in the hand. Drake's point
contact loses it, for it sees a solid hull; hydroelastic sees a compliant one.

"""
MU = 0.5
ENGINES = ("ours", "Drake hydroelastic", "Drake point")
ROUNDS = 3
MINUTE = 60.0  # [s]
UNSOLVED = 2  # a step's status from which on it is not
STONES, SHARE = 7, math.pi / 7  # of the arch [rad]
INNER, OUTER, ARCH_FRICTION = 0.5, 0.6, 0.7  # [m], [m], [-]
LEAN, CARD = math.radians(20), (0.002, 0.06, 0.09)  # of a card [rad], [m]


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
    rounds: int = ROUNDS


@dataclass(frozen=True)
class Result:
    factor: float  # of real time
    way: float  # [m] of what is watched
    creep: float  # [m/s]
    speed: float  # [m/s, rad/s]
    unsolved: int  # steps


def tags(friction: float = MU) -> ProximityProperties:
    properties = ProximityProperties()
    AddContactMaterial(friction=CoulombFriction(friction, friction), properties=properties)
    AddCompliantHydroelasticProperties(0.005, 1e7, properties)
    return properties


def slope(plant: MultibodyPlant, tangent: float) -> None:
    X_WR = RigidTransform(RollPitchYaw(0, math.atan(tangent), 0), [0, 0, 0])
    ground = X_WR @ RigidTransform([0, 0, -0.1])
    plant.RegisterCollisionGeometry(plant.world_body(), ground, Box(4, 2, 0.2), "ramp", tags())
    body = plant.AddRigidBody("box", SpatialInertia.SolidBoxWithMass(1.0, 0.2, 0.2, 0.1))
    plant.RegisterCollisionGeometry(body, RigidTransform(), Box(0.2, 0.2, 0.1), "box", tags())
    plant.SetDefaultFloatingBaseBodyPose(body, X_WR @ RigidTransform([-1, 0, 0.05]))


def table(plant: MultibodyPlant, friction: float = MU) -> None:
    ground = RigidTransform([0, 0, -0.1])
    plant.RegisterCollisionGeometry(
        plant.world_body(), ground, Box(2, 2, 0.2), "table", tags(friction)
    )


def stack(plant: MultibodyPlant, count: int) -> None:
    table(plant)
    for i in range(count):
        body = plant.AddRigidBody(f"box{i}", SpatialInertia.SolidBoxWithMass(1.0, 0.1, 0.1, 0.1))
        plant.RegisterCollisionGeometry(body, RigidTransform(), Box(0.1, 0.1, 0.1), f"{i}", tags())
        plant.SetDefaultFloatingBaseBodyPose(body, RigidTransform([0, 0, 0.05 + 0.1 * i]))


def mass_ratio(plant: MultibodyPlant) -> None:
    """A box of 10 kg on one of 10 g."""
    table(plant)
    for i, (mass, side) in enumerate(((0.01, 0.1), (10.0, 0.08))):
        body = plant.AddRigidBody(f"box{i}", SpatialInertia.SolidBoxWithMass(mass, side, side, 0.1))
        shape = Box(side, side, 0.1)
        plant.RegisterCollisionGeometry(body, RigidTransform(), shape, f"{i}", tags())
        plant.SetDefaultFloatingBaseBodyPose(body, RigidTransform([0, 0, 0.05 + 0.1 * i]))


def arch(plant: MultibodyPlant, folder: Path) -> None:
    """Seven stones; the last one added is the keystone."""
    table(plant, ARCH_FRICTION)
    path = write_obj(folder / "stone.obj", voussoir(INNER, OUTER, SHARE))
    middle = (STONES - 1) // 2
    for i in sorted(range(STONES), key=lambda i: -abs(i - middle)):
        body = plant.AddRigidBody(f"stone{i}", CalcSpatialInertia(Mesh(path), 2400))
        plant.RegisterCollisionGeometry(
            body, RigidTransform(), Mesh(path), f"{i}", tags(ARCH_FRICTION)
        )
        turn = RollPitchYaw(0, (i - middle) * SHARE, 0)
        plant.SetDefaultFloatingBaseBodyPose(body, RigidTransform(turn, [0, 0, 0]))


def card_house(plant: MultibodyPlant) -> None:
    """Two pairs of leaning cards side by side, and two that lie on their ridges."""
    table(plant)
    thick, _, tall = CARD
    out = tall / 2 * math.sin(LEAN) + thick / 2 * math.cos(LEAN)  # inner top edges meet
    up = tall / 2 * math.cos(LEAN) + thick / 2 * math.sin(LEAN)
    ridge = 2 * up
    pair = 0.8 * tall  # from ridge to ridge
    poses = [
        RigidTransform(RollPitchYaw(0, -side * LEAN, 0), [at + side * out, 0, up])
        for at in (-pair / 2, pair / 2)
        for side in (-1, 1)
    ]
    flat = RollPitchYaw(0, math.pi / 2, 0)
    poses += [RigidTransform(flat, [0, 0, ridge + (0.5 + i) * thick]) for i in range(2)]
    for i, X_WB in enumerate(poses):
        body = plant.AddRigidBody(f"card{i}", SpatialInertia.SolidBoxWithDensity(800, *CARD))
        plant.RegisterCollisionGeometry(body, RigidTransform(), Box(*CARD), f"{i}", tags())
        plant.SetDefaultFloatingBaseBodyPose(body, X_WB)


def cases(folder: Path) -> Iterator[Case]:
    for step in (1e-3, 2e-3, 5e-3, 1e-2):
        held = lambda plant: slope(plant, 0.99 * MU)  # noqa: E731
        yield Case("box on a ramp at 0.99 μ", step, 10.0, held)
    for count, step in itertools.product((5, 10), (1e-3, 5e-3)):
        boxes = lambda plant, count=count: stack(plant, count)  # noqa: E731
        yield Case(f"stack of {count} boxes", step, 5.0, boxes)
    standing = {
        "stack of 10 boxes, a minute": lambda plant: stack(plant, 10),
        "1000 : 1 on top, a minute": mass_ratio,
        "arch of 7 stones, a minute": lambda plant: arch(plant, folder),
        "house of 6 cards, a minute": card_house,
    }
    for name, bodies in standing.items():
        yield Case(name, 5e-3, MINUTE, bodies, rounds=1)
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


def make_plant(
    builder: DiagramBuilder, engine: str, step: float
) -> tuple[MultibodyPlant, SceneGraph]:
    """Return an empty plant for one of `ENGINES`; all geometry is compliant unless tagged."""
    defaults = DefaultProximityProperties(compliance_type="compliant")
    plant, scene_graph = AddMultibodyPlant(
        MultibodyPlantConfig(time_step=step),
        SceneGraphConfig(default_proximity_properties=defaults),
        builder,
    )
    if engine == "Drake point":
        plant.set_contact_model(ContactModel.kPoint)
    return plant, scene_graph


def run(case: Case, engine: str) -> Result:
    builder = DiagramBuilder()
    plant, scene_graph = make_plant(builder, engine, case.step)
    case.bodies(plant)
    plant.Finalize()
    case.connect(builder, plant)
    contact = None
    if engine == "ours":
        contact = AddNonlinearDamperContact(builder, plant, scene_graph)
    simulator = Simulator(builder.Build())
    simulator.Initialize()
    unsolved = 0
    if contact:
        statistics_port = contact.get_step_statistics_output_port()
        contact_context = contact.GetMyContextFromRoot(simulator.get_context())

        def watch(_: Context) -> EventStatus:
            nonlocal unsolved
            unsolved += statistics_port.Eval(contact_context)[3] >= UNSOLVED
            return EventStatus.DidNothing()

        simulator.set_monitor(watch)
    context = plant.GetMyContextFromRoot(simulator.get_context())
    begin = case.place(plant, context)
    start = time.thread_time()
    simulator.AdvanceTo(0.75 * case.duration)
    before = case.place(plant, context)
    simulator.AdvanceTo(case.duration)
    taken = time.thread_time() - start
    end = case.place(plant, context)
    speed = float(np.abs(plant.GetVelocities(context)).max())
    return Result(
        case.duration / taken,
        float(np.linalg.norm(end - begin)),
        float(np.linalg.norm(end - before)) / (0.25 * case.duration),
        speed,
        unsolved,
    )


def lines(folder: Path) -> Iterator[str]:
    yield "| case | step | contact | real-time factor | way | creep | speed | unsolved |"
    yield "|---|---|---|---|---|---|---|---|"
    for case in cases(folder):
        runs: dict[str, list[Result]] = {engine: [] for engine in ENGINES}
        for _ in range(case.rounds):
            for engine in ENGINES:
                runs[engine].append(run(case, engine))
        for engine, results in runs.items():
            factor = statistics.median(result.factor for result in results)
            first = results[0]  # in all else they are alike
            unsolved = f"{first.unsolved} of {case.duration / case.step:.0f}"
            yield (
                f"| {case.name} | {1e3 * case.step:g} ms | {engine} | {factor:.3g} | "
                f"{1e3 * first.way:.2g} mm | {1e6 * first.creep:.2g} µm/s | {first.speed:.1g} | "
                f"{unsolved if engine == 'ours' else '–'} |"
            )


def rock_n_stack(folder: Path) -> Iterator[str]:
    yield "| Rock-N-Stack | real-time factor (wall clock) | height at rest | over continuous |"
    yield "|---|---|---|---|"
    continuous = None
    for step in (0.0, 1e-3):
        overrides = [f"plant_config={{time_step: {step}}}"]
        summary = runner.run(*load("rock_n_stack", overrides), folder / f"rock_n_stack {step:g}")
        height = summary.figures["height [mm]"]
        continuous = continuous or height
        yield (
            f"| {f'discrete, {1e3 * step:g} ms' if step else 'continuous'} | "
            f"{summary.real_time_factor:.2g} | {height:.4f} mm | {height - continuous:+.4f} mm |"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, help="Markdown file to write the table to")
    options = parser.parse_args()
    table = []
    with TemporaryDirectory() as folder:
        for line in itertools.chain(lines(Path(folder)), [""], rock_n_stack(Path(folder))):
            print(line, flush=True)
            table.append(line)
    if options.out:
        options.out.write_text(HEADING + "\n".join(table) + "\n")


if __name__ == "__main__":
    main()
