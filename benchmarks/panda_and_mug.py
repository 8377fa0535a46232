"""A Panda arm that holds a mug by its wall and shakes it; from robosuite's model files.

Joints are held by the controllers of Drake's actuators, gravity is left out on the arm, as robots
compensate theirs. Needs the extra `models`.
"""

from __future__ import annotations

import logging
import math
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import Mesh
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import (
    JointIndex,
    PdControllerGains,
    SpatialInertia,
    default_model_instance,
)
from pydrake.systems.framework import Context, DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from contact_toolkit.parts import mug, write_obj
from systems import parse_model

DURATION = 4.0  # [s]
POSE = [0.0, 0.3, 0.0, -2.0, 0.0, 2.3, math.pi / 4]  # [rad]
OPEN, SQUEEZE = 0.02, -0.004  # [m] of a finger: the controllers pull 6 mm into half the wall
CLOSED_AT = 0.1  # [s]
SHAKEN, AMPLITUDE, FREQUENCY = (0.4, 1.0), 0.02, 5.0  # [s], [rad] of the elbow, [Hz]
RADIUS, TALL, WALL, MASS = 0.04, 0.095, 0.004, 0.25
TIP, INSIDE = 0.0954, 0.025  # [m] from the hand to between the finger tips; these within the mug


def installed() -> bool:
    """Whether the model files are there."""
    return find_spec("robosuite") is not None


def _urdf() -> Path:
    spec = find_spec("robosuite")
    assert spec is not None
    assert spec.origin is not None
    return Path(spec.origin).parent / (
        "models/assets/bullet_data/panda_description/urdf/panda_arm_hand.urdf"
    )


def add_bodies(plant: MultibodyPlant, folder: Path) -> None:
    """Add the arm and the mug, whose mesh is written into the folder."""
    logging.getLogger("drake").setLevel(logging.ERROR)  # of tags that Drake ignores
    parser = Parser(plant)
    parser.package_map().Add("panda_description", str(_urdf().parents[1]))
    (arm,) = parse_model(parser, _urdf(), cache=folder)
    plant.RenameModelInstance(arm, "arm")
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("panda_link0"))
    plant.set_gravity_enabled(arm, False)
    for index in plant.GetJointIndices(arm):
        joint = plant.get_joint(JointIndex(int(index)))
        if joint.num_velocities() == 0:
            continue
        finger = "finger" in joint.name()
        gains = PdControllerGains(p=4000, d=60) if finger else PdControllerGains(p=3000, d=100)
        plant.AddJointActuator(joint.name(), joint).set_controller_gains(gains)
    inertia = SpatialInertia.SolidCylinderWithMass(MASS, RADIUS, TALL, [0, 0, 1])
    cup = plant.AddRigidBody("mug", default_model_instance(), inertia.Shift([0, 0, -TALL / 2]))
    mesh = Mesh(str(write_obj(folder / "mug.obj", mug(RADIUS, TALL, WALL))))
    plant.RegisterCollisionGeometry(cup, RigidTransform(), mesh, "mug", CoulombFriction(0.8, 0.8))


def connect(builder: DiagramBuilder, plant: MultibodyPlant) -> None:
    """Feed the joints' controllers, and put the mug between the fingers."""
    arm = plant.GetModelInstanceByName("arm")
    times = np.arange(0, DURATION + 0.2, 0.01)
    joints = np.tile([*POSE, OPEN, OPEN], (len(times), 1))
    joints[:, 7:] = np.interp(times, [0, CLOSED_AT], [OPEN, SQUEEZE])[:, None]
    shaken = (times > SHAKEN[0]) & (times < SHAKEN[1])
    phase = 2 * math.pi * FREQUENCY * (times - SHAKEN[0])
    joints[:, 3] += np.where(shaken, AMPLITUDE * np.sin(phase), 0.0)
    path = PiecewisePolynomial.CubicShapePreserving(
        times, joints.T, zero_end_point_derivatives=True
    )
    source = builder.AddSystem(TrajectorySource(path, output_derivative_order=1))
    builder.Connect(source.get_output_port(), plant.get_desired_state_input_port(arm))
    plant.SetDefaultPositions(arm, joints[0])
    X_WH = plant.EvalBodyPoseInWorld(
        plant.CreateDefaultContext(), plant.GetBodyByName("panda_hand")
    )
    tip = X_WH @ np.array([0, 0, TIP])
    across = X_WH.rotation().col(1)
    middle = tip + (RADIUS - WALL / 2) * np.array([across[0], across[1], 0])
    X_WM = RigidTransform([middle[0], middle[1], tip[2] + INSIDE - TALL])
    plant.SetDefaultFloatingBaseBodyPose(plant.GetBodyByName("mug"), X_WM)


def place(plant: MultibodyPlant, context: Context) -> NDArray[np.float64]:
    """Return where the mug's middle is in the hand (3,) [m]."""
    X_HM = plant.GetBodyByName("mug").EvalPoseInWorld(context)
    hand = plant.GetBodyByName("panda_hand").EvalPoseInWorld(context)
    return hand.inverse() @ (X_HM @ np.array([0, 0, TALL / 2]))
