"""NonlinearDamperContact as a Drake system: routes, independence of contexts, reproducibility."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from pydrake.geometry import Box, Capsule, Ellipsoid, HalfSpace
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    QuaternionFloatingJoint,
    RevoluteJoint,
    RigidBody,
    RpyFloatingJoint,
    SpatialInertia,
    UnitInertia,
)
from pydrake.systems.analysis import (
    GetIntegrationSchemes,
    ResetIntegratorFromFlags,
    Simulator,
)
from pydrake.systems.framework import Context, DiagramBuilder

from contact_toolkit import NonlinearDamper
from systems import AddNonlinearDamperContact, ContactConfig, NonlinearDamperContact

CONFIG = {"web": "facet", "standoff": 0.02, "k": 2e3, "alpha": 0.3}


def rewire_by_lists(
    builder: DiagramBuilder, plant: MultibodyPlant, contact: NonlinearDamperContact
) -> NonlinearDamperContact:
    """Put in its place one that is wired by hand, by lists alone."""
    by_lists = NonlinearDamperContact(plant, contact.model, contact.bodies, lists_only=True)
    builder.RemoveSystem(contact)
    builder.AddSystem(by_lists)
    builder.Connect(plant.get_body_poses_output_port(), by_lists.get_body_poses_input_port())
    builder.Connect(
        plant.get_body_spatial_velocities_output_port(),
        by_lists.get_body_spatial_velocities_input_port(),
    )
    builder.Connect(
        by_lists.get_spatial_forces_output_port(), plant.get_applied_spatial_force_input_port()
    )
    return by_lists


class Tumble:
    """Two capsules thrown onto a plate that is welded to the world askew, one above the other."""

    def __init__(self, *, lists_only: bool = False, time_step: float = 0.0, **config) -> None:
        builder = DiagramBuilder()
        self.plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step)
        slippery = CoulombFriction(0, 0)
        inertia = SpatialInertia.SolidCapsuleWithMass(0.5, 0.04, 0.1, [0, 0, 1])
        self.capsules = [self.plant.AddRigidBody(name, inertia) for name in ("low", "high")]
        for capsule in self.capsules:
            self.plant.RegisterCollisionGeometry(
                capsule, RigidTransform([0, 0, 0.01]), Capsule(0.04, 0.1), "capsule", slippery
            )
        plate = self.plant.AddRigidBody("plate", inertia)
        tilted = RigidTransform(RollPitchYaw(0.1, 0.2, 0.0), [0, 0, -0.1])
        self.plant.WeldFrames(self.plant.world_frame(), plate.body_frame(), tilted)
        self.plant.RegisterCollisionGeometry(
            plate, RigidTransform(), Box(1, 1, 0.1), "plate", slippery
        )
        self.plant.Finalize()
        settings = ContactConfig(tessellation_tolerance=0.1, **CONFIG | config)
        self.contact = AddNonlinearDamperContact(builder, self.plant, scene_graph, config=settings)
        if lists_only:
            self.contact = rewire_by_lists(builder, self.plant, self.contact)
        self.diagram = builder.Build()

    def simulator(self, spin: float = 3.0, *, accuracy: float = 1e-3) -> Simulator:
        simulator = Simulator(self.diagram)
        if self.plant.time_step() == 0:
            simulator.get_mutable_integrator().set_target_accuracy(accuracy)
        plant_context = self.plant.GetMyContextFromRoot(simulator.get_mutable_context())
        for i, capsule in enumerate(self.capsules):
            X_WB = RigidTransform(RollPitchYaw(0.3 + i, 0.5, 0), [0.02 * i, 0, 0.05 + 0.15 * i])
            self.plant.SetFreeBodyPose(plant_context, capsule, X_WB)
        self.plant.SetVelocities(plant_context, np.resize([spin, 1, 0, 0.1, 0, -0.5], 12))
        simulator.Initialize()
        return simulator

    def state(self, simulator: Simulator) -> np.ndarray:
        plant_context = self.plant.GetMyContextFromRoot(simulator.get_context())
        return self.plant.GetPositionsAndVelocities(plant_context).copy()

    def energies(self, simulator: Simulator) -> np.ndarray:
        context = self.contact.GetMyContextFromRoot(simulator.get_context())
        return self.contact.get_energies_output_port().Eval(context).copy()


def end_state(tumble: Tumble, duration: float = 0.4, **settings: float) -> np.ndarray:
    simulator = tumble.simulator(**settings)
    simulator.AdvanceTo(duration)
    assert tumble.energies(simulator)[2] > 0, "nothing ever touched"
    return np.concatenate([tumble.state(simulator), tumble.energies(simulator)])


def test_same_simulation_twice_gives_the_same_bits():
    tumble = Tumble()
    first = end_state(tumble)
    np.testing.assert_array_equal(first, end_state(tumble))
    np.testing.assert_array_equal(first, end_state(Tumble()))
    np.testing.assert_array_equal(first, end_state(Tumble(threads=2)))


def test_contexts_simulated_in_turn_give_the_same_bits_as_each_alone():
    """Any memory outside the context would leak from one into the other."""
    tumble = Tumble()
    alone = [end_state(tumble, spin=spin) for spin in (3.0, -2.0)]
    assert not np.array_equal(*alone)
    simulators = [tumble.simulator(spin) for spin in (3.0, -2.0)]
    for time in np.linspace(0, 0.4, 9):
        for simulator in simulators:
            simulator.AdvanceTo(time)
    # Stopping on the way changes the steps, so both are stopped.
    again = []
    for spin in (3.0, -2.0):
        simulator = tumble.simulator(spin)
        for time in np.linspace(0, 0.4, 9):
            simulator.AdvanceTo(time)
        again.append(tumble.state(simulator))
    for simulator, expected in zip(simulators, again, strict=True):
        np.testing.assert_array_equal(tumble.state(simulator), expected)


def test_cloned_context_continues_like_the_original():
    tumble = Tumble()
    simulator = tumble.simulator()
    simulator.AdvanceTo(0.2)
    assert tumble.energies(simulator)[2] > 0
    clone = Simulator(tumble.diagram, simulator.get_context().Clone())
    original = Simulator(tumble.diagram, simulator.get_context().Clone())
    for each in (clone, original):
        each.AdvanceTo(0.4)
    np.testing.assert_array_equal(tumble.state(clone), tumble.state(original))
    np.testing.assert_array_equal(tumble.energies(clone), tumble.energies(original))


def test_reading_results_on_the_way_changes_nothing():
    tumble = Tumble()
    read = tumble.simulator()
    context = tumble.contact.GetMyContextFromRoot(read.get_context())

    def look(_: Context) -> None:
        for port in range(tumble.contact.num_output_ports()):
            tumble.contact.get_output_port(port).Eval(context)

    read.set_monitor(look)
    read.AdvanceTo(0.4)
    np.testing.assert_array_equal(tumble.state(read), end_state(tumble)[: len(tumble.state(read))])


def test_wrenches_of_both_routes_agree_to_round_off():
    wrenches = []
    for lists_only in (False, True):
        tumble = Tumble(lists_only=lists_only)
        assert tumble.contact.uses_lists == lists_only
        assert tumble.contact.uses_state != lists_only
        simulator = tumble.simulator()
        plant_context = tumble.plant.GetMyContextFromRoot(simulator.get_context())
        for body in tumble.capsules:  # all three overlap
            X_WB = tumble.plant.EvalBodyPoseInWorld(plant_context, body)
            tumble.plant.SetFreeBodyPose(
                plant_context, body, RigidTransform(X_WB.rotation(), 0.5 * X_WB.translation())
            )
        context = tumble.contact.GetMyContextFromRoot(simulator.get_context())
        wrenches.append(tumble.contact.get_body_wrenches_output_port().Eval(context).copy())
    assert (np.abs(wrenches[0].reshape(3, 6)).max(axis=1) > 1).all()
    np.testing.assert_allclose(wrenches[0], wrenches[1], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("time_step", [0.0, 1e-4])
def test_floating_bodies_move_the_same_through_state_and_through_lists(time_step):
    # Explicitly: what is wired by hand through the lists knows no other way.
    steps = {"time_step": time_step, "discrete": "explicit"}
    fast = end_state(Tumble(**steps), 0.2, accuracy=1e-7)
    slow = end_state(Tumble(**steps, lists_only=True), 0.2, accuracy=1e-7)
    np.testing.assert_allclose(fast, slow, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("scheme", GetIntegrationSchemes())
def test_every_integrator_runs(scheme):
    """Third order ones agree; the others run, as accurate as they are."""
    tumble = Tumble()
    simulator = tumble.simulator()
    ResetIntegratorFromFlags(simulator, scheme, 1e-3)
    simulator.AdvanceTo(0.15)
    lost = tumble.energies(simulator)[2]
    if scheme in ("bogacki_shampine3", "radau3", "runge_kutta3", "runge_kutta5"):
        assert lost == pytest.approx(0.4545, rel=0.01)
    else:
        assert lost > 0


def by_default(plant: MultibodyPlant, body: RigidBody) -> None:
    """Leave the body to the quaternion joint that the plant gives it."""


def by_angles(plant: MultibodyPlant, body: RigidBody) -> None:
    plant.AddJoint(RpyFloatingJoint("joint", plant.world_frame(), body.body_frame()))


def by_offset_frames(plant: MultibodyPlant, body: RigidBody) -> None:
    """Give it a quaternion joint whose coordinates are not the body's pose."""
    X = RigidTransform(RollPitchYaw(0.3, 0.2, 0.1), [0.3, -0.2, 0.1])
    parent = plant.AddFrame(FixedOffsetFrame("parent", plant.world_frame(), X))
    child = plant.AddFrame(FixedOffsetFrame("child", body.body_frame(), X))
    plant.AddJoint(QuaternionFloatingJoint("joint", parent, child))


def by_carrier(plant: MultibodyPlant, body: RigidBody) -> None:
    """Weld it to a free body without geometry."""
    carrier = plant.AddRigidBody("carrier", SpatialInertia.Zero())
    plant.WeldFrames(carrier.body_frame(), body.body_frame())


def drop(hold: Callable[[MultibodyPlant, RigidBody], None]) -> tuple[bool, np.ndarray]:
    """Drop a tilted capsule; return whether it went through the lists, and the pose it ends in."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
    capsule = plant.AddRigidBody(
        "capsule", SpatialInertia.SolidCapsuleWithMass(0.5, 0.04, 0.1, [0, 0, 1])
    )
    hold(plant, capsule)
    for body, shape, X_BG in (
        (capsule, Capsule(0.04, 0.1), RigidTransform(RollPitchYaw(0, 0.4, 0), [0, 0, 0])),
        (plant.world_body(), Box(1, 1, 1), RigidTransform([0.02, 0.03, -0.65])),
    ):
        plant.RegisterCollisionGeometry(body, X_BG, shape, "shape", CoulombFriction(0, 0))
    plant.Finalize()
    config = ContactConfig(tessellation_tolerance=0.1, **CONFIG)
    contact = AddNonlinearDamperContact(builder, plant, scene_graph, config=config)
    simulator = Simulator(builder.Build())
    integrator = simulator.get_mutable_integrator()
    integrator.set_target_accuracy(1e-7)
    integrator.set_maximum_step_size(1e-3)
    simulator.AdvanceTo(0.3)
    plant_context = plant.GetMyContextFromRoot(simulator.get_context())
    return contact.uses_lists, plant.EvalBodyPoseInWorld(plant_context, capsule).GetAsMatrix4()


def test_motion_does_not_depend_on_the_joint_that_leaves_a_body_free():
    through_lists, expected = drop(by_default)
    assert not through_lists
    assert np.abs(expected[:3, :3] - np.eye(3)).max() > 0.1, "it should have tipped"
    for hold in (by_angles, by_offset_frames, by_carrier):
        through_lists, X_WB = drop(hold)
        assert through_lists
        np.testing.assert_allclose(X_WB, expected, atol=1e-5)


def test_body_on_a_joint_swings_about_it():
    """A pendulum strikes a wall: only the torque about its hinge counts, and it bounces back."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
    length, mass = 0.5, 1.0
    point = UnitInertia.PointMass([0, 0, -length])
    bob = plant.AddRigidBody("bob", SpatialInertia(mass, [0, 0, -length], point))
    hinge = plant.AddJoint(RevoluteJoint("hinge", plant.world_frame(), bob.body_frame(), [0, 1, 0]))
    slippery = CoulombFriction(0, 0)
    plant.RegisterCollisionGeometry(
        bob, RigidTransform([0, 0, -length]), Box(0.1, 0.1, 0.1), "bob", slippery
    )
    # Touched when the string is upright, by the bob's flat face.
    plant.RegisterCollisionGeometry(
        plant.world_body(), RigidTransform([-0.57, 0, -length]), Box(1, 1, 1), "wall", slippery
    )
    plant.mutable_gravity_field().set_gravity_vector([0, 0, 0])
    plant.Finalize()
    config = ContactConfig(web="facet", standoff=0.02, k=1e5, alpha=0.3, pairs=[["bob", "world"]])
    AddNonlinearDamperContact(builder, plant, scene_graph, config=config)
    simulator = Simulator(builder.Build())
    simulator.get_mutable_integrator().set_target_accuracy(1e-8)
    simulator.get_mutable_integrator().set_maximum_step_size(1e-3)
    plant_context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    hinge.set_angle(plant_context, -0.1)
    hinge.set_angular_rate(plant_context, 1.0)
    simulator.AdvanceTo(0.3)
    e = NonlinearDamper(1.0, alpha=0.3).restitution(length * 1.0)
    assert hinge.get_angular_rate(plant_context) == pytest.approx(-e, rel=0.02)


def slide(slope: float, duration: float, time_step: float) -> tuple[float, float]:
    """Stand a block of 1 kg on a half space under slanting gravity, μ = 0.5, area web.

    Return how far it moved downhill, and how much of that in the second half.
    """
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step)
    block = plant.AddRigidBody("block", SpatialInertia.SolidBoxWithMass(1.0, 0.1, 0.1, 0.02))
    rough = CoulombFriction(0.5, 0.5)
    plant.RegisterCollisionGeometry(block, RigidTransform(), Box(0.1, 0.1, 0.02), "block", rough)
    plant.RegisterCollisionGeometry(
        plant.world_body(), RigidTransform(), HalfSpace(), "ground", rough
    )
    gravity = 9.81 / math.hypot(1, slope) * np.array([slope, 0, -1])
    plant.mutable_gravity_field().set_gravity_vector(gravity)
    plant.Finalize()
    k, area = 1e7, 0.01
    config = ContactConfig(k=k, alpha=20.0, resolution=0.1)
    AddNonlinearDamperContact(builder, plant, scene_graph, config=config)
    simulator = Simulator(builder.Build())
    plant_context = plant.GetMyContextFromRoot(simulator.get_context())
    rest = 0.01 + gravity[2] / (k * area)
    plant.SetPositions(plant_context, [1, 0, 0, 0, 0, 0, rest])
    moved = []
    for time in (duration / 2, duration):
        simulator.AdvanceTo(time)
        moved.append(plant.GetPositions(plant_context)[4])
    return moved[1], moved[1] - moved[0]


@pytest.mark.parametrize("time_step", [0.0, 5e-4])
def test_block_sticks_on_a_slope_below_friction_and_slides_above(time_step):
    """The anchors live in the contact state: were it lost or late, the block would creep."""
    slope = 0.4 * 0.5  # it is let go, and must not slip where it swings through
    moved, drift = slide(slope, 0.6, time_step)
    stretch = 9.81 * slope / math.hypot(1, slope) / (2 / 3 * 1e7 * 0.01)
    assert moved == pytest.approx(stretch, rel=0.1)  # the block tilts a little, too
    assert abs(drift) < 1e-9
    moved, later = slide(1.5 * 0.5, 0.3, time_step)
    acceleration = (later - (moved - later)) / 0.15**2
    assert acceleration == pytest.approx(9.81 / math.hypot(1, 0.75) * (0.75 - 0.5), rel=5e-3)


def leap(max_step: float) -> float:
    """Drop an egg onto a table 0.1 m thick with Drake's default integrator; return its height."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
    egg = plant.AddRigidBody("egg", SpatialInertia.SolidEllipsoidWithMass(0.06, 0.02, 0.02, 0.03))
    rough = CoulombFriction(0.5, 0.4)
    plant.RegisterCollisionGeometry(
        egg, RigidTransform(), Ellipsoid(0.02, 0.02, 0.03), "egg", rough
    )
    plant.RegisterCollisionGeometry(
        plant.world_body(), RigidTransform([0, 0, -0.05]), Box(1, 1, 0.1), "table", rough
    )
    plant.Finalize()
    config = ContactConfig(k=1e8, alpha=1.0, max_step=max_step, when_deep="raise")
    AddNonlinearDamperContact(builder, plant, scene_graph, config=config)
    simulator = Simulator(builder.Build())
    plant_context = plant.GetMyContextFromRoot(simulator.get_context())
    tilted = RigidTransform(RollPitchYaw(0.5, 0, 0), [0, 0, 0.1])
    plant.SetFreeBodyPose(plant_context, egg, tilted)
    simulator.AdvanceTo(0.18)
    return float(plant.GetPositions(plant_context)[6])


def test_free_fall_never_leaps_over_a_body():
    """Unlimited, the integrator passes the table's top in one step, without a single force seen."""
    assert leap(ContactConfig().max_step) > 0.015
    with pytest.raises(RuntimeError, match=r"egg.* in deeper than half the other's thickness"):
        leap(0.0)
