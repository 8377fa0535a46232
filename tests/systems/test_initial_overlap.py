"""Bodies that overlap when a simulation begins: told of, and parted without being flung."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from pydrake.geometry import Box, SceneGraph
from pydrake.math import RigidTransform
from pydrake.multibody.plant import (
    AddMultibodyPlantSceneGraph,
    CoulombFriction,
    MultibodyPlant,
)
from pydrake.multibody.tree import FixedOffsetFrame, PrismaticJoint, RevoluteJoint, SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from systems import AddNonlinearDamperContact, ContactConfig

SIDE, MASS, GRAVITY, TABLE = 0.1, 0.5, 9.81, 2.0  # [m], [kg], [m/s²], [m]


FRICTION = CoulombFriction(0.5, 0.5)
INERTIA = SpatialInertia.SolidBoxWithMass(MASS, SIDE, SIDE, SIDE)


def with_table() -> tuple[DiagramBuilder, MultibodyPlant, SceneGraph]:
    """A plant whose world is a table."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=2e-3)
    table = RigidTransform([0, 0, -0.5]), Box(TABLE, TABLE, 1)
    plant.RegisterCollisionGeometry(plant.world_body(), *table, "table", FRICTION)
    return builder, plant, scene_graph


class Scene:
    """A box on a table, and two links on a hinge that overlap each other beside it."""

    def __init__(self, *, depth: float, links: bool = False, **settings: Any) -> None:
        builder, self.plant, scene_graph = with_table()
        cube = Box(SIDE, SIDE, SIDE)
        self.box = self.plant.AddRigidBody("box", INERTIA)
        self.plant.RegisterCollisionGeometry(self.box, RigidTransform(), cube, "box", FRICTION)
        if links:
            robot = self.plant.AddModelInstance("robot")
            lower, upper, far = (
                self.plant.AddRigidBody(name, robot, INERTIA) for name in ("lower", "upper", "far")
            )
            for link, y in ((lower, 0.0), (far, SIDE - 5e-3)):
                X_BG = RigidTransform([0.0, y, 0.0])
                self.plant.RegisterCollisionGeometry(link, X_BG, cube, "link", FRICTION)
            for parent, child in ((lower, upper), (upper, far)):
                self.plant.AddJoint(
                    RevoluteJoint(
                        f"{child.name()}_hinge",
                        parent.body_frame(),
                        child.body_frame(),
                        [1.0, 0.0, 0.0],
                    )
                )
            self.lower = lower
        self.plant.Finalize()
        self.contact = AddNonlinearDamperContact(
            builder, self.plant, scene_graph, config=ContactConfig(**settings)
        )
        self.simulator = Simulator(builder.Build())
        self.context = self.plant.GetMyMutableContextFromRoot(self.simulator.get_mutable_context())
        self.plant.SetFreeBodyPose(self.context, self.box, RigidTransform([0, 0, SIDE / 2 - depth]))
        if links:
            self.plant.SetFreeBodyPose(self.context, self.lower, RigidTransform([0.5, 0, SIDE / 2]))

    def height(self) -> float:
        return float(self.plant.EvalBodyPoseInWorld(self.context, self.box).translation()[2])


def test_overlap_is_parted_at_its_own_pace_and_ends_at_rest():
    """Two millimetres of overlap at 2e7 N/m would fling the box metres high, or never end."""
    depth, time = 2e-3, 0.2
    scene = Scene(depth=depth)
    with pytest.warns(RuntimeWarning, match=r"overlap at the start: .*table and box.* by 2 mm"):
        scene.simulator.Initialize()
    top, fastest = 0.0, 0.0
    for i in range(1, 101):
        scene.simulator.AdvanceTo(i * 5e-3)
        top = max(top, scene.height())
        speed = abs(float(scene.plant.GetVelocities(scene.context)[5]))
        fastest = max(fastest, speed)
    assert top < SIDE / 2 + 1e-5
    assert fastest < 2 * depth / time
    assert scene.height() == pytest.approx(SIDE / 2, abs=1e-5)
    wrenches = scene.contact.get_body_wrenches_output_port().Eval(
        scene.contact.GetMyContextFromRoot(scene.simulator.get_context())
    )
    assert wrenches.reshape(-1, 6)[1, 5] == pytest.approx(MASS * GRAVITY, rel=1e-3)


def test_links_of_one_robot_that_overlap_pass_through_each_other():
    """A robot whose links overlap at rest, as MuJoCo's and Unitree's do, would fly apart."""
    scene = Scene(depth=0.0, links=True)
    with pytest.warns(
        RuntimeWarning, match=r"lower/.*link and far/.*link by 5.* mm.*pass through each other"
    ):
        scene.simulator.Initialize()
    scene.simulator.AdvanceTo(0.1)
    # Its far link hangs over and begins to tip; 1e5 N would make it some 1e4 m/s.
    assert np.abs(scene.plant.GetVelocities(scene.context)).max() < 0.1


def test_overlap_can_be_an_error_or_left_alone():
    """A user who wants to know, or to keep the old way, would not be heeded."""
    with pytest.raises(RuntimeError, match=r"table and .*box.* by 2 mm .*; start apart"):
        Scene(depth=2e-3, initial_overlap="raise").simulator.Initialize()
    scene = Scene(depth=2e-3, initial_overlap="warn")
    with pytest.warns(RuntimeWarning, match="they will be flung apart"):
        scene.simulator.Initialize()
    scene = Scene(depth=2e-3, initial_overlap="filter")
    with pytest.warns(RuntimeWarning, match="pass through each other"):
        scene.simulator.Initialize()
    scene.simulator.AdvanceTo(0.1)
    assert scene.height() < SIDE / 2 - 2e-3 - 0.04  # g t²/2 = 49 mm
    with pytest.raises(ValueError, match="initial_overlap must be one of"):
        Scene(depth=0.0, initial_overlap="explode")


def test_what_lies_on_its_skin_is_no_overlap():
    """Every resting body would be told of, and held back."""
    scene = Scene(depth=MASS * GRAVITY / (2.9e9 * SIDE**2))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene.simulator.Initialize()


def test_initializing_again_keeps_what_contact_remembers():
    """A held body would lose its anchors, and slip, whenever a run is taken up again."""
    scene = Scene(depth=0.0)
    scene.simulator.AdvanceTo(0.1)
    before = scene.simulator.get_context().Clone()
    scene.simulator.Initialize()
    lost = [
        scene.contact.get_energies_output_port().Eval(scene.contact.GetMyContextFromRoot(context))
        for context in (before, scene.simulator.get_context())
    ]
    np.testing.assert_array_equal(*lost)


class Mounted:
    """A link on a joint to the world, and a second one on a hinge to the first."""

    def __init__(
        self,
        axis: tuple[float, float, float],
        height: float,
        X_AB: RigidTransform | None = None,
    ) -> None:
        builder, self.plant, scene_graph = with_table()
        world = self.plant.world_body()
        robot = self.plant.AddModelInstance("robot")
        first = self.plant.AddRigidBody("first", robot, INERTIA)
        second = self.plant.AddRigidBody("second", robot, INERTIA)
        cube = Box(SIDE, SIDE, SIDE)
        self.plant.RegisterCollisionGeometry(first, RigidTransform(), cube, "cube", FRICTION)
        base = self.plant.AddFrame(
            FixedOffsetFrame("base", world.body_frame(), RigidTransform([0.0, 0.0, height]))
        )
        self.slider = self.plant.AddJoint(PrismaticJoint("slider", base, first.body_frame(), axis))
        self.plant.AddJoint(
            RevoluteJoint("hinge", first.body_frame(), second.body_frame(), [1.0, 0.0, 0.0])
        )
        # Drake filters what a joint joins, not what is welded to it: a bearing, a gear.
        welded = self.plant.AddRigidBody("welded", robot, INERTIA)
        self.plant.WeldFrames(second.body_frame(), welded.body_frame())
        if X_AB is not None:
            self.plant.RegisterCollisionGeometry(welded, X_AB, cube, "cube", FRICTION)
        self.plant.mutable_gravity_field().set_gravity_vector([1.0, 0.0, -GRAVITY])
        self.plant.Finalize()
        AddNonlinearDamperContact(builder, self.plant, scene_graph)
        self.simulator = Simulator(builder.Build())
        self.context = self.plant.GetMyContextFromRoot(self.simulator.get_context())


def test_what_joints_hold_in_the_ground_passes_through_it():
    """A cart on a rail drawn through it would be clamped by meganewtons, and take minutes."""
    scene = Mounted((1.0, 0.0, 0.0), 0.0)
    with pytest.warns(RuntimeWarning, match=r"table and first.* by 50 mm .*its joints hold"):
        scene.simulator.Initialize()
    steps = 50
    scene.simulator.AdvanceTo(steps * 2e-3)
    # Freely along the rail at 1 m/s², by symplectic Euler.
    assert scene.slider.get_translation(scene.context) == pytest.approx(
        steps * (steps + 1) / 2 * 2e-3**2, rel=1e-9
    )


def test_what_joints_let_out_of_the_ground_is_parted():
    """A mounted link that starts a little in the table would sink through it for good."""
    depth = 2e-3
    scene = Mounted((0.0, 0.0, 1.0), SIDE / 2 - depth)
    with pytest.warns(RuntimeWarning, match=r"table and first.* by 2 mm .*parted gently"):
        scene.simulator.Initialize()
    scene.simulator.AdvanceTo(0.5)
    assert scene.slider.get_translation(scene.context) == pytest.approx(depth, abs=1e-5)


def test_links_drawn_at_one_place_pass_through_each_other():
    """Surfaces that coincide are nowhere deep: two legs of a walker would be held together."""
    scene = Mounted((1.0, 0.0, 0.0), 1.0, RigidTransform())
    with pytest.warns(RuntimeWarning, match=r"first.* and welded.* by 50 mm .*pass through"):
        scene.simulator.Initialize()


def test_what_only_touches_goes_on_touching():
    """Faces of a hinge bear next to nothing where it stands; what comes after is not known."""
    for p in ([SIDE - 1e-9, 0.0, 0.0], [0.0, SIDE - 1e-9, 0.0]):
        scene = Mounted((1.0, 0.0, 0.0), 1.0, RigidTransform(p))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            scene.simulator.Initialize()
