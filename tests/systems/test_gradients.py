"""Derivatives of plants under contact against central differences of them, and closed forms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pydrake.autodiffutils import AutoDiffXd, ExtractGradient, ExtractValue, InitializeAutoDiff
from pydrake.geometry import Box, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import FixedOffsetFrame, PrismaticJoint, RevoluteJoint, SpatialInertia
from pydrake.planning import DirectCollocation, DirectTranscription
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder
from pydrake.systems.primitives import FirstOrderTaylorApproximation, Linearize
from scipy.optimize import brentq

from contact_toolkit import ContactState
from systems import AddNonlinearDamperContact, ContactConfig, FrictionConfig

STEP = 1e-7  # [m], [rad], [m/s]: small beside the deformations, far above rounding
ROUGH = CoulombFriction(0.8, 0.8)


class Scene:
    """A ball and a box on a table, and an arm on a hinge that leans on the box."""

    def __init__(self, time_step: float = 0.0, **settings: object) -> None:
        builder = DiagramBuilder()
        self.plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step)
        plant = self.plant
        add(plant, plant.world_body(), Box(2, 2, 0.1), [0, 0, -0.05])
        ball = plant.AddRigidBody("ball", SpatialInertia.SolidSphereWithMass(0.5, 0.05))
        add(plant, ball, Sphere(0.05))
        plant.SetDefaultFloatingBaseBodyPose(ball, RigidTransform([0.3, 0.1, 0.0495]))
        box = plant.AddRigidBody("box", SpatialInertia.SolidBoxWithMass(1, 0.1, 0.1, 0.1))
        add(plant, box, Box(0.1, 0.1, 0.1))
        plant.SetDefaultFloatingBaseBodyPose(box, RigidTransform([0, 0, 0.0499]))
        arm = plant.AddRigidBody(
            "arm", SpatialInertia.SolidSphereWithMass(0.3, 0.03).Shift([-0.2, 0.0, 0.0])
        )
        add(plant, arm, Sphere(0.03), [0.2, 0.01, 0])
        pivot = RigidTransform([-0.2, 0, 0.1297])
        frame = plant.AddFrame(FixedOffsetFrame("pivot", plant.world_frame(), pivot))
        hinge = plant.AddJoint(RevoluteJoint("hinge", frame, arm.body_frame(), [0, 1, 0]))
        plant.AddJointActuator("motor", hinge)
        plant.Finalize()
        self.contact = AddNonlinearDamperContact(
            builder, plant, scene_graph, config=ContactConfig(k=1e8, alpha=0.3, **settings)
        )
        builder.ExportInput(plant.get_actuation_input_port(), "torque")
        self.diagram = builder.Build()
        self.context = self.diagram.CreateDefaultContext()
        self.diagram.get_input_port().FixValue(self.context, [0.5])

    @property
    def plant_context(self) -> Context:
        return self.plant.GetMyMutableContextFromRoot(self.context)


def add(plant: MultibodyPlant, body, shape, p=(0.0, 0.0, 0.0)) -> None:
    plant.RegisterCollisionGeometry(body, RigidTransform(p), shape, body.name(), ROUGH)


def moving(plant: MultibodyPlant) -> np.ndarray:
    """Everything turns and slides a little, and quaternions have no unit length."""
    x = plant.GetPositionsAndVelocities(plant.CreateDefaultContext())
    x[plant.num_positions() :] += (
        np.random.default_rng(3).normal(size=plant.num_velocities()) * 0.02
    )
    for name in ("ball", "box"):
        start = plant.GetBodyByName(name).floating_positions_start()
        x[start : start + 4] = np.array([1.0, 1e-4, -2e-4, 0.3]) * 1.1
    return x


def after_a_step(scene: Scene, x: np.ndarray) -> ContactState:
    """What a step leaves that ended a little before x: anchors, some of them dragged."""
    plant, contact = scene.plant, scene.contact
    way = plant.MapVelocityToQDot(scene.plant_context, x[plant.num_positions() :])
    x = x.copy()
    x[: plant.num_positions()] -= 1e-4 * way
    plant.SetPositionsAndVelocities(scene.plant_context, x)
    own = contact.GetMyContextFromRoot(scene.context)
    X_WB = contact.get_poses_output_port().Eval(own)
    forces = contact.model.evaluate(X_WB, np.zeros((len(X_WB), 6)))
    assert len(np.unique(forces.contacts.pair)) == 3
    return contact.model.advance(contact.model.initial_state(), 0.0, forces)


@pytest.mark.parametrize("hold", [False, True], ids=["anchors move", "anchors held"])
def test_accelerations_carry_the_derivatives_of_contact(hold):
    # A frame, a carried body or a quaternion taken for another: gradients that lead nowhere.
    scene = Scene(hold_anchors=hold)
    plant, diagram, context = scene.plant, scene.diagram, scene.context
    x = moving(plant)

    def derivatives(x: np.ndarray) -> np.ndarray:
        plant.SetPositionsAndVelocities(scene.plant_context, x)
        return diagram.EvalTimeDerivatives(context).CopyToVector()

    scene.contact.SetContactState(context, after_a_step(scene, x))
    expected = derivatives(x)
    converted = diagram.ToAutoDiffXd()
    of_ad = converted.CreateDefaultContext()
    of_ad.SetTimeStateAndParametersFrom(context)
    converted.get_input_port().FixValue(of_ad, np.array([AutoDiffXd(0.5)]))
    of_ad.SetContinuousState(InitializeAutoDiff(x).ravel())
    found = converted.EvalTimeDerivatives(of_ad).CopyToVector().reshape(-1, 1)
    assert_allclose(ExtractValue(found).ravel(), expected, rtol=1e-9, atol=1e-9)
    gradient = ExtractGradient(found)
    for k, axis in enumerate(np.eye(len(x))):
        ahead, behind = derivatives(x + STEP * axis), derivatives(x - STEP * axis)
        differences = (ahead - behind) / (2 * STEP)
        assert_allclose(
            gradient[:, k], differences, rtol=0, atol=1e-5 * max(1, np.abs(differences).max())
        )


class Mass:
    """A mass on a vertical slider, on a table by spring and damper; a force lifts it."""

    MASS, SIDE, K, ALPHA, GRAVITY = 2.0, 0.1, 1e8, 20.0, 9.81

    def __init__(self, time_step: float = 0.0, **settings: object) -> None:
        builder = DiagramBuilder()
        self.plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step)
        plant, side = self.plant, self.SIDE
        add(plant, plant.world_body(), Box(1, 1, 0.1), [0, 0, -0.05])
        box = plant.AddRigidBody(
            "box", SpatialInertia.SolidBoxWithMass(self.MASS, side, side, side)
        )
        add(plant, box, Box(side, side, side), [0, 0, side / 2])
        slider = plant.AddJoint(
            PrismaticJoint("slider", plant.world_frame(), box.body_frame(), [0, 0, 1])
        )
        plant.AddJointActuator("lift", slider)
        plant.Finalize()
        config = ContactConfig(k=self.K, alpha=self.ALPHA, settling=0.0, **settings)
        self.contact = AddNonlinearDamperContact(builder, plant, scene_graph, config=config)
        builder.ExportInput(plant.get_actuation_input_port(), "lift")
        self.diagram = builder.Build()
        self.context = self.diagram.CreateDefaultContext()
        self.diagram.get_input_port().FixValue(self.context, [0.0])
        # Of all springs together [N/m], and where they carry the weight [m].
        self.stiffness = self.K * side**2
        self.depth = self.MASS * self.GRAVITY / self.stiffness
        self.damping = 1.5 * self.ALPHA * self.MASS * self.GRAVITY  # [N s/m] there
        # Springs at the rim add a ten-thousandth.
        at_rest = brentq(self.push, -1.01 * self.depth, -0.99 * self.depth, xtol=1e-18)
        self.push(at_rest)

    def push(self, q: float) -> float:
        """What is left of the weight where the mass is held at q [N]."""
        self.plant.SetPositions(self.plant_context, [q])
        own = self.contact.GetMyContextFromRoot(self.context)
        X_WB = self.contact.get_poses_output_port().Eval(own)
        wrenches = self.contact.model.evaluate(X_WB, np.zeros((2, 6))).body_wrenches
        return float(wrenches[1, 5] - self.MASS * self.GRAVITY)

    @property
    def plant_context(self) -> Context:
        return self.plant.GetMyMutableContextFromRoot(self.context)


def test_drake_linearizes_a_mass_on_spring_and_damper():
    mass = Mass(hold_anchors=True)
    linear = Linearize(mass.diagram, mass.context)
    expected = [[0, 1], [-mass.stiffness / mass.MASS, -mass.damping / mass.MASS]]
    assert_allclose(linear.A(), expected, rtol=1e-3, atol=1e-9)
    assert_allclose(linear.B(), [[0], [1 / mass.MASS]], rtol=1e-12)
    # ω = √(k A/m), ζ = a g/2 √(m/(k A))
    omega = np.sqrt(mass.stiffness / mass.MASS)
    zeta = 1.5 * mass.ALPHA * mass.GRAVITY / 2 / omega
    eigenvalues = np.sort_complex(np.linalg.eigvals(linear.A()))
    assert_allclose(
        eigenvalues, omega * (-zeta + np.sqrt(1 - zeta**2) * np.array([-1j, 1j])), rtol=1e-3
    )


def test_a_held_plant_is_linearized_at_the_anchors_of_a_simulated_one():
    # Without anchors what sticks would seem to slide: no stiffness along the table.
    moving = Scene(initial_overlap="warn")
    simulator = Simulator(moving.diagram, moving.context)
    simulator.AdvanceTo(0.2)
    simulator.AdvancePendingEvents()  # anchors take over the last step
    held = Scene(hold_anchors=True)
    held.contact.SetContactState(held.context, moving.contact.GetContactState(moving.context))
    x = moving.plant.GetPositionsAndVelocities(moving.plant_context)
    held.plant.SetPositionsAndVelocities(held.plant_context, x)
    at_moving, at_held = (
        each.diagram.EvalTimeDerivatives(each.context).CopyToVector() for each in (moving, held)
    )
    assert_allclose(at_held, at_moving, rtol=0, atol=1e-9)
    affine = FirstOrderTaylorApproximation(held.diagram, held.context)
    box = held.plant.GetBodyByName("box")
    row = held.plant.num_positions() + box.floating_velocities_start_in_v() + 3
    column = box.floating_positions_start() + 4

    def pulled_back(dx: float) -> float:
        held.plant.SetPositionsAndVelocities(held.plant_context, x + dx * np.eye(len(x))[column])
        return held.diagram.EvalTimeDerivatives(held.context).CopyToVector()[row]

    def stiffness(dx: float) -> float:
        return (pulled_back(-dx) - pulled_back(dx)) / (2 * dx)

    assert_allclose(-affine.A()[row, column], stiffness(1e-9), rtol=1e-4)
    # 2/3 of the normal stiffness k A, by Mindlin: over a micrometre, for nodes that bear next to
    # nothing, beside the face, hold as far as nanometres.
    assert_allclose(stiffness(1e-6), 2 / 3 * 1e8 * 0.1**2, rtol=0.05)


@pytest.mark.parametrize("make", ["collocation", "transcription"])
def test_trajectory_optimization_has_gradients_of_contact(make):
    # Drake asks the converted diagram at every knot; the constraints' gradients are its.
    mass = Mass(hold_anchors=True)
    if make == "collocation":
        program = DirectCollocation(
            mass.diagram,
            mass.context,
            num_time_samples=4,
            minimum_time_step=1e-3,
            maximum_time_step=1e-2,
        ).prog()
    else:
        program = DirectTranscription(
            mass.diagram, mass.context, 4, DirectTranscription.TimeStep(1e-3)
        ).prog()
    guess = np.random.default_rng(2).uniform(0.5, 1.5, program.num_vars())
    guess *= np.where([v.get_name().startswith("x") for v in program.decision_variables()], 1e-5, 1)
    checked = 0
    for binding in program.GetAllConstraints():
        variables = program.FindDecisionVariableIndices(binding.variables())
        at = guess[variables]
        gradient = ExtractGradient(
            binding.evaluator().Eval(InitializeAutoDiff(at).ravel()).reshape(-1, 1)
        )
        for k in range(len(at)):
            step = 1e-4 * np.abs(at[k]) * np.eye(len(at))[k]
            ahead, behind = (binding.evaluator().Eval(at + way * step) for way in (1, -1))
            differences = (ahead - behind) / (2 * step[k])
            assert_allclose(
                gradient[:, k], differences, rtol=1e-5, atol=1e-6 * np.abs(differences).max()
            )
            checked += 1
    assert checked > 10


def test_what_has_no_derivatives_says_so():
    with pytest.raises(RuntimeError, match=r"contact\.LinearizeStep"):
        Mass(time_step=1e-3).diagram.ToAutoDiffXd()
    with pytest.raises(ValueError, match="continuous plant only"):
        Mass(time_step=1e-3, hold_anchors=True)
    converted = Mass().diagram.ToAutoDiffXd()
    contact = converted.GetSubsystemByName("contact")
    context = contact.GetMyContextFromRoot(converted.CreateDefaultContext())
    with pytest.raises(RuntimeError, match="'contacts' of contact has no derivatives"):
        contact.GetOutputPort("contacts").Eval(context)
    wrenches = contact.GetOutputPort("body_wrenches").Eval(context)  # by no variable
    assert_allclose(ExtractValue(wrenches.reshape(-1, 1))[11], 0.0, atol=1e-9)


def simulated_step(scene: Scene, x: np.ndarray, u: float, state: ContactState) -> np.ndarray:
    """Where the plant's step leads, by Drake's simulator."""
    go_to(scene, x, u, state)
    Simulator(scene.diagram, scene.context).AdvanceTo(scene.plant.time_step())
    return scene.plant.GetPositionsAndVelocities(scene.plant_context)


def solved_step(scene: Scene, x: np.ndarray, u: float, state: ContactState) -> np.ndarray:
    """The same from these very anchors, where the simulator drags them along to x first."""
    go_to(scene, x, u, state)
    solver = scene.contact._source._implicit_step()
    v = solver.solve(0.0, x, {"actuation": np.array([u])}, state).velocities
    q_dot = scene.plant.MapVelocityToQDot(scene.plant_context, v)
    return np.concatenate([x[: len(q_dot)] + scene.plant.time_step() * q_dot, v])


def go_to(scene: Scene, x: np.ndarray, u: float, state: ContactState) -> None:
    scene.context.SetTime(0.0)
    scene.plant.SetPositionsAndVelocities(scene.plant_context, x)
    scene.diagram.get_input_port().FixValue(scene.context, [u])
    scene.contact.SetContactState(scene.context, state)


@pytest.mark.parametrize(("friction", "step"), [(0.0, simulated_step), (0.8, solved_step)])
def test_a_step_of_a_discrete_plant_is_linearized_as_it_is_solved(friction, step):
    # Forces of the end of a step are taken for those of its start, or what moves is left out.
    scene = Scene(time_step=1e-3, friction=FrictionConfig(static=friction))
    x, u = moving(scene.plant), 0.5
    state = after_a_step(scene, x)
    go_to(scene, x, u, state)
    found = scene.contact.LinearizeStep(scene.context)
    anchored = after_its_start(scene, x, u, state) if friction else state
    assert_allclose(found.x_next, step(scene, x, u, anchored), rtol=1e-9, atol=1e-12)
    for k, axis in enumerate(np.eye(len(x) + 1)):
        ahead, behind = (
            step(scene, x + way * axis[:-1], u + way * axis[-1], anchored) for way in (STEP, -STEP)
        )
        differences = (ahead - behind) / (2 * STEP)
        column = np.hstack([found.A, found.B])[:, k]
        scale = max(1e-3, np.abs(differences).max())
        assert_allclose(column, differences, rtol=0, atol=3e-5 * scale, err_msg=str(k))


def after_its_start(scene: Scene, x: np.ndarray, u: float, state: ContactState) -> ContactState:
    """What the present makes of a state before a step begins."""
    go_to(scene, x, u, state)
    return scene.contact.GetContactState(scene.context)


def test_a_mass_on_spring_and_damper_is_stepped_by_backward_euler():
    mass = Mass(time_step=1e-3)
    h, (m, k, c) = 1e-3, (mass.MASS, mass.stiffness, mass.damping)
    found = mass.contact.LinearizeStep(mass.context)
    expected = np.linalg.inv([[1, -h], [h * k / m, 1 + h * c / m]])
    assert_allclose(found.A, expected, rtol=1e-3)
    assert_allclose(found.B.ravel(), expected @ [0, h / m], rtol=1e-3)
    # Drake's own update moves positions by the velocities at the end: stable at any stiffness.
    assert np.abs(np.linalg.eigvals(found.A)).max() < 1
    continuous = Mass()
    with pytest.raises(ValueError, match="vector port of the plant"):
        mass.contact.LinearizeStep(mass.context, "geometry_query")
    with pytest.raises(RuntimeError, match="Drake's Linearize"):
        continuous.contact.LinearizeStep(continuous.context)
