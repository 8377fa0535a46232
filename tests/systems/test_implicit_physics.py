"""What implicit steps must keep of the physics: closed forms on a discrete plant, defaults only.

Nothing is set by hand but what a user's model says: friction, and hydroelastic tags as Drake has
them.
"""

import numpy as np
import pytest
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    Box,
    ProximityProperties,
    Sphere,
)
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder, EventStatus

from contact_toolkit import NonlinearDamper
from systems import AddNonlinearDamperContact, ContactConfig

MU = 0.5
GRAVITY = 9.81


def tags(friction: float = MU, dissipation: float = 2.0) -> ProximityProperties:
    properties = ProximityProperties()
    AddContactMaterial(
        dissipation=dissipation,
        point_stiffness=1e5,
        friction=CoulombFriction(friction, friction),
        properties=properties,
    )
    AddCompliantHydroelasticProperties(0.05, 1e6, properties)
    return properties


class Ramp:
    """A box of 1 kg put on a slope by Drake's tags, a tenth of a millimetre above it."""

    def __init__(self, slope: float, step: float) -> None:
        builder = DiagramBuilder()
        self.plant, scene_graph = AddMultibodyPlantSceneGraph(builder, step)
        self.X_WR = RigidTransform(RollPitchYaw(0, np.arctan(slope), 0), [0, 0, 0])
        self.plant.RegisterCollisionGeometry(
            self.plant.world_body(),
            self.X_WR @ RigidTransform([0, 0, -0.1]),
            Box(4, 2, 0.2),
            "ramp",
            tags(),
        )
        inertia = SpatialInertia.SolidBoxWithMass(1.0, 0.2, 0.2, 0.1)
        self.body = self.plant.AddRigidBody("box", inertia)
        self.plant.RegisterCollisionGeometry(
            self.body, RigidTransform(), Box(0.2, 0.2, 0.1), "box", tags()
        )
        self.plant.Finalize()
        self.contact = AddNonlinearDamperContact(builder, self.plant, scene_graph)
        self.diagram = builder.Build()
        self.simulator = Simulator(self.diagram)
        context = self.plant.GetMyMutableContextFromRoot(self.simulator.get_context())
        self.plant.SetFreeBodyPose(
            context, self.body, self.X_WR @ RigidTransform([-1, 0, 0.05 + 1e-4])
        )
        self.simulator.Initialize()

    def at(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Return where the box is, along the ramp's axes, and its velocity there."""
        self.simulator.AdvanceTo(time)
        context = self.plant.GetMyContextFromRoot(self.simulator.get_context())
        X_RB = self.X_WR.inverse() @ self.plant.EvalBodyPoseInWorld(context, self.body)
        V_WB = self.plant.EvalBodySpatialVelocityInWorld(context, self.body)
        return X_RB.translation(), self.X_WR.rotation().inverse() @ V_WB.translational()


@pytest.mark.parametrize("step", [1e-3, 2e-3, 5e-3, 1e-2])
def test_a_box_sticks_at_0_99_of_the_friction_angle(step):
    """Creep: Drake's own contact slides here by half a millimetre a second."""
    ramp = Ramp(0.99 * MU, step)
    settled, _ = ramp.at(1.0)
    later, velocity = ramp.at(3.0)
    assert np.abs(later - settled).max() < 1e-9
    assert np.abs(velocity).max() < 1e-9


def test_a_box_at_rest_is_left_in_peace():
    """What a search leaves over would keep it trembling, and every step searching for ever."""
    ramp = Ramp(0.99 * MU, 1e-3)
    evaluations, fastest = [], 0.0
    for i in range(1000, 1500):
        _, velocity = ramp.at(1e-3 * i)
        context = ramp.contact.GetMyContextFromRoot(ramp.simulator.get_context())
        evaluations.append(ramp.contact.get_step_statistics_output_port().Eval(context)[1])
        fastest = max(fastest, np.abs(velocity).max())
    assert np.mean(evaluations) < 1.8
    assert fastest < 1e-10


@pytest.mark.slow
def test_a_box_does_not_creep_in_a_minute():
    """A drift too slow to be seen in seconds."""
    ramp = Ramp(0.99 * MU, 1e-3)
    settled, _ = ramp.at(1.0)
    later, _ = ramp.at(61.0)
    assert np.abs(later - settled).max() < 1e-9


@pytest.mark.parametrize("step", [1e-3, 2e-3, 5e-3, 1e-2])
def test_a_box_slides_at_1_02_of_the_friction_angle_as_coulomb_says(step):
    """Friction off by half a percent of what drives the box."""
    slope = 1.02 * MU
    ramp = Ramp(slope, step)
    _, early = ramp.at(1.0)
    _, late = ramp.at(2.0)
    angle = np.arctan(slope)
    expected = GRAVITY * (np.sin(angle) - MU * np.cos(angle))
    assert late[0] - early[0] == pytest.approx(expected, rel=5e-3)


def bounce(step: float, speed: float = 1.0, alpha: float = 0.5) -> float:
    """Return the rebound speed over the impact speed of a ball on a slab, without gravity."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, step)
    ball = plant.AddRigidBody("ball", SpatialInertia.SolidSphereWithMass(1.0, 0.05))
    plant.RegisterCollisionGeometry(
        ball, RigidTransform(), Sphere(0.05), "ball", CoulombFriction(0, 0)
    )
    plant.RegisterCollisionGeometry(
        plant.world_body(),
        RigidTransform([0, 0, -0.1]),
        Box(1, 1, 0.2),
        "slab",
        CoulombFriction(0, 0),
    )
    plant.mutable_gravity_field().set_gravity_vector([0, 0, 0])
    plant.Finalize()
    AddNonlinearDamperContact(builder, plant, scene_graph, config=ContactConfig(k=1e8, alpha=alpha))
    simulator = Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_context())
    plant.SetPositions(context, [1, 0, 0, 0, 0, 0, 0.051])
    plant.SetVelocities(context, [0, 0, 0, 0, 0, -speed])
    simulator.AdvanceTo(0.1)
    return float(plant.GetVelocities(context)[5] / speed)


def test_restitution_converges_to_its_closed_form_at_first_order():
    """Backward Euler loses energy in proportion to the step; anything else would be a fault."""
    exact = NonlinearDamper(k=1.0, alpha=0.5).restitution(1.0)
    off = [exact - bounce(step) for step in (4e-4, 2e-4, 1e-4)]
    assert all(each > 0 for each in off)
    assert off[0] / off[1] == pytest.approx(2, rel=0.25)
    assert off[1] / off[2] == pytest.approx(2, rel=0.25)
    assert off[2] < 0.03 * exact


def boxes(
    count: int,
    step: float,
    masses: list[float],
    *,
    narrower: float = 0.0,
    aside: float = 1.0,
    resolution: float | None = None,
) -> tuple[Simulator, MultibodyPlant]:
    """Stack boxes of 0.1 m, each `narrower` [m] than the one below, a little turned and aside."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, step)
    plant.RegisterCollisionGeometry(
        plant.world_body(), RigidTransform([0, 0, -0.1]), Box(2, 2, 0.2), "table", tags()
    )
    rng = np.random.default_rng(1)
    for i in range(count):
        size = [0.1 - narrower * i, 0.1 - narrower * i, 0.1]
        inertia = SpatialInertia.SolidBoxWithMass(masses[i], *size)
        body = plant.AddRigidBody(f"box{i}", inertia)
        plant.RegisterCollisionGeometry(body, RigidTransform(), Box(*size), f"box{i}", tags())
        turn = RollPitchYaw(0, 0, aside * 0.1 * rng.normal())
        place = [*(aside * 0.003 * rng.normal(size=2)), 0.05 + 0.1 * i + 1e-5 * (i + 1)]
        plant.SetDefaultFloatingBaseBodyPose(body, RigidTransform(turn, place))
    plant.Finalize()
    config = ContactConfig(resolution=resolution)
    AddNonlinearDamperContact(builder, plant, scene_graph, config=config)
    simulator = Simulator(builder.Build())
    return simulator, plant


def test_equal_boxes_stand_as_statics_says_at_every_resolution():
    """Faces that end where others do: heights that depend on nodes, or on the edges' field."""
    for resolution in (0.02, 0.2):
        simulator, plant = boxes(5, 1e-3, [1.0] * 5, resolution=resolution, aside=0.0)
        simulator.AdvanceTo(1.0)
        contact = simulator.get_system().GetSubsystemByName("contact")
        (k,) = {pair.damper.k for pair in contact.model.pairs}
        context = plant.GetMyContextFromRoot(simulator.get_context())
        heights = plant.GetPositions(context).reshape(5, 7)[:, 6]
        sunk = 0.05 + 0.1 * np.arange(5) - heights
        loads = np.cumsum([5, 4, 3, 2, 1]) * GRAVITY
        np.testing.assert_allclose(sunk, loads / (k * 0.01), rtol=1e-3)


@pytest.mark.slow
def test_ten_boxes_stand_for_a_minute():
    """A stack, each box a little turned and aside, that sways on, creeps or falls."""
    simulator, plant = boxes(10, 5e-3, [1.0] * 10)
    context = plant.GetMyContextFromRoot(simulator.get_context())
    simulator.AdvanceTo(50.0)
    before = plant.GetPositions(context)
    assert np.abs(plant.GetVelocities(context)).max() < 1e-9
    simulator.AdvanceTo(60.0)
    np.testing.assert_allclose(plant.GetPositions(context), before, rtol=0, atol=1e-9)


def test_a_box_bears_a_thousand_times_its_mass():
    """A light body between two that decide: its own inertia is nothing to the solver.

    It sways on, for the law damps little at low speed; the mean height is what statics says.
    """
    simulator, plant = boxes(2, 2e-3, [0.01, 10.0], narrower=0.02)
    contact = simulator.get_system().GetSubsystemByName("contact")
    deflection = 0.0
    for pair in contact.model.pairs:
        names = " ".join(contact.model.geometries[i].name for i in (pair.a, pair.b))
        load, side = (10.01, 0.1) if "table" in names else (10.0, 0.08)
        if "box1" in names and "table" in names:
            continue
        deflection += load * GRAVITY / (pair.damper.k * side**2)
    context = plant.GetMyContextFromRoot(simulator.get_context())
    simulator.AdvanceTo(1.0)
    heights = []
    for i in range(500):
        simulator.AdvanceTo(1.0 + 2e-3 * i)
        heights.append(plant.GetPositions(context)[13])
    assert np.abs(plant.GetVelocities(context)).max() < 1e-2
    assert 0.15 - np.mean(heights) == pytest.approx(deflection, rel=0.02)


@pytest.mark.parametrize(("step", "accuracy"), [(1e-3, 3e-3), (2e-4, 6e-4)])
def test_the_energy_ledger_closes_over_hard_impacts(step, accuracy):
    """Energy from nowhere, or a loss that no row of the ledger names.

    A box thrown down turning: corners, edges and faces hit it one after the other, all within a few
    steps. What is left is gravity's: semi-implicit Euler falls at the end's velocity.
    """
    simulator, plant = boxes(1, step, [1.0])
    root = simulator.get_context()
    context = plant.GetMyMutableContextFromRoot(root)
    q = RollPitchYaw(0.3, 0.2, 0.1).ToQuaternion().wxyz()
    plant.SetPositions(context, [*q, 0, 0, 0.2])
    plant.SetVelocities(context, [3, 2, 1, 2, 0, -1])
    contact = simulator.get_system().GetSubsystemByName("contact")
    rows = []

    def look(_: Context) -> EventStatus:
        ledger = contact.get_energies_output_port().Eval(contact.GetMyContextFromRoot(root))
        mechanical = plant.CalcKineticEnergy(context) + plant.CalcPotentialEnergy(context)
        rows.append([mechanical, *ledger])
        return EventStatus.DidNothing()

    simulator.set_monitor(look)
    simulator.AdvanceTo(0.6)
    rows = np.array(rows)
    lost = rows[0, 0] - rows[-1, 0]
    assert lost > 0.8 * (rows[0, 0] - 0.05 * GRAVITY)
    assert (rows[-1, 3:] > 0.05 * lost).all()  # damping, friction and the steps: each takes part
    assert np.abs(rows.sum(axis=1) - rows[0].sum()).max() < accuracy * lost


def test_contexts_of_one_diagram_do_not_disturb_each_other():
    """State kept in the object, or scratch memory that leaks from one run into another."""
    ramp = Ramp(0.9 * MU, 1e-3)
    alone = [np.concatenate(ramp.at(t)).tobytes() for t in (0.02, 0.04, 0.06)]
    fresh = Ramp(0.9 * MU, 1e-3)
    other = Simulator(fresh.diagram)
    other_context = fresh.plant.GetMyMutableContextFromRoot(other.get_context())
    fresh.plant.SetFreeBodyPose(
        other_context, fresh.body, fresh.X_WR @ RigidTransform([0.3, 0.1, 0.0499])
    )
    other.Initialize()
    fresh.simulator.Initialize()
    turns = []
    for t in (0.02, 0.04, 0.06):
        other.AdvanceTo(t)
        turns.append(np.concatenate(fresh.at(t)).tobytes())
    assert turns == alone


def test_a_cloned_diagram_goes_on_with_the_same_bits():
    """Anchors or the last step lost in a copied context."""
    ramp = Ramp(0.9 * MU, 1e-3)
    ramp.at(0.05)
    clone = Simulator(ramp.diagram, ramp.simulator.get_context().Clone())
    clone.Initialize()
    expected = np.concatenate(ramp.at(0.08))
    clone.AdvanceTo(0.08)
    context = ramp.plant.GetMyContextFromRoot(clone.get_context())
    X_RB = ramp.X_WR.inverse() @ ramp.plant.EvalBodyPoseInWorld(context, ramp.body)
    V_WB = ramp.plant.EvalBodySpatialVelocityInWorld(context, ramp.body)
    found = [X_RB.translation(), ramp.X_WR.rotation().inverse() @ V_WB.translational()]
    assert np.concatenate(found).tobytes() == expected.tobytes()
