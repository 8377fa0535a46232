"""Turn the parts of a scenario into models that a Drake parser reads."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import trimesh

from scenarios.parts import make_part, write_obj
from scenarios.scenario import Part

PACKAGE = "parts"

_SDF = """<?xml version="1.0"?>
<sdf version="1.9">
  <model name="{name}">
    <link name="{name}">
      <inertial>
        <mass>{mass!r}</mass>
        <pose>{x!r} {y!r} {z!r} 0 0 0</pose>
        <inertia>
          <ixx>{ixx!r}</ixx><iyy>{iyy!r}</iyy><izz>{izz!r}</izz>
          <ixy>{ixy!r}</ixy><ixz>{ixz!r}</ixz><iyz>{iyz!r}</iyz>
        </inertia>
      </inertial>
      <visual name="visual">
        <geometry><mesh><uri>{name}.obj</uri></mesh></geometry>
        <material><diffuse>{rgba}</diffuse></material>
      </visual>
      <collision name="collision">
        <geometry><mesh><uri>{name}.obj</uri></mesh></geometry>
      </collision>
    </link>
  </model>
</sdf>
"""


def write_models(parts: Mapping[str, Part], folder: Path) -> None:
    """Write NAME.obj and NAME.sdf for every part into `folder`, a package for a Drake parser.

    Raises ValueError naming the part whose parameters are impossible.
    """
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "package.xml").write_text(f"<package><name>{PACKAGE}</name></package>\n")
    for name, part in parts.items():
        surface = make_part(part.generator, part.parameters)
        write_obj(folder / f"{name}.obj", surface)
        solid = trimesh.Trimesh(*surface, process=False)
        solid.density = part.density
        inertia, (x, y, z) = np.asarray(solid.moment_inertia), solid.center_mass.tolist()
        axes = {"x": 0, "y": 1, "z": 2}
        moments = {f"i{a}{b}": float(inertia[axes[a], axes[b]]) for a in axes for b in axes}
        rgba = " ".join(str(channel) for channel in part.rgba)
        (folder / f"{name}.sdf").write_text(
            _SDF.format(name=name, mass=float(solid.mass), x=x, y=y, z=z, rgba=rgba, **moments)
        )
