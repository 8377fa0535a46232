"""Model files of packages in scenes: read, with what they lack, or what is not there, set right."""

from __future__ import annotations

import logging
import re
from collections.abc import Callable
from functools import partial
from pathlib import Path

from pydrake.geometry import Box
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex, PdControllerGains, RigidBody
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import Trajectory

from benchmarks.model_zoo.files import folder_of, make_parser
from systems.parse_model import readable_model

Edit = Callable[[str], str]


def add_file(
    plant: MultibodyPlant, package: str, path: str, cache: Path, *edits: Edit
) -> ModelInstanceIndex:
    """Add the model of a package's file, as `parse_model` reads it, after some edits of its text.

    Meshes of kinds that Drake does not read are written as .obj into `cache`.
    """
    logging.getLogger("drake").setLevel(logging.ERROR)  # of MuJoCo's tags that Drake ignores
    parser: Parser = make_parser(plant, package)
    file = Path(str(folder_of(package))) / path
    readable = readable_model(parser, file, cache)
    text = readable.read_text()
    if readable == file:  # elsewhere its references are absolute already
        text = re.sub(r"<uri>(?!\w+://)", f"<uri>file://{file.parent}/", text)
    for edit in edits:
        text = edit(text)
    (model,) = parser.AddModelsFromString(text, file.suffix[1:])
    return model


# The meshes of drake_models, which is no package of pip's: contact has no use for them.
without_visuals: Edit = partial(re.sub, r"(?s)<visual\b.*?</visual>", "")

# robosuite gives its objects a free joint as it puts them into a world.
set_free: Edit = partial(re.sub, r"<worldbody>\s*<body>", "<worldbody><body><freejoint/>")

# So does it say that the angles of its files are radians.
in_radians: Edit = partial(re.sub, r"(<mujoco\b[^>]*>)", r'\1<compiler angle="radian"/>')

# Drake takes the range of a position for that of a force: 0.04 N for a finger.
without_actuators: Edit = partial(re.sub, r"(?s)<actuator>.*?</actuator>", "")


def bodies_of(plant: MultibodyPlant, *models: str) -> list[RigidBody]:
    """Return all bodies of models."""
    return [
        plant.get_body(index)
        for model in models
        for index in plant.GetBodyIndices(plant.GetModelInstanceByName(model))
    ]


def add_box_on_world(
    plant: MultibodyPlant, size: tuple[float, float, float], friction: float = 0.5
) -> None:
    """Add a table whose top is z = 0."""
    X_WG = RigidTransform([0.0, 0.0, -size[2] / 2])
    surface = CoulombFriction(friction, friction)
    plant.RegisterCollisionGeometry(plant.world_body(), X_WG, Box(*size), "table", surface)


def control(
    plant: MultibodyPlant, model: ModelInstanceIndex, gains: Callable[[str], PdControllerGains]
) -> None:
    """Give the actuators of a model's joints gains; where it has none, all its joints get one."""
    actuators = [
        actuator
        for actuator in map(plant.get_joint_actuator, plant.GetJointActuatorIndices())
        if actuator.model_instance() == model
    ] or [
        plant.AddJointActuator(joint.name(), joint)
        for joint in map(plant.get_joint, plant.GetJointIndices(model))
        if joint.num_velocities() == 1
    ]
    for actuator in actuators:
        actuator.set_controller_gains(gains(actuator.joint().name()))


def follow(
    builder: DiagramBuilder, plant: MultibodyPlant, model: ModelInstanceIndex, path: Trajectory
) -> None:
    """Let the controllers of a model's joints follow a path."""
    source = builder.AddSystem(TrajectorySource(path, output_derivative_order=1))
    builder.Connect(source.get_output_port(), plant.get_desired_state_input_port(model))
