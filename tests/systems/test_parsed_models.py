"""Models as engineers have them: URDF with meshes and tags, MJCF, welded parts."""

from __future__ import annotations

import numpy as np
import pytest
from pydrake.geometry import Box, HalfSpace
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, LogVectorOutput

from scenarios.parts import make_part, write_obj
from systems import AddNonlinearDamperContact, ContactConfig

MODULUS, DISSIPATION, STATIC, DYNAMIC = 2e5, 3.0, 0.8, 0.6
FINGER = 0.02  # [m] side of the fingers, cubes
PEG_MASS, GRIP = 0.05, 2.0  # [kg], [N]

TAGS = f"""
  <drake:proximity_properties>
    <drake:hydroelastic_modulus value="{MODULUS}"/>
    <drake:hunt_crossley_dissipation value="{DISSIPATION}"/>
    <drake:mu_static value="{STATIC}"/>
    <drake:mu_dynamic value="{DYNAMIC}"/>
  </drake:proximity_properties>"""

INERTIAL = """
  <inertial>
    <mass value="{mass}"/>
    <inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/>
  </inertial>"""


def link(name: str, mass: float, geometry: str) -> str:
    return (
        f'<link name="{name}">{INERTIAL.format(mass=mass)}'
        f'<collision name="shape"><geometry>{geometry}</geometry>{TAGS}</collision></link>'
    )


def slider(name: str, finger: str, x: float, axis: int) -> str:
    return f"""
<joint name="{name}" type="prismatic">
  <parent link="palm"/><child link="{finger}"/>
  <origin xyz="{x} 0 -0.05"/><axis xyz="{axis} 0 0"/>
  <limit lower="-1" upper="1" effort="100" velocity="100"/>
</joint>
<transmission>
  <type>transmission_interface/SimpleTransmission</type>
  <joint name="{name}"/><actuator name="{name}"/>
</transmission>"""


GRIPPER = f"""<?xml version="1.0"?>
<robot name="gripper" xmlns:drake="http://drake.mit.edu">
{link("palm", 1.0, '<box size="0.15 0.05 0.02"/>')}
{link("left", 0.1, '<mesh filename="package://robot/cube.obj" scale="0.2 0.2 0.2"/>')}
{link("right", 0.1, f'<box size="{FINGER} {FINGER} {FINGER}"/>')}
{slider("close_left", "left", -0.035, 1)}
{slider("close_right", "right", 0.035, -1)}
<drake:collision_filter_group name="hand">
  <drake:member link="palm"/><drake:member link="left"/><drake:member link="right"/>
  <drake:ignored_collision_filter_group name="hand"/>
</drake:collision_filter_group>
</robot>"""

PEG = f"""<?xml version="1.0"?>
<robot name="peg" xmlns:drake="http://drake.mit.edu">
{link("peg", PEG_MASS, '<cylinder radius="0.02" length="0.04"/>')}
</robot>"""

MJCF = """<mujoco model="scene">
  <default><geom friction="0.7"/></default>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 .1"/>
    <body name="ball" pos="0 0 .06"><freejoint/><geom name="b" type="sphere" size=".05"/></body>
    <body name="arm" pos="-.5 0 .5">
      <joint name="hinge" type="hinge" axis="0 1 0"/>
      <geom name="a" type="box" size=".02 .02 .2" pos="0 0 -.2"/>
    </body>
  </worldbody>
</mujoco>"""


@pytest.fixture
def package(tmp_path):
    """A package of a robot, with a cube of 0.1 m in it."""
    write_obj(tmp_path / "cube.obj", make_part("box"))
    (tmp_path / "package.xml").write_text("<package><name>robot</name></package>")
    (tmp_path / "gripper.urdf").write_text(GRIPPER)
    (tmp_path / "peg.urdf").write_text(PEG)
    return tmp_path


def gripper(package, builder):
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    parser = Parser(plant)
    parser.package_map().Add("robot", str(package))
    parser.AddModels(url="package://robot/gripper.urdf")
    parser.AddModels(url="package://robot/peg.urdf")
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("palm"), RigidTransform([0, 0, 0.2]))
    plant.Finalize()
    grip = builder.AddSystem(ConstantVectorSource([GRIP, GRIP]))
    builder.Connect(grip.get_output_port(), plant.get_actuation_input_port())
    return plant, scene_graph


def test_urdf_brings_its_meshes_tags_and_filters(package):
    """A scale, a tag or a collision filter of the file that is not heeded."""
    builder = DiagramBuilder()
    plant, scene_graph = gripper(package, builder)
    with pytest.warns(UserWarning, match="leaves out the limits of close_left, close_right"):
        contact = AddNonlinearDamperContact(builder, plant, scene_graph)
    geometries = contact.model.geometries
    names = {frozenset(contact.model.pair_names(i)) for i in range(len(contact.model.pairs))}
    peg = "peg/peg::shape"
    assert names == {
        frozenset((f"{finger}/gripper::shape", peg)) for finger in ("palm", "left", "right")
    }
    left = next(each for each in geometries if each.name.startswith("left"))
    np.testing.assert_allclose(left.mesh.upper - left.mesh.lower, FINGER)
    for pair in contact.model.pairs:
        assert pair.damper.alpha == pytest.approx(2 / 3 * DISSIPATION)
        assert pair.friction.static == pytest.approx(STATIC)
        assert pair.friction.dynamic == pytest.approx(DYNAMIC)
        # Two moduli over two skins of 1 % of the smaller body, in series.
        diagonal = min(geometries[side].mesh.diagonal for side in (pair.a, pair.b))
        assert pair.damper.k == pytest.approx(MODULUS / (2 * 0.01 * diagonal))


def test_gripper_of_a_urdf_holds_what_it_grips(package):
    """A peg that slips through the fingers, or is pressed by other than the actuators' force."""
    builder = DiagramBuilder()
    plant, scene_graph = gripper(package, builder)
    with pytest.warns(UserWarning, match="leaves out the limits of close_left, close_right"):
        contact = AddNonlinearDamperContact(
            builder, plant, scene_graph, config=ContactConfig(resolution=0.1)
        )
    log = LogVectorOutput(contact.get_energies_output_port(), builder)
    simulator = Simulator(builder.Build())
    context = simulator.get_context()
    peg = plant.GetBodyByName("peg")
    plant.SetFreeBodyPose(
        plant.GetMyMutableContextFromRoot(simulator.get_mutable_context()),
        peg,
        RigidTransform([0, 0, 0.15]),
    )
    simulator.AdvanceTo(0.5)
    held = plant.EvalBodyPoseInWorld(plant.GetMyContextFromRoot(context), peg).translation()
    simulator.AdvanceTo(0.7)
    later = plant.EvalBodyPoseInWorld(plant.GetMyContextFromRoot(context), peg).translation()
    assert held[2] > 0.14
    np.testing.assert_allclose(later, held, atol=1e-6)

    contacts = contact.get_contacts_output_port().Eval(contact.GetMyContextFromRoot(context))
    force_on_a = contacts.normal_force[:, None] * contacts.normal_F + contacts.friction_force_F
    for finger, sign in (("left", 1), ("right", -1)):
        of_finger = np.zeros(3)
        for index in range(len(contact.model.pairs)):
            a, b = contact.model.pair_names(index)
            share = force_on_a[contacts.pair == index].sum(axis=0)
            of_finger += a.startswith(finger) * share - b.startswith(finger) * share
        assert of_finger[0] == pytest.approx(-sign * GRIP, rel=1e-3)
    *stored_and_lost, numerically = log.FindLog(context).data()[:, -1]
    assert min(stored_and_lost) > 0
    assert numerically == 0  # it is the discrete step that loses so


@pytest.mark.parametrize("time_step", [0.0, 1e-3])
def test_mjcf_rests_on_its_floor(tmp_path, time_step):
    """A plane, friction or a joint of the file that is lost."""
    (tmp_path / "scene.xml").write_text(MJCF)
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step)
    Parser(plant).AddModels(str(tmp_path / "scene.xml"))
    plant.Finalize()
    contact = AddNonlinearDamperContact(
        builder,
        plant,
        scene_graph,
        config=ContactConfig(k=1e6, alpha=1.0, tessellation_tolerance=2e-4),
    )
    assert [pair.friction.static for pair in contact.model.pairs] == pytest.approx([0.7] * 3)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(2.0)
    context = plant.GetMyContextFromRoot(simulator.get_context())
    ball = plant.GetBodyByName("ball")
    depth = 0.05 - plant.EvalBodyPoseInWorld(context, ball).translation()[2]
    weight = ball.get_mass(context) * 9.81
    contacts = contact.get_contacts_output_port().Eval(
        contact.GetMyContextFromRoot(simulator.get_context())
    )
    assert [contact.model.pair_names(i)[0] for i in set(contacts.pair)] == ["world/floor"]
    pressed = -(contacts.normal_force[:, None] * contacts.normal_F).sum(axis=0)
    rubbed = -contacts.friction_force_F.sum(axis=0)
    # The floor is sampled, and a node r from the axis is R − √((R − δ)² + r²) deep in the ball and
    # pushes towards its center: upwards, that adds up to π k (R − δ) δ². The rest of the weight
    # hangs on the friction along the flank of the dent.
    assert pressed[2] == pytest.approx(np.pi * 1e6 * (0.05 - depth) * depth**2, rel=1e-3)
    np.testing.assert_allclose(pressed + rubbed, [0, 0, weight], atol=1e-3 * weight)


def test_welded_parts_act_as_one_body():
    """Forces within a rigid assembly, a part that passes through, or one whose weight is lost."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    rough = CoulombFriction(0.5, 0.5)
    plant.RegisterCollisionGeometry(
        plant.world_body(), RigidTransform(), HalfSpace(), "ground", rough
    )
    bodies = [
        plant.AddRigidBody(name, SpatialInertia.SolidBoxWithMass(1.0, 0.1, 0.1, 0.1))
        for name in ("upper", "lower")
    ]
    for body in bodies:
        plant.RegisterCollisionGeometry(body, RigidTransform(), Box(0.1, 0.1, 0.1), "box", rough)
    X_UL = RigidTransform([0, 0, -0.08])  # the boxes overlap
    plant.WeldFrames(bodies[0].body_frame(), bodies[1].body_frame(), X_UL)
    plant.Finalize()
    k = 1e7
    config = ContactConfig(k=k, alpha=1.0, resolution=0.1)
    contact = AddNonlinearDamperContact(builder, plant, scene_graph, config=config)
    assert len(contact.model.pairs) == 2  # either part with the ground
    simulator = Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    plant.SetFreeBodyPose(context, bodies[0], RigidTransform([0, 0, 0.131]))
    simulator.AdvanceTo(0.5)
    sunk = 0.13 - plant.EvalBodyPoseInWorld(context, bodies[0]).translation()[2]
    assert sunk == pytest.approx(2 * 9.81 / (k * 0.01), rel=0.01)
