"""A quadruped that stands on triangulated ground; a mecanum base that rolls."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import PdControllerGains
from pydrake.systems.framework import DiagramBuilder
from pydrake.trajectories import PiecewisePolynomial
from scipy.integrate import cumulative_trapezoid

from benchmarks.scenes.models import add_box_on_world, add_file, bodies_of, control, follow
from benchmarks.scenes.scene import Floats, Run, Scene, Truth
from contact_toolkit.parts import height_field, write_obj
from systems import add_mesh_body

_STANCE = [0.0, 0.8, -1.6]  # [rad] of hip, thigh and calf
_SETTLED, _WATCHED = 2.4, 0.3  # [s]

_RATE, _SPUN_UP = 3.0, 0.1  # [rad/s] of the wheels, [s] until they turn so
_ROLLED = 2 * 2 * math.pi / 12 / _RATE  # [s] two rollers
_HUB, _ROLLERS = 0.045, 12  # [m] to the rollers' axes
_THICK, _LONG = 0.0075, 0.03  # [m] semi-axes of a roller, askew by 45°


def _build_quadruped(plant: MultibodyPlant, folder: Path) -> None:
    path = "robots/a1_description/urdf/a1.urdf"
    robot = add_file(plant, "example-robot-data", path, folder)
    plant.RenameModelInstance(robot, "robot")
    control(plant, robot, lambda _: PdControllerGains(p=500.0, d=15.0))
    hills = write_obj(
        folder / "hills.obj", height_field(2.0, 40, roughness=0.15, wavelength=0.3, seed=1)
    )
    ground = add_mesh_body(plant, hills).body
    plant.WeldFrames(plant.world_frame(), ground.body_frame())
    base = plant.GetBodyByName("base", robot)
    plant.SetDefaultFloatingBaseBodyPose(base, RigidTransform([0.0, 0.0, 0.34]))


def _connect_quadruped(builder: DiagramBuilder, plant: MultibodyPlant) -> None:
    robot = plant.GetModelInstanceByName("robot")
    stance = np.tile(_STANCE, 4)
    path = PiecewisePolynomial.ZeroOrderHold([0.0, 10.0], np.column_stack([stance, stance]))
    follow(builder, plant, robot, path)
    for index, angle in zip(plant.GetActuatedJointIndices(robot), stance, strict=True):
        plant.get_joint(index).set_default_positions([angle])


def _stand(run: Run) -> dict[str, float]:
    robot = bodies_of(run.plant, "robot")
    feet = [body for body in robot if body.name().endswith("_foot")]
    run.advance(_SETTLED)
    before = np.array([run.pose(foot.name()).translation() for foot in feet])
    carried = run.force_on(robot, _WATCHED)
    by_feet = run.force_on(feet)
    after = np.array([run.pose(foot.name()).translation() for foot in feet])
    way = np.linalg.norm(after - before, axis=1).max()
    return {
        "feet carry [weights]": by_feet[2] / run.weight(robot),
        "pushed aside [weights]": np.linalg.norm(carried[:2]) / run.weight(robot),
        "a foot creeps [µm/s]": 1e6 * way / _WATCHED,
    }


def _build_mecanum(plant: MultibodyPlant, folder: Path) -> None:
    base = add_file(plant, "manipulation", "mecanum/mecanum_base.urdf", folder)
    plant.RenameModelInstance(base, "base")
    control(plant, base, lambda _: PdControllerGains(p=5.0, d=0.5))
    add_box_on_world(plant, (4.0, 4.0, 1.0), 1.0)
    chassis = plant.GetBodyByName("chassis", base)
    plant.SetDefaultFloatingBaseBodyPose(chassis, RigidTransform([0.0, 0.0, _HUB + _THICK]))


def _connect_mecanum(builder: DiagramBuilder, plant: MultibodyPlant) -> None:
    """Turn all wheels alike, then those of one diagonal the other way round."""
    base = plant.GetModelInstanceByName("base")
    times = np.cumsum([0.0, _SPUN_UP, _SPUN_UP + _ROLLED, _SPUN_UP, _SPUN_UP + 2 * _ROLLED])
    ahead = [0.0, _RATE, _RATE]
    rates = np.array([[*ahead, side * _RATE, side * _RATE] for side in (-1, 1, 1, -1)])
    angles = cumulative_trapezoid(rates, times, initial=0.0)
    follow(builder, plant, base, PiecewisePolynomial.CubicHermite(times, angles, rates))


def _roll(run: Run) -> dict[str, float]:
    ahead = _way_and_turn(run)
    run.advance(_SPUN_UP)
    aside = _way_and_turn(run)
    radius, aside_radius = _mean_radii()
    return {
        "ahead [ω r]": ahead[0] / (radius * ahead[2]),
        "sideways [ω r]": aside[1] / (aside_radius * aside[2]),
    }


def _way_and_turn(run: Run) -> Floats:
    """Spin up, roll; return how far the chassis went along x and y [m], a wheel turned [rad]."""
    wheel = run.plant.GetJointByName("front_right_wheel_joint")

    def read() -> Floats:
        return np.array([*run.pose("chassis").translation()[:2], wheel.get_angle(run.context)])

    run.advance(2 * _SPUN_UP)
    before = read()
    run.advance(_ROLLED)
    return read() - before


def _mean_radii() -> tuple[float, float]:
    """Return by how much a base rolls for a wheel's angle, ahead and sideways [m].

    Where a roller φ from below touches, its axle h over the ground, the point that touches moves
    along with the hub but for what it slips across the roller, which spins freely:
    v_y = ± (v_x - ω h) cos φ. So ahead v_x = ω h, and with diagonals against each other v_y =
    ω h cos φ; on the mean from roller to roller.
    """
    pitch = 2 * math.pi / _ROLLERS
    angle = (np.arange(1000) + 0.5) / 1000 * pitch - pitch / 2
    along = np.sin(angle) / math.sqrt(2)  # of a roller's axis, downwards
    below = np.hypot(_THICK * np.sqrt(1 - along**2), _LONG * along)
    height = _HUB * np.cos(angle) + below
    return float(np.mean(height)), float(np.mean(height * np.cos(angle)))


SCENES = (
    Scene(
        "quadruped on rough ground",
        "`a1.urdf` of `example-robot-data`, which lacks actuators, on hills of ± 9 cm of 3 200 "
        "triangles; on three feet.",
        ("example-robot-data",),
        _build_quadruped,
        _stand,
        {
            "feet carry [weights]": Truth(1.0, 1e-3),
            "pushed aside [weights]": Truth(0.0, 1e-3),
            "a foot creeps [µm/s]": Truth(0.0, 1.0),
        },
        _connect_quadruped,
    ),
    Scene(
        "mecanum base rolling",
        "`mecanum/mecanum_base.urdf` of `manipulation`, with 48 free rollers; lacks gains. The "
        "truth is that of rigid rollers; soft ones lag (0.1 % and less at 1e11 Pa/m).",
        ("manipulation",),
        _build_mecanum,
        _roll,
        {"ahead [ω r]": Truth(1.0, 0.01), "sideways [ω r]": Truth(1.0, 0.01)},
        _connect_mecanum,
    ),
)
