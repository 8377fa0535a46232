"""Warnings and refusals: too long a step of a discrete plant, too deep a penetration."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from pydrake.common import MemoryFile
from pydrake.geometry import Box, InMemoryMesh, Mesh, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import BodyIndex, SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from scipy.spatial.transform import Rotation

from contact_toolkit import (
    CollisionMesh,
    ContactGeometry,
    ContactModel,
    ContactPair,
    ContactStatus,
    NonlinearDamper,
)
from contact_toolkit.shapes import primitives
from systems import (
    AddNonlinearDamperContact,
    ContactConfig,
    NonlinearDamperContact,
)
from systems.diagnostics.contact_frequency import ContactFrequency

MASS = 0.5
K = 1e4
SPRINGS = 3  # the facets at the tip
OMEGA = math.sqrt(SPRINGS * K / MASS)
STANDOFF = 0.02

TIP_DOWN = "v 0 0 0\nv .1 0 .1\nv -.05 .08 .1\nv -.05 -.08 .1\nf 1 3 2\nf 1 4 3\nf 1 2 4\nf 2 3 4\n"
TRIANGLE = "v 1 0 0\nv -1 1 0\nv -1 -1 0\nf 1 2 3\n"


BALANCE = STANDOFF - MASS * 9.81 / (SPRINGS * K)


def stand_on_tip(
    time_step: float, above: float = 1e-4, alpha: float = 0.0
) -> tuple[Simulator, Callable[[], float]]:
    """Let a tetrahedron go on its tip, `above` its balance: it swings up and down at OMEGA.

    Return also how to tell how far it is above then.
    """
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step)
    body = plant.AddRigidBody(
        "body", SpatialInertia(MASS, [0, 0, 0.07], UnitInertia(0.01, 0.01, 0.01))
    )
    for owner, text in ((body, TIP_DOWN), (plant.world_body(), TRIANGLE)):
        source = InMemoryMesh(mesh_file=MemoryFile(text, ".obj", owner.name()))
        plant.RegisterCollisionGeometry(
            owner, RigidTransform(), Mesh(source, 1.0), "mesh", CoulombFriction(0, 0)
        )
    plant.Finalize()
    config = ContactConfig(web="facet", standoff=STANDOFF, k=K, alpha=alpha, discrete="explicit")
    AddNonlinearDamperContact(builder, plant, scene_graph, config=config)
    simulator = Simulator(builder.Build())
    context = plant.GetMyContextFromRoot(simulator.get_context())
    plant.SetPositions(context, [1, 0, 0, 0, 0, 0, BALANCE + above])
    return simulator, lambda: plant.GetPositions(context)[6] - BALANCE


def test_short_steps_are_taken_in_silence():
    simulator, _ = stand_on_tip(0.19 * 2 / OMEGA)
    simulator.AdvanceTo(0.1)


def test_long_steps_are_warned_of_once_a_context_with_the_number():
    for _ in range(2):
        simulator, _ = stand_on_tip(0.5 * 2 / OMEGA)
        with pytest.warns(RuntimeWarning, match=r"is 0\.5 times .* ω = 245 rad/s") as told:
            simulator.AdvanceTo(0.1)
        assert len(told) == 1


def test_unstable_steps_are_refused_with_the_mend():
    simulator, _ = stand_on_tip(1.02 * 2 / OMEGA)
    with pytest.raises(RuntimeError, match=r"1 times the stable limit .* take 0\.002 s, softer"):
        simulator.AdvanceTo(0.1)


@pytest.mark.filterwarnings("ignore:the discrete plant's time step")
def test_steps_just_below_the_limit_are_stable():
    """Were the limit too lax, the swing would grow until the body jumps."""
    simulator, above = stand_on_tip(0.98 * 2 / OMEGA, above=1e-6)
    farthest = 0.0
    for time in np.linspace(0, 5, 100):
        simulator.AdvanceTo(time)
        farthest = max(farthest, abs(above()))
    assert farthest < 1e-5


def damped_limit(alpha: float) -> float:
    """Return the step [s] at which h² ω² + 2 h c/m = 4 about balance, where c = 3/2 α m g."""
    rate = 1.5 * alpha * 9.81
    return (-rate + math.sqrt(rate**2 + 4 * OMEGA**2)) / OMEGA**2


def test_damping_that_steps_are_too_long_for_is_refused():
    """A limit by the springs alone: half of it here, and the body would leave at once."""
    alpha = 50.0
    assert damped_limit(alpha) < 0.7 * 0.5 * 2 / OMEGA
    simulator, _ = stand_on_tip(0.5 * 2 / OMEGA, above=1e-6, alpha=alpha)
    with pytest.raises(RuntimeError, match="times the stable limit"):
        simulator.AdvanceTo(0.1)


@pytest.mark.filterwarnings("ignore:the discrete plant's time step")
def test_steps_just_below_the_damped_limit_are_stable():
    simulator, above = stand_on_tip(0.97 * damped_limit(50.0), above=1e-7, alpha=50.0)
    farthest = 0.0
    for time in np.linspace(0, 2, 40):
        simulator.AdvanceTo(time)
        farthest = max(farthest, abs(above()))
    assert farthest < 1e-6


@dataclass
class Springs:
    """The columns of ContactArrays that bear on frequency."""

    pair: np.ndarray
    p_FC: np.ndarray
    normal_F: np.ndarray
    stiffness: np.ndarray

    def __len__(self) -> int:
        return len(self.pair)


PAIRS = np.array([[0, 1], [0, 2], [3, 0], [1, 2], [3, 1], [2, 3]])


def random_case(seed: int, num_springs: int) -> tuple[MultibodyPlant, np.ndarray, Springs]:
    """Return three boxes of different weight, and springs between all of them and the ground."""
    random = np.random.default_rng(seed)
    plant = MultibodyPlant(0.001)
    for i, mass in enumerate([0.1, 1.0, 5.0]):
        plant.AddRigidBody(f"box{i}", SpatialInertia.SolidBoxWithMass(mass, 0.1, 0.2, 0.3))
    plant.Finalize()
    X_WB = np.tile(np.eye(4), (4, 1, 1))
    X_WB[1:, :3, 3] = random.normal(size=(3, 3))
    X_WB[1:, :3, :3] = Rotation.random(3, random_state=seed).as_matrix()
    normals = random.normal(size=(num_springs, 3))
    springs = Springs(
        pair=random.integers(0, len(PAIRS), num_springs),
        p_FC=random.normal(size=(num_springs, 3)),
        normal_F=normals / np.linalg.norm(normals, axis=1, keepdims=True),
        stiffness=random.uniform(1, 100, num_springs),
    )
    return plant, X_WB, springs


def bound_of(plant: MultibodyPlant, X_WB: np.ndarray, springs: Springs) -> float:
    bodies = [BodyIndex(i) for i in range(4)]
    return ContactFrequency(plant, bodies, PAIRS).bound(X_WB, springs)


def true_frequency(plant: MultibodyPlant, X_WB: np.ndarray, springs: Springs) -> float:
    """Return the highest frequency of the coupled system, from its whole mass matrix."""
    mass, stiffness = np.zeros((24, 24)), np.zeros((24, 24))
    for body in range(1, 4):
        block = slice(6 * body, 6 * body + 6)
        turn = np.kron(np.eye(2), X_WB[body, :3, :3])
        inertia = plant.get_body(BodyIndex(body)).default_spatial_inertia().CopyToFullMatrix6()
        mass[block, block] = turn @ inertia @ turn.T
    for pair, p_FC, normal, k in zip(
        springs.pair, springs.p_FC, springs.normal_F, springs.stiffness, strict=True
    ):
        row = np.zeros(24)
        for body, sign in zip(PAIRS[pair], (1, -1), strict=True):
            arm = p_FC - X_WB[body, :3, 3]
            row[6 * body : 6 * body + 6] = sign * np.concatenate([np.cross(arm, normal), normal])
        stiffness += k * np.outer(row, row)
    modes = np.linalg.eigvals(np.linalg.solve(mass[6:, 6:], stiffness[6:, 6:]))
    return math.sqrt(modes.real.max())


@pytest.mark.parametrize("num_springs", [1, 3, 30])
def test_frequency_is_bounded_and_not_by_much(num_springs):
    for seed in range(20):
        case = random_case(seed, num_springs)
        bound, true = bound_of(*case), true_frequency(*case)
        assert bound >= true * (1 - 1e-9)
        assert bound <= true * (1 + 1e-9 if num_springs == 1 else 1.6)


def test_a_bound_that_is_low_enough_is_found_cheaply():
    """No less than the close one, and that one where it counts."""
    for seed in range(20):
        plant, X_WB, springs = random_case(seed, 30)
        frequency = ContactFrequency(plant, [BodyIndex(i) for i in range(4)], PAIRS)
        close = frequency.bound(X_WB, springs)
        cheap = frequency.bound(X_WB, springs, enough=1e9)
        assert close <= cheap <= close * math.sqrt(6)
        assert frequency.bound(X_WB, springs, enough=close) == close


def test_without_contact_nothing_swings():
    assert bound_of(*random_case(0, 0)) == 0


FACET = {"web": "facet", "standoff": 0.02}
SHELL = {"web": "area", "standoff": 0.02}
OPEN_TIP = TIP_DOWN.replace("f 2 3 4\n", "")  # without its lid: of two open surfaces one is probed
TOUCH = {"web": "area"}
CROSSING = "surfaces cross: .* than the standoff"
PASSED_THROUGH = "passed through the other's open surface"
BEYOND = "deeper than half .* thickness"


def tip_in_ground(
    ground: str, height: float, contact: dict, when_deep: str = "warn", tip: str = TIP_DOWN
):
    """Hold a tip over a triangle or a block; return a simulator and the statuses."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
    plant.mutable_gravity_field().set_gravity_vector([0, 0, 0])
    body = plant.AddRigidBody("spike", SpatialInertia(1e6, [0, 0, 0.07], UnitInertia(1, 1, 1)))
    spike, triangle = (
        Mesh(InMemoryMesh(mesh_file=MemoryFile(text, ".obj", "mesh")), 1.0)
        for text in (tip, TRIANGLE)
    )
    below = triangle if ground == "triangle" else Box(1, 1, 0.2)
    top = [0, 0, 0 if ground == "triangle" else -0.1]
    for owner, shape, at in ((body, spike, [0, 0, 0]), (plant.world_body(), below, top)):
        plant.RegisterCollisionGeometry(
            owner, RigidTransform(at), shape, "shape", CoulombFriction(0, 0)
        )
    plant.Finalize()
    config = ContactConfig(k=K, alpha=0.0, when_deep=when_deep, **contact)
    system = AddNonlinearDamperContact(builder, plant, scene_graph, config=config)
    simulator = Simulator(builder.Build())
    context = simulator.get_context()
    plant.SetPositions(plant.GetMyContextFromRoot(context), [1, 0, 0, 0, 0, 0, height])
    contacts = system.get_contacts_output_port().Eval(system.GetMyContextFromRoot(context))
    return simulator, contacts.status


@pytest.mark.parametrize(
    ("tip", "ground", "height", "contact", "status", "meaning"),
    [
        (TIP_DOWN, "triangle", -1e-3, FACET, ContactStatus.CROSSED, CROSSING),
        (TIP_DOWN, "block", -1e-3, FACET, ContactStatus.CROSSED, CROSSING),
        (OPEN_TIP, "triangle", -1e-3, SHELL, ContactStatus.CROSSED, PASSED_THROUGH),
        (TIP_DOWN, "block", -0.105, TOUCH, ContactStatus.BEYOND_CAPTURE, BEYOND),
    ],
    ids=["facets", "facets of a block", "both open", "beyond a block's middle"],
)
def test_too_deep_is_told_once_with_the_names(tip, ground, height, contact, status, meaning):
    """A body pushed the wrong way, or not at all, without a word."""
    simulator, found = tip_in_ground(ground, height, contact, tip=tip)
    assert len(found) > 0
    assert (found == status).all()
    with pytest.warns(RuntimeWarning, match=meaning) as told:
        simulator.AdvanceTo(0.02)
    assert len(told) == 1
    assert "spike" in str(told[0].message)
    assert "world" in str(told[0].message)
    simulator, _ = tip_in_ground(ground, height, contact, "raise", tip)
    with pytest.raises(RuntimeError, match=meaning):
        simulator.AdvanceTo(0.02)


@pytest.mark.parametrize(
    ("ground", "height", "contact"),
    [
        ("triangle", 1e-3, FACET),
        ("triangle", 1e-3, SHELL),
        ("triangle", -1e-3, SHELL),  # the tip has an inside, by which its depth is known
        ("block", -0.05, TOUCH),
    ],
)
def test_what_is_not_too_deep_is_not_told(ground, height, contact):
    simulator, found = tip_in_ground(ground, height, contact, "raise")
    assert len(found) > 0
    assert (found == 0).all()
    simulator.AdvanceTo(0.02)


def body_at_rest(k, shape):
    """A simulator of a body of 1 kg at its resting depth on the ground, and its plant."""
    side, mass = 0.1, 1.0
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    body = plant.AddRigidBody("body", SpatialInertia.SolidBoxWithMass(mass, side, side, side))
    for owner, geometry, z in (
        (body, shape(side), 0.0),
        (plant.world_body(), Box(1, 1, 1), -0.5),
    ):
        rough = CoulombFriction(0.5, 0.5)
        plant.RegisterCollisionGeometry(owner, RigidTransform([0, 0, z]), geometry, "g", rough)
    plant.Finalize()
    config = ContactConfig(k=k, alpha=1.0, resolution=0.1)
    AddNonlinearDamperContact(builder, plant, scene_graph, config=config)
    simulator = Simulator(builder.Build())
    put(simulator, plant, side / 2 - mass * 9.81 / (k * side**2))
    return simulator, plant


def put(simulator, plant, height, *, v=0.0):
    context = plant.GetMyContextFromRoot(simulator.get_context())
    plant.SetPositions(context, [1, 0, 0, 0, 0, 0, height])
    plant.SetVelocities(context, [0, 0, 0, 0, 0, v])


def cube(side):
    return Box(side, side, side)


@pytest.mark.parametrize("k", [1e8, 1e10])
def test_rest_on_stiff_contact_is_silent(k):
    """Shaking at the size of the integrator's accuracy, taken for impacts."""
    simulator, _ = body_at_rest(k, cube)
    simulator.AdvanceTo(0.3)


@pytest.mark.parametrize("shape", [cube, lambda side: Sphere(side / 2)], ids=["box", "ball"])
def test_short_steps_under_a_torque_of_rounding_are_no_chatter(shape):
    """Steps far shorter than contact needs, and a torque that is noise, taken for leaps."""
    simulator, _ = body_at_rest(2.5e5, shape)
    integrator = simulator.get_mutable_integrator()
    integrator.set_maximum_step_size(1e-6)
    integrator.request_initial_step_size_target(1e-6)
    integrator.set_fixed_step_mode(True)
    simulator.AdvanceTo(4e-3)


def test_bodies_put_elsewhere_by_hand_are_no_impact():
    """A pose set between two advances, taken for what contact did in a step."""
    simulator, plant = body_at_rest(1e6, cube)
    put(simulator, plant, 0.049, v=-0.3)
    for height in (0.08, 0.0485, 0.049, 0.06):
        simulator.AdvanceTo(simulator.get_context().get_time() + 2e-3)
        put(simulator, plant, height, v=-0.3)
    simulator.AdvanceTo(simulator.get_context().get_time() + 0.1)


def test_a_system_made_by_hand_knows_its_bodies_by_name():
    """Geometries fixed to bodies by name, whose masses the watch does not find."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, time_step=0.01)
    body = plant.AddRigidBody("cube", SpatialInertia.SolidBoxWithMass(1.0, 0.1, 0.1, 0.1))
    plant.Finalize()
    cube = CollisionMesh(*primitives.box([0.1, 0.1, 0.1]))
    model = ContactModel(
        ["ground", "cube"],
        [ContactGeometry(name, name, cube) for name in ("ground", "cube")],
        [ContactPair(0, 1, NonlinearDamper(k=1e8))],
    )
    assert model.geometry_bodies == (0, 1)
    assert model.pair_names(0) == ("ground", "cube")
    bodies = [plant.world_body().index(), body.index()]
    contact = builder.AddSystem(NonlinearDamperContact(plant, model, bodies))
    builder.Connect(plant.get_state_output_port(), contact.get_state_input_port())
    builder.Connect(
        contact.get_generalized_forces_output_port(),
        plant.get_applied_generalized_force_input_port(),
    )
    simulator = Simulator(builder.Build())
    context = plant.GetMyContextFromRoot(simulator.get_context())
    plant.SetPositions(context, [1, 0, 0, 0, 0, 0, 0.0999])
    with pytest.raises(RuntimeError, match="times the stable limit"):
        simulator.AdvanceTo(0.1)
