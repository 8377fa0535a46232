"""Models and bodies whose meshes Drake does not read, from the file to rest on the floor."""

from pathlib import Path

import mesh_shapes
import numpy as np
import pytest
import trimesh
from pydrake.geometry import Box
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction, MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from contact_toolkit import MeshError
from systems import AddNonlinearDamperContact, add_mesh_body, parse_model

EXTENSIONS = ["stl", "ply", "off", "glb", "gltf", "obj"]
SIZE = np.array([0.1, 0.06, 0.04])
V, F = mesh_shapes.cube()
# Drake stands what glTF lays down: (x, y, z) -> (x, -z, y).
STANDING = {"glb": SIZE[[0, 2, 1]], "gltf": SIZE[[0, 2, 1]]}

LINK = """<inertial><mass value="0.24"/><inertia ixx="1e-4" iyy="2e-4" izz="2e-4" ixy="0" ixz="0"
iyz="0"/></inertial>"""


def export(folder: Path, extension: str, scale: float = 1.0) -> Path:
    path = folder / f"brick.{extension}"
    mesh = trimesh.Trimesh(V * SIZE * scale, F, process=False)
    if extension == "gltf":
        for name, data in trimesh.exchange.gltf.export_gltf(trimesh.Scene(mesh)).items():
            (folder / (path.name if name == "model.gltf" else name)).write_bytes(data)
        return path
    data = mesh.export(file_type=extension)
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return path


def urdf(mesh: str) -> str:
    shape = f'<geometry><mesh filename="{mesh}" scale="0.001 0.001 0.001"/></geometry>'
    return (
        f'<robot name="r"><link name="brick">{LINK}<visual>{shape}</visual>'
        f"<collision>{shape}</collision></link></robot>"
    )


def sdf(mesh: str) -> str:
    shape = f"<geometry><mesh><uri>{mesh}</uri><scale>0.001 0.001 0.001</scale></mesh></geometry>"
    inertia = "<ixx>1e-4</ixx><iyy>2e-4</iyy><izz>2e-4</izz>"
    return (
        '<sdf version="1.9"><model name="r"><link name="brick"><inertial><mass>0.24</mass>'
        f'<inertia>{inertia}</inertia></inertial><visual name="v">{shape}</visual>'
        f'<collision name="c">{shape}</collision></link></model></sdf>'
    )


def mjcf(mesh: str) -> str:
    return (
        f'<mujoco model="r"><compiler meshdir="."/><asset><mesh name="m" file="{mesh}" '
        'scale="0.001 0.001 0.001"/></asset><worldbody><body name="brick"><freejoint/>'
        '<inertial pos="0 0 0" mass="0.24" diaginertia="1e-4 2e-4 2e-4"/>'
        '<geom type="mesh" mesh="m"/></body></worldbody></mujoco>'
    )


class Table:
    """A floor at z = 0, and what is put on it."""

    def __init__(self) -> None:
        self.builder = DiagramBuilder()
        self.plant, self.scene_graph = AddMultibodyPlantSceneGraph(self.builder, 0.002)
        self.plant.RegisterCollisionGeometry(
            self.plant.world_body(),
            RigidTransform([0, 0, -0.5]),
            Box(2, 2, 1),
            "floor",
            CoulombFriction(0.5, 0.5),
        )

    def rest(self, body: str, height: float) -> float:
        """Let the body fall a millimetre; return where it comes to rest."""
        self.plant.Finalize()
        AddNonlinearDamperContact(self.builder, self.plant, self.scene_graph)
        diagram = self.builder.Build()
        simulator = Simulator(diagram)
        context = self.plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
        brick = self.plant.GetBodyByName(body)
        self.plant.SetFreeBodyPose(context, brick, RigidTransform([0, 0, height + 1e-3]))
        simulator.AdvanceTo(0.3)
        return float(self.plant.EvalBodyPoseInWorld(context, brick).translation()[2])


@pytest.mark.parametrize("extension", EXTENSIONS)
@pytest.mark.parametrize(("form", "write"), [("urdf", urdf), ("sdf", sdf), ("xml", mjcf)])
def test_models_with_meshes_of_any_kind(tmp_path, extension, form, write):
    """Drake refuses ("MakeConvexHull only applies to"); a brick of the wrong size, or askew."""
    if form == "xml" and extension == "gltf":
        pytest.skip("Drake's MJCF takes no .gltf")
    export(tmp_path, extension, scale=1e3)
    model = tmp_path / f"model.{form}"
    model.write_text(write(f"brick.{extension}"))
    table = Table()
    instances = parse_model(Parser(table.plant), model, cache=tmp_path / "cache")
    assert len(instances) == 1
    half = STANDING.get(extension, SIZE)[2] / 2
    assert table.rest("brick", half) == pytest.approx(half, abs=1e-5)


def test_packages_are_found_and_files_written_once(tmp_path):
    """A model in a ROS package refused, or its meshes converted at every start."""
    package = tmp_path / "bricks"
    (package / "meshes").mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>bricks</name></package>")
    export(package / "meshes", "stl", scale=1e3)
    (package / "brick.urdf").write_text(urdf("package://bricks/meshes/brick.stl"))
    cache = tmp_path / "cache"
    written = []
    for _ in range(2):
        plant = MultibodyPlant(0.0)
        parse_model(plant, package / "brick.urdf", cache=cache)
        assert plant.HasBodyNamed("brick")
        written.append({path: path.stat().st_mtime_ns for path in cache.rglob("*.obj")})
    assert len(written[0]) == 1
    assert written[0] == written[1]


@pytest.mark.parametrize("declared", [' xmlns:drake="http://drake.mit.edu"', ""])
def test_drake_s_own_tags_outlast_the_copy(tmp_path, declared):
    """Tags that are lost under another prefix; a model refused that Drake reads undeclared."""
    export(tmp_path, "stl", scale=1e3)
    tag = '<drake:proximity_properties><drake:mu_static value="0.7"/></drake:proximity_properties>'
    text = urdf("brick.stl").replace("</collision>", f"{tag}</collision>")
    (tmp_path / "model.urdf").write_text(text.replace('name="r"', f'name="r"{declared}'))
    plant, scene_graph = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.002)
    parse_model(plant, tmp_path / "model.urdf", cache=tmp_path)
    (geometry,) = plant.GetCollisionGeometriesForBody(plant.GetBodyByName("brick"))
    properties = scene_graph.model_inspector().GetProximityProperties(geometry)
    friction = properties.GetProperty("material", "coulomb_friction")
    assert friction.static_friction() == 0.7


def test_a_broken_mesh_is_named_with_its_model(tmp_path):
    """An error of the reader's that does not say which of a robot's meshes it is about."""
    (tmp_path / "brick.stl").write_bytes(b"solid nothing")
    (tmp_path / "model.urdf").write_text(urdf("brick.stl"))
    with pytest.raises(MeshError, match=r"model\.urdf: mesh 'brick\.stl': .*brick\.stl: .*cut off"):
        parse_model(MultibodyPlant(0.0), tmp_path / "model.urdf", cache=tmp_path)
    (tmp_path / "model.urdf").write_text(urdf("missing.stl"))
    with pytest.raises(MeshError, match=r"mesh 'missing\.stl': .*no such file"):
        parse_model(MultibodyPlant(0.0), tmp_path / "model.urdf", cache=tmp_path)


@pytest.mark.parametrize("extension", EXTENSIONS)
def test_a_body_from_a_mesh_file(tmp_path, extension):
    """A body of the wrong mass, inertia or size, or one that falls through the floor."""
    table = Table()
    made = add_mesh_body(table.plant, export(tmp_path, extension, 1e3), density=1000, scale=1e-3)
    size = STANDING.get(extension, SIZE)
    assert made.mass == pytest.approx(0.24, rel=1e-6)
    x, y, z = size**2 * made.mass / 12
    inertia = made.body.default_spatial_inertia().CalcRotationalInertia()
    np.testing.assert_allclose(inertia.get_moments(), [y + z, x + z, x + y], rtol=1e-5)
    assert made.report == ""
    assert table.rest("brick", size[2] / 2) == pytest.approx(size[2] / 2, abs=1e-5)


def test_the_report_of_a_body_from_a_nearly_clean_file(tmp_path):
    """A doubled facet that doubles the mass, or is put right in silence; an open mesh with mass."""
    lines = [f"v {x} {y} {z}" for x, y, z in V * SIZE]
    doubled = [*F, F[3, ::-1]]
    lines += [f"f {a} {b} {c}" for a, b, c in np.array(doubled) + 1]
    path = tmp_path / "brick.obj"
    path.write_text("\n".join(lines))
    made = add_mesh_body(MultibodyPlant(0.0), path)
    assert made.mass == pytest.approx(0.24)
    assert "1 duplicate facet, the first facet 12" in made.report
    assert "1 facet left out as duplicates" in made.report
    path.write_text("\n".join(lines[:-3]))
    with pytest.raises(MeshError, match=r"bounds no solid.*open edges.*contact-toolkit inspect"):
        add_mesh_body(MultibodyPlant(0.0), path)
    with pytest.raises(ValueError, match="scale must be positive"):
        add_mesh_body(MultibodyPlant(0.0), path, scale=0)
