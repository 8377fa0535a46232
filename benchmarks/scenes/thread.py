"""A nut on its bolt, both read from files: it climbs by its pitch, whatever turns it."""

from __future__ import annotations

import math
from pathlib import Path

import trimesh
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import MultibodyPlant

from benchmarks.scenes.scene import Run, Scene, Truth
from contact_toolkit.parts import bolt, nut
from systems import add_mesh_body

_PITCH = 0.002  # [m]
_STEEL, _OILED = 7850.0, (0.005, 0.005)  # [kg/m³], [-]
_SECTIONS = {"sections": 72, "flank_rows": 2}
_STARTED, _TURNED = 0.1, 0.3  # [s]


def _build(plant: MultibodyPlant, folder: Path) -> None:
    """Two pairs as .stl files in millimetres: an oiled one, and a dry one with default friction."""
    for name, surface in (("bolt", bolt(length=0.05, **_SECTIONS)), ("nut", nut(**_SECTIONS))):
        vertices, faces = surface
        trimesh.Trimesh(1e3 * vertices, faces, process=False).export(folder / f"{name}.stl")
    for i, (state, friction) in enumerate((("oiled", {"friction": _OILED}), ("dry", {}))):
        for name, height in (("bolt", 0.0), ("nut", 0.04)):
            file = folder / f"{name}.stl"
            made = add_mesh_body(
                plant, file, name=f"{state} {name}", density=_STEEL, scale=1e-3, **friction
            )
            X_WB = RigidTransform([0.1 * i, 0.0, height])
            if name == "bolt":
                plant.WeldFrames(plant.world_frame(), made.body.body_frame(), X_WB)
            else:
                plant.SetDefaultFloatingBaseBodyPose(made.body, X_WB)


def _turn(run: Run) -> dict[str, float]:
    run.advance(_STARTED)
    before = {name: run.pose(name) for name in ("oiled nut", "dry nut")}
    run.advance(_TURNED)
    moved = {name: X.inverse() @ run.pose(name) for name, X in before.items()}
    oiled, dry = moved["oiled nut"], moved["dry nut"]
    turned = RollPitchYaw(oiled.rotation()).yaw_angle()
    return {
        "pitch [mm a turn]": 1e3 * 2 * math.pi * oiled.translation()[2] / turned,
        "the dry one sinks [µm/s]": -1e6 * dry.translation()[2] / _TURNED,
    }


SCENES = (
    Scene(
        "nut on bolt from a file",
        "M16 × 2 from .stl files in millimetres by `add_mesh_body`; density, and oil for one pair.",
        (),
        _build,
        _turn,
        {
            "pitch [mm a turn]": Truth(1e3 * _PITCH, 0.02),
            "the dry one sinks [µm/s]": Truth(0.0, 1.0),
        },
    ),
)
