"""Models of others in a scenario: where they are found, what they need before Drake reads them."""

import numpy as np
import pytest
import trimesh
from pydrake.geometry import Role

from scenarios.format.errors import NotInstalledError, ScenarioError
from scenarios.format.loading import load
from scenarios.format.packages import package_folder
from scenarios.runner import unwatched_meshcat
from scenarios.simulation.assembly import assemble
from scenarios.simulation.record import collect

URDF = """<robot name="lump">
  <link name="lump">
    <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><mesh filename="package://lumps/lump.dae"/></geometry></visual>
    <collision><geometry><mesh filename="package://lumps/lump.stl"/></geometry></collision>
  </link>
</robot>
"""
SCENARIO = """
lump:
  simulation_duration: 0.05
  plant_config: {time_step: 0.001}
  packages: {lumps: lumps}
  directives:
  - add_model: {name: floating, file: package://lumps/lump.urdf}
  - add_model:
      name: falling
      file: lumps/lump.urdf
      default_free_body_pose: {lump: {translation: [1, 0, 0]}}
  without_gravity: [floating]
"""


@pytest.fixture
def lump(tmp_path):
    """A scenario of two bodies from a URDF whose meshes are an .stl and a .dae."""
    folder = tmp_path / "lumps"
    folder.mkdir()
    (folder / "lump.urdf").write_text(URDF)
    (folder / "lump.dae").write_text("<COLLADA/>")
    trimesh.creation.box((0.1, 0.1, 0.1)).export(folder / "lump.stl")
    path = tmp_path / "lump.yaml"
    path.write_text(SCENARIO)
    return load(str(path))[1]


def test_a_model_with_stl_meshes_is_read_and_the_scenario_left_as_it_is(lump, tmp_path):
    """Robots' description files would end in Drake's complaint of MakeConvexHull."""
    files = [directive.add_model.file for directive in lump.directives]
    assembly = assemble(lump, tmp_path / "parts")
    assert len(assembly.contact.model.geometries) == 2
    assert [directive.add_model.file for directive in lump.directives] == files


def test_gravity_acts_on_what_is_not_said_to_be_without(lump, tmp_path):
    """An arm without its controller's compensation would sag, or nothing would fall."""
    assembly = assemble(lump, tmp_path / "parts")
    simulator = assembly.simulator(lump)
    simulator.AdvanceTo(lump.simulation_duration)
    record = collect(assembly, simulator.get_context())
    assert np.ptp(record["floating::lump.z"]) < 1e-12
    assert record["falling::lump.vz"][-1] == pytest.approx(-9.81 * 0.05)
    lump.without_gravity = ["floated"]
    with pytest.raises(ScenarioError, match="without_gravity: no model is called 'floated'"):
        assemble(lump, tmp_path / "again")


def test_what_meshcat_cannot_draw_is_seen_by_its_collision_geometry(lump, tmp_path):
    """A robot with .dae pictures would be invisible, and only its work be seen."""
    assembly = assemble(lump, tmp_path / "parts", unwatched_meshcat())
    inspector = assembly.diagram.GetSubsystemByName("scene_graph").model_inspector()
    frame = assembly.plant.GetBodyFrameIdOrThrow(assembly.contact.bodies[0])
    (shown,) = inspector.GetGeometries(frame, Role.kIllustration)
    assert inspector.GetShape(shown).source().extension() == ".obj"
    assert inspector.GetGeometries(frame, Role.kProximity) == [shown]


def test_folders_of_installed_packages_are_found():
    """Only files that the user has copied could be used."""
    import trimesh.resources

    found = package_folder("meshes", "python://trimesh/resources")
    assert str(found) == trimesh.resources.__path__[0]
    with pytest.raises(ScenarioError, match=r"packages.meshes: .*trimesh/nowhere is not a folder"):
        package_folder("meshes", "python://trimesh/nowhere")
    with pytest.raises(NotInstalledError, match="no_such_robot is not installed; pip install"):
        package_folder("robot", "python://no_such_robot/urdf")
