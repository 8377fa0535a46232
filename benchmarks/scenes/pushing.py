"""An arm that pushes a box over a table: by the friction of what the table carries."""

from __future__ import annotations

import math
import re
from functools import partial
from pathlib import Path

import numpy as np
from pydrake.geometry import Box
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import PdControllerGains, SpatialInertia, default_model_instance
from pydrake.systems.framework import DiagramBuilder
from pydrake.trajectories import PiecewisePolynomial
from scipy.optimize import fsolve

from benchmarks.scenes.models import Edit, add_box_on_world, add_file, control, follow
from benchmarks.scenes.scene import Floats, Run, Scene, Truth

_MU, _MASS, _SIDE = 0.5, 2.0, 0.3  # [-], [kg], [m]
_START, _HEIGHT, _GAP = 0.62, 0.15, 0.002  # [m] of the flange; before the box
_VELOCITY, _DURATION = 0.05, 1.4  # [m/s], [s]
_PUSHING, _AVERAGED = 0.8, 0.2  # [s]
_BENT = [1.0, -1.65, -1.2]  # [rad] of joints 2, 4 and 6, about
_PLANAR = [1, 3, 5]
_DAMPING = 0.1  # [N m s] of each joint, by the file

# Drake's parser ends the process for a body without mass that says so.
_without_no_mass: Edit = partial(re.sub, r'<inertial [^>]*\bmass="0"[^>]*/>', "")


def _build(plant: MultibodyPlant, folder: Path) -> None:
    arm = add_file(plant, "robosuite", "robots/iiwa/robot.xml", folder, _without_no_mass)
    plant.RenameModelInstance(arm, "arm")
    plant.set_gravity_enabled(arm, False)  # robots compensate theirs
    control(plant, arm, lambda _: PdControllerGains(p=3000.0, d=100.0))
    add_box_on_world(plant, (2.0, 2.0, 0.2), _MU)
    inertia = SpatialInertia.SolidBoxWithMass(_MASS, _SIDE, _SIDE, _SIDE)
    box = plant.AddRigidBody("box", default_model_instance(), inertia)
    surface = CoulombFriction(_MU, _MU)
    shape = Box(_SIDE, _SIDE, _SIDE)
    plant.RegisterCollisionGeometry(box, RigidTransform(), shape, "box", surface)
    X_WB = RigidTransform([_START + _GAP + _SIDE / 2, 0.0, _SIDE / 2])
    plant.SetDefaultFloatingBaseBodyPose(box, X_WB)


def _connect(builder: DiagramBuilder, plant: MultibodyPlant) -> None:
    """Move the flange straight on, its face upright."""
    context = plant.CreateDefaultContext()
    arm, hand = plant.GetModelInstanceByName("arm"), plant.GetBodyByName("right_hand")

    def miss(bent: Floats, x: float) -> list[float]:
        joints = np.zeros(7)
        joints[_PLANAR] = bent
        plant.SetPositions(context, arm, joints)
        X_WH = plant.EvalBodyPoseInWorld(context, hand)
        at, ahead = X_WH.translation(), X_WH.rotation().col(2)
        return [at[0] - x, at[2] - _HEIGHT, math.atan2(-ahead[2], ahead[0])]

    times = np.linspace(0.0, _DURATION, 29)
    joints = np.zeros((7, len(times)))
    bent = _BENT
    for i, t in enumerate(times):
        bent = fsolve(miss, bent, args=(_START + _VELOCITY * t,))
        joints[_PLANAR, i] = bent
    path = PiecewisePolynomial.CubicWithContinuousSecondDerivatives(times, joints)
    follow(builder, plant, arm, path)
    plant.SetDefaultPositions(arm, joints[:, 0])


def _push(run: Run) -> dict[str, float]:
    box, link = run.plant.GetBodyByName("box"), run.plant.GetBodyByName("link_7")
    run.advance(_PUSHING)
    push = -run.force_on([link], _AVERAGED)
    friction = _MU * (run.weight([box]) - push[2])
    yaw = RollPitchYaw(run.pose("box").rotation()).yaw_angle()
    return {
        "pushes by [μ N]": push[0] / friction,
        "the same by the joints' power": _force_by_power(run) / friction,
        "yaw [deg]": math.degrees(yaw),
    }


def _force_by_power(run: Run) -> float:
    """Return what the joints' power, less their damping, is in newtons along the way."""
    arm = run.plant.GetModelInstanceByName("arm")
    torque = run.plant.get_net_actuation_output_port(arm).Eval(run.context)
    rate = run.plant.GetVelocities(run.context, arm)
    ahead = run.plant.GetBodyByName("right_hand").EvalSpatialVelocityInWorld(run.context)
    return (torque @ rate - _DAMPING * rate @ rate) / ahead.translational()[0]


SCENES = (
    Scene(
        "iiwa pushing a box",
        "`robots/iiwa/robot.xml` of `robosuite`, less a body's mass of 0, at which Drake's "
        "parser ends the process; joints lack gains. N is what the table carries.",
        ("robosuite",),
        _build,
        _push,
        {
            "pushes by [μ N]": Truth(1.0, 0.01),
            "the same by the joints' power": Truth(1.0, 0.01),
            "yaw [deg]": Truth(0.0, 0.1),
        },
        _connect,
    ),
)
