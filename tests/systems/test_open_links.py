"""Robots whose links are open shells, as CAD exports them."""

from __future__ import annotations

import re
from pathlib import Path

import mesh_shapes
import numpy as np
import pytest
from pydrake.geometry import Box
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from systems import AddNonlinearDamperContact, ContactConfig

SIDE, STEP = 0.1, 2e-3  # [m], [s]
LINK = """<link name="{0}"><inertial><mass value="0.5"/>
<inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><mesh filename="{1}"/></geometry></collision></link>"""
JOINT = """<joint name="{0}_{1}" type="fixed"><parent link="{0}"/><child link="{1}"/>
<origin xyz="{2} 0 0"/></joint>"""


def open_box(folder: Path) -> Path:
    """Write a cube without its lid."""
    path = folder / "shell.obj"
    vertices, faces = mesh_shapes.cube()
    lid = (vertices[faces][:, :, 2] == vertices[:, 2].max()).all(axis=1)
    lines = [f"v {x} {y} {z}" for x, y, z in SIDE * vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in faces[~lid] + 1]
    path.write_text("\n".join(lines))
    return path


def robot(mesh: Path, joint: str) -> str:
    """Return three links in a row, the outer two of which overlap as open shells."""
    names = ("first", "middle", "last")
    links = "".join(LINK.format(name, mesh) for name in names)
    hinges = JOINT.format("first", "middle", 0.03) + JOINT.format("middle", "last", 0.03)
    return f'<robot name="r">{links}{hinges}</robot>'.replace("fixed", joint)


class Scene:
    def __init__(self, folder: Path, models: list[str], **settings: float) -> None:
        builder = DiagramBuilder()
        self.plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=STEP)
        parser = Parser(self.plant)
        parser.SetAutoRenaming(True)
        for i, model in enumerate(models):
            file = folder / f"{i}.urdf"
            file.write_text(model)
            parser.AddModels(str(file))
        table = RigidTransform([0, 0, -0.5])
        rough = CoulombFriction(0.5, 0.5)
        self.plant.RegisterCollisionGeometry(
            self.plant.world_body(), table, Box(4, 4, 1), "table", rough
        )
        self.plant.Finalize()
        config = ContactConfig(**settings)
        self.contact = AddNonlinearDamperContact(builder, self.plant, scene_graph, config=config)
        self.simulator = Simulator(builder.Build())
        context = self.simulator.get_mutable_context()
        self.plant_context = self.plant.GetMyMutableContextFromRoot(context)

    def stand(self) -> None:
        base = self.plant.get_body(next(iter(self.plant.GetFloatingBaseBodies())))
        above = RigidTransform([0, 0, SIDE / 2 + 1e-3])
        self.plant.SetFreeBodyPose(self.plant_context, base, above)


def test_a_robot_of_open_shells_stands(tmp_path: Path):
    """One would be refused for links that need not touch each other."""
    path = open_box(tmp_path)
    with pytest.warns(UserWarning, match="have no inside .* will pass through each other") as said:
        scene = Scene(tmp_path, [robot(path, "revolute")])
    message = str(next(each.message for each in said if "no inside" in str(each.message)))
    assert re.search(rf"geometry 'first/r::\w+' \({path}\) has 4 open edges, the first of", message)
    assert "set standoff" in message
    assert f"`contact-toolkit inspect {path}`" in message
    scene.stand()
    scene.simulator.AdvanceTo(0.5)
    own = scene.contact.GetMyContextFromRoot(scene.simulator.get_context())
    wrenches = scene.contact.get_body_wrenches_output_port().Eval(own).reshape(-1, 6)
    world = scene.contact.bodies.index(scene.plant.world_body().index())
    assert -wrenches[world, 5] == pytest.approx(1.5 * 9.81, rel=1e-3)
    assert np.abs(scene.plant.GetVelocities(scene.plant_context)).max() < 1e-4


def test_a_standoff_lets_open_links_touch(tmp_path: Path):
    """The mend that the warning offers would be in vain."""
    path = open_box(tmp_path)
    scene = Scene(tmp_path, [robot(path, "revolute")], standoff=2e-3)
    names = [scene.contact.model.pair_names(i) for i in range(len(scene.contact.model.pairs))]
    assert any("first" in a and "last" in b for a, b in names)


def test_two_open_bodies_are_refused(tmp_path: Path):
    """Things would fall through each other, and a warning be all there is of it."""
    path = open_box(tmp_path)
    loose = f'<robot name="r">{LINK.format("shell", path)}</robot>'
    with pytest.raises(ValueError, match="neither surface has an inside"):
        Scene(tmp_path, [loose, loose.replace('"r"', '"s"')])
