"""Grippers that hold what they grip: what carries it is its weight, and it does not creep."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import PdControllerGains, RigidBody
from pydrake.systems.framework import DiagramBuilder
from pydrake.trajectories import PiecewisePolynomial

from benchmarks.scenes.models import (
    add_file,
    bodies_of,
    control,
    follow,
    set_free,
    without_actuators,
    without_visuals,
)
from benchmarks.scenes.scene import Run, Scene, Truth
from contact_toolkit.parts import mug, write_obj
from systems import add_mesh_body

_HELD = {"carried [weights]": Truth(1.0, 1e-3), "creeps [µm/s]": Truth(0.0, 1.0)}
_RADIUS, _TALL, _WALL = 0.04, 0.095, 0.004  # [m] of the mug
_CERAMIC = 2300.0  # [kg/m³]
_SETTLED, _WATCHED, _AVERAGED = 0.6, 0.3, 0.1  # [s]


def _build_wsg(plant: MultibodyPlant, folder: Path) -> None:
    path = "hydro/schunk_wsg_50_with_tip.sdf"
    gripper = add_file(plant, "manipulation", path, folder, without_visuals)
    plant.RenameModelInstance(gripper, "gripper")
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("body", gripper))
    control(plant, gripper, lambda _: PdControllerGains(p=2000.0, d=40.0))
    made = add_mesh_body(
        plant, write_obj(folder / "mug.obj", mug(_RADIUS, _TALL, _WALL)), density=_CERAMIC
    )
    away = RollPitchYaw(0.0, 0.0, math.pi / 2)  # with the handle
    X_WM = RigidTransform(away, [0.0, 0.108, -_TALL / 2])
    plant.SetDefaultFloatingBaseBodyPose(made.body, X_WM)


def _connect_wsg(builder: DiagramBuilder, plant: MultibodyPlant) -> None:
    """Close from a millimetre off the mug to 5 mm within it: 10 N."""
    touching = _RADIUS - 0.0025
    _close(builder, plant, [-1.0, 1.0], touching + 0.001, touching - 0.005)


def _build_hand(plant: MultibodyPlant, folder: Path) -> None:
    hand = add_file(plant, "robosuite", "grippers/panda_gripper.xml", folder, without_actuators)
    plant.RenameModelInstance(hand, "gripper")
    control(plant, hand, lambda _: PdControllerGains(p=1000.0, d=0.0))  # the file's own kp
    nut = add_file(plant, "robosuite", "objects/square-nut.xml", folder, set_free)
    plant.RenameModelInstance(nut, "nut")
    base, _ = bodies_of(plant, "nut")
    plant.SetDefaultFloatingBaseBodyPose(base, RigidTransform([-0.054, 0.0, 0.0934]))


def _connect_hand(builder: DiagramBuilder, plant: MultibodyPlant) -> None:
    """Close until it pulls by 16 N on the handle, which is 31.75 mm wide."""
    _close(builder, plant, [1.0, -1.0], 0.018, 0.0)


def _close(
    builder: DiagramBuilder, plant: MultibodyPlant, signs: list[float], start: float, end: float
) -> None:
    gripper = plant.GetModelInstanceByName("gripper")
    fingers = np.outer(signs, [start, end, end])
    path = PiecewisePolynomial.FirstOrderHold([0.0, 0.1, 10.0], fingers)
    follow(builder, plant, gripper, path)
    plant.SetDefaultPositions(gripper, fingers[:, 0])


def _hold(run: Run, held: list[RigidBody], hand: str) -> dict[str, float]:
    run.advance(_SETTLED)
    before = _place(run, held, hand)
    run.advance(_WATCHED)
    way = np.linalg.norm(_place(run, held, hand) - before)
    carried = run.force_on(held, _AVERAGED)[2] / run.weight(held)
    return {"carried [weights]": carried, "creeps [µm/s]": 1e6 * way / _WATCHED}


def _place(run: Run, held: list[RigidBody], hand: str) -> np.ndarray:
    return (run.pose(hand).inverse() @ run.pose(held[-1].name())).translation()


SCENES = (
    Scene(
        "WSG gripper and mug",
        "`hydro/schunk_wsg_50_with_tip.sdf` of `manipulation` without its pictures, which no "
        "package has; its fingers lack gains and pull by 10 N. The mug is a mesh file.",
        ("manipulation",),
        _build_wsg,
        lambda run: _hold(run, [run.plant.GetBodyByName("mug")], "body"),
        _HELD,
        _connect_wsg,
    ),
    Scene(
        "Panda hand and nut",
        "`grippers/panda_gripper.xml` of `robosuite`, whose fingers pull by 16 N on the handle of "
        "`objects/square-nut.xml`. Drake takes the range of their positions for one of forces, so "
        "they get actuators anew.",
        ("robosuite",),
        _build_hand,
        lambda run: _hold(run, bodies_of(run.plant, "nut"), "right_gripper"),
        _HELD,
        _connect_hand,
    ),
)
