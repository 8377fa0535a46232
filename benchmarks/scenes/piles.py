"""Many bodies at once: what lies in a bin, and two hundred bricks in piles."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from scipy.spatial.transform import Rotation

from benchmarks.scenes.models import (
    add_box_on_world,
    add_file,
    bodies_of,
    set_free,
    without_visuals,
)
from benchmarks.scenes.scene import Run, Scene, Truth

# File, how many, radius [m] about its origin that holds it.
_OBJECTS = (
    ("manipulation", "hydro/003_cracker_box.sdf", 1, 0.135),
    ("manipulation", "hydro/004_sugar_box.sdf", 2, 0.099),
    ("manipulation", "hydro/006_mustard_bottle.sdf", 1, 0.2),
    ("manipulation", "hydro/005_tomato_soup_can.sdf", 3, 0.061),
    ("manipulation", "hydro/010_potted_meat_can.sdf", 3, 0.069),
    ("manipulation", "hydro/009_gelatin_box.sdf", 3, 0.058),
    ("manipulation", "hydro/061_foam_brick.sdf", 3, 0.066),
    ("robosuite", "objects/square-nut.xml", 2, 0.081),
    ("robosuite", "objects/round-nut.xml", 2, 0.087),
)
_BIN = (0.16, 0.26)  # [m] from the middle within which they fall, their radii included
_GAP, _TRIES = 0.001, 100  # [m]; places of which the lowest is taken
_BRICKS, _HIGH = 200, 5
_SIZE = (0.074, 0.049, 0.049)  # [m]
_OFF, _ASKEW = 0.008, 0.3  # [m], [rad] of a brick in its pile
_APART = 0.12  # [m]


def _build_bin(plant: MultibodyPlant, folder: Path) -> None:
    tray = add_file(plant, "manipulation", "hydro/bin.sdf", folder, without_visuals)
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("bin_base", tray))
    random = np.random.default_rng(0)
    spheres = np.zeros((0, 4))  # centre and radius
    for package, path, count, radius in _OBJECTS:
        for _ in range(count):
            edit = set_free if package == "robosuite" else without_visuals
            model = add_file(plant, package, path, folder, edit)
            room = np.maximum(np.array(_BIN) - radius, 0.0)
            places = random.uniform(-room, room, (_TRIES, 2))
            at = min((_dropped(spheres, xy, radius + _GAP) for xy in places), key=lambda at: at[2])
            spheres = np.vstack([spheres, [*at, radius + _GAP]])
            turned = RotationMatrix(Rotation.random(rng=random).as_matrix())
            base = plant.get_body(plant.GetBodyIndices(model)[0])
            plant.SetDefaultFloatingBaseBodyPose(base, RigidTransform(turned, at))


def _dropped(spheres: np.ndarray, across: np.ndarray, radius: float) -> np.ndarray:
    """Return where a sphere comes to lie that is let down on others, or on the bin's floor."""
    aside = np.linalg.norm(spheres[:, :2] - across, axis=1)
    touch = np.maximum((spheres[:, 3] + radius) ** 2 - aside**2, 0.0)
    over = np.where(touch > 0, spheres[:, 2] + np.sqrt(touch), 0.0)
    return np.array([*across, over.max(initial=0.015 + radius)])


def _build_bricks(plant: MultibodyPlant, folder: Path) -> None:
    add_box_on_world(plant, (4.0, 4.0, 1.0))
    random = np.random.default_rng(0)
    rows = 8
    for i in range(_BRICKS):
        brick = add_file(plant, "manipulation", "hydro/061_foam_brick.sdf", folder)
        pile, level = divmod(i, _HIGH)
        x, y = random.uniform(-_OFF, _OFF, 2) + _APART * np.array(divmod(pile, rows))
        yaw = RollPitchYaw(0.0, 0.0, random.uniform(-_ASKEW, _ASKEW))
        base = plant.GetBodyByName("base_link", brick)
        X_WB = RigidTransform(yaw, [x, y, level * _SIZE[2]])
        plant.SetDefaultFloatingBaseBodyPose(base, X_WB)


def _lie(run: Run, settled: float, softest: float = 0.0) -> dict[str, float]:
    bodies = [run.plant.get_body(i) for i in run.plant.GetFloatingBaseBodies()]
    free = bodies_of(run.plant, *{_model_of(run, body) for body in bodies})
    run.advance(settled)
    carried = run.force_on(free, 0.1) / run.weight(free)
    return {
        "carried [weights]": carried[2],
        "fastest [mm/s]": 1e3 * run.speed(free),
        f"deepest in another{', of hard ones' if softest else ''} [mm]": 1e3 * run.overlap(softest),
    }


def _model_of(run: Run, body: object) -> str:
    return run.plant.GetModelInstanceName(body.model_instance())


SCENES = (
    Scene(
        "20 objects in a bin",
        "Boxes, cans, a bottle in convex pieces, bricks and the bin of `manipulation`'s `hydro`, "
        "four nuts of `robosuite`; turned at random. Hard ones are tagged 1e8 Pa; foam, of 1e5, "
        "the bin, of 1e6, and nuts, of Drake's 1e7, give way by up to millimetres at edges.",
        ("manipulation", "robosuite"),
        _build_bin,
        lambda run: _lie(run, 1.5, softest=1e8),
        {
            "carried [weights]": Truth(1.0, 0.01),
            "fastest [mm/s]": Truth(0.0, 10.0),
            "deepest in another, of hard ones [mm]": Truth(0.0, 0.5),
        },
    ),
    Scene(
        "200 bricks",
        "`hydro/061_foam_brick.sdf` of `manipulation` in 40 piles of 5, askew.",
        ("manipulation",),
        _build_bricks,
        lambda run: _lie(run, 0.9),
        {
            "carried [weights]": Truth(1.0, 1e-3),
            "fastest [mm/s]": Truth(0.0, 0.1),
            "deepest in another [mm]": Truth(0.0, 0.1),
        },
    ),
)
