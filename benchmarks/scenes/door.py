"""A hinged door that is pushed open, as fast as its inertia and its hinge's damping allow."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from pydrake.geometry import Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    PrismaticJoint,
    SpatialInertia,
    default_model_instance,
)
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource
from scipy.integrate import solve_ivp

from benchmarks.scenes.models import add_file, in_radians
from benchmarks.scenes.scene import Floats, Run, Scene, Truth

_FORCE, _MASS, _RADIUS = 1.5, 0.5, 0.03  # [N], [kg], [m] of the ball that pushes
_HINGE, _ARM = 0.555, 0.35  # [m] along the frame; from there to the line of the ball's centre
_HALF = 0.02  # [m] of the panel's thickness
_DAMPING = 1.0  # [N m s] of the hinge, by the file
_GAP = 1e-6  # [m]
_DURATION = 0.6  # [s]


def _build(plant: MultibodyPlant, folder: Path) -> None:
    door = add_file(plant, "robosuite", "objects/door.xml", folder, in_radians)
    frame = plant.GetBodyByName("frame", door)
    inertia = SpatialInertia.SolidSphereWithMass(_MASS, _RADIUS)
    ball = plant.AddRigidBody("ball", default_model_instance(), inertia)
    slippery = CoulombFriction(0.0, 0.0)
    plant.RegisterCollisionGeometry(ball, RigidTransform(), Sphere(_RADIUS), "ball", slippery)
    X_FB = RigidTransform([_HINGE - _ARM, _HALF + _RADIUS + _GAP, 0.0])
    start = plant.AddFrame(FixedOffsetFrame("start", frame.body_frame(), X_FB))
    slide = PrismaticJoint("slide", start, ball.body_frame(), [0.0, -1.0, 0.0])
    plant.AddJointActuator("slide", plant.AddJoint(slide))


def _connect(builder: DiagramBuilder, plant: MultibodyPlant) -> None:
    force = builder.AddSystem(ConstantVectorSource([_FORCE]))
    ball = plant.GetBodyByName("ball").model_instance()
    builder.Connect(force.get_output_port(), plant.get_actuation_input_port(ball))


def _open(run: Run) -> dict[str, float]:
    run.advance(_DURATION)
    door, ball = (run.plant.GetBodyByName(name) for name in ("door", "ball"))
    angle = run.plant.GetPositions(run.context, door.model_instance())[0]
    truth = _swing(run.plant.CalcMassMatrix(run.context)[0, 0])
    return {
        "angle [closed form]": angle / truth[0],
        "push [closed form]": np.linalg.norm(run.force_on([ball])[:2]) / truth[1],
    }


def _swing(inertia: float) -> tuple[float, float]:
    """Return angle [rad] and push [N] at the end, for a door of this inertia about its hinge.

    The ball has gone by u = L tan θ - r (1 / cos θ - 1), without friction; so
    (I + m u'²) θ'' + m u' u'' θ'² = F u' - c θ'.
    """
    out = _HALF + _RADIUS

    def turn(angle: float, rate: float) -> tuple[float, float, float]:
        tan, sec = math.tan(angle), 1.0 / math.cos(angle)
        first = _ARM * sec**2 - out * tan * sec
        second = 2 * _ARM * sec**2 * tan - out * (sec * tan**2 + sec**3)
        torque = _FORCE * first - _DAMPING * rate - _MASS * first * second * rate**2
        return torque / (inertia + _MASS * first**2), first, second

    def slope(_: float, state: Floats) -> list[float]:
        return [state[1], turn(*state)[0]]

    end = solve_ivp(slope, (0.0, _DURATION), [0.0, 0.0], rtol=1e-9, atol=1e-12).y[:, -1]
    acceleration, first, second = turn(*end)
    ahead = _FORCE - _MASS * (first * acceleration + second * end[1] ** 2)
    return end[0], ahead / math.cos(end[0])


SCENES = (
    Scene(
        "hinged door",
        "`objects/door.xml` of `robosuite`, which does not say that its angles are radians, and a "
        "ball of 0.5 kg without friction that pushes by 1.5 N.",
        ("robosuite",),
        _build,
        _open,
        {"angle [closed form]": Truth(1.0, 0.01), "push [closed form]": Truth(1.0, 0.01)},
        _connect,
    ),
)
