"""One model falling on a table: what became of it, held against the laws of motion."""

from __future__ import annotations

import time
import warnings
from dataclasses import asdict, dataclass, field

import numpy as np
from pydrake.geometry import Box, SceneGraph
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import BodyIndex, RigidBody
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder

from benchmarks.model_zoo.files import ModelFile, add_model
from systems import AddNonlinearDamperContact, NonlinearDamperContact

TIME_STEP = 2e-3  # [s]
DURATION = 1.0  # [s]
_DROP = 0.01  # [m] between the table and the lowest geometry at the start
AT_REST = 0.01  # [m/s] a point at the rim of what is slower creeps, if at all
_WINDOW = 0.5  # [s] at the end, over which momentum is balanced


@dataclass
class Fall:
    """What became of a model.

    Attributes
    ----------
    outcome
        "unloaded" (by Drake), "nothing to touch", "refused" (by us), "failed" while running, or
        "ran".
    reason
        The error, where there is one.
    warnings
        Said on the way, each once.
    falls
        Whether a part of it stands free, so that its weight must be borne.
    speed
        [m/s] of the fastest origin of a body at the end.
    imbalance
        What the contact forces' impulse lacks of weight times time plus the gain in momentum, over
        the last half second, as a share of the weight's.
    real_time_factor
        Simulated time over time of one core, without building.
    seconds_to_build
        Of adding contact and building the diagram [s].
    """

    outcome: str = "ran"
    reason: str = ""
    warnings: list[str] = field(default_factory=list)
    falls: bool = False
    speed: float = float("nan")
    imbalance: float = float("nan")
    real_time_factor: float = float("nan")
    seconds_to_build: float = float("nan")

    def as_dict(self) -> dict[str, object]:
        """Return it ready for JSON."""
        return asdict(self)


def fall(model: ModelFile, budget: float) -> Fall:
    """Let a model fall for a second, in a discrete plant, with nothing set by hand.

    `budget` [s] of a core: what takes more is a failure, with how far it led.
    """
    try:
        builder, plant, scene_graph = load(model)
    except Exception as error:  # noqa: BLE001  whatever a parser raises
        return Fall(outcome="unloaded", reason=_first_line(error))
    moving = moving_bodies(plant)
    if not moving:
        return Fall(outcome="nothing to touch")
    result = Fall()
    trees = {base: _tree_of(plant, base) for base in plant.GetFloatingBaseBodies()}
    on_trees = set().union(*trees.values())
    result.falls = any(body.index() in on_trees for body in moving)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("default")
        try:
            start = time.perf_counter()
            contact = AddNonlinearDamperContact(builder, plant, scene_graph)
            diagram = builder.Build()
            result.seconds_to_build = time.perf_counter() - start
        except Exception as error:  # noqa: BLE001  the table says which
            return Fall(outcome="refused", reason=_first_line(error), falls=result.falls)
        try:
            _run(_Scene(diagram, plant, contact, trees, moving), budget, result)
        except Exception as error:  # noqa: BLE001
            result.outcome, result.reason = "failed", _first_line(error)
    result.warnings = sorted({str(each.message) for each in said})
    return result


def load(model: ModelFile) -> tuple[DiagramBuilder, MultibodyPlant, SceneGraph]:
    """Return a discrete plant of the model and a table; raises what Drake's parser raises."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=TIME_STEP)
    add_model(plant, model)
    plant.RegisterCollisionGeometry(
        plant.world_body(),
        RigidTransform([0.0, 0.0, -0.5]),
        Box(20, 20, 1),
        "table",
        CoulombFriction(0.5, 0.5),
    )
    plant.Finalize()
    return builder, plant, scene_graph


def moving_bodies(plant: MultibodyPlant) -> list[RigidBody]:
    """Return the bodies with collision geometry that are not anchored."""
    return [
        body
        for body in _bodies(plant)
        if plant.GetCollisionGeometriesForBody(body) and not plant.IsAnchored(body)
    ]


@dataclass(frozen=True)
class _Scene:
    diagram: Diagram
    plant: MultibodyPlant
    contact: NonlinearDamperContact
    trees: dict[BodyIndex, set[BodyIndex]]  # floating base → all that hangs on it
    moving: list[RigidBody]


def _run(scene: _Scene, budget: float, result: Fall) -> None:
    plant, contact, trees, moving = scene.plant, scene.contact, scene.trees, scene.moving
    simulator = Simulator(scene.diagram)
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    _lift(plant, context, trees)
    simulator.Initialize()
    start = time.thread_time()
    steps = round(DURATION / TIME_STEP)
    window = round(_WINDOW / TIME_STEP)
    before = impulse = 0.0
    row_of = {index: row for row, index in enumerate(contact.bodies)}
    rows = [row_of[body.index()] for body in moving if body.index() in row_of]
    contact_context = contact.GetMyContextFromRoot(simulator.get_context())
    for step in range(1, steps + 1):
        if step == steps - window + 1:
            before = _momentum(plant, context)
        simulator.AdvanceTo(step * TIME_STEP)
        if step > steps - window:
            wrenches = contact.get_body_wrenches_output_port().Eval(contact_context)
            impulse += TIME_STEP * float(wrenches.reshape(-1, 6)[rows, 5].sum())
        spent = time.thread_time() - start
        result.real_time_factor = step * TIME_STEP / spent
        if spent > budget:
            raise TimeoutError(f"{spent:.0f} s of a core led to {step * TIME_STEP:.3g} s")
    if not np.isfinite(plant.GetPositionsAndVelocities(context)).all():
        raise FloatingPointError("the state is not finite")
    velocities = plant.get_body_spatial_velocities_output_port().Eval(context)
    result.speed = max(
        float(np.linalg.norm(velocities[int(body.index())].translational())) for body in moving
    )
    free = set().union(*trees.values())
    if all(body.index() in free or plant.IsAnchored(body) for body in _bodies(plant)):
        gravity = float(np.linalg.norm(plant.gravity_field().gravity_vector()))
        weight = plant.CalcTotalMass(context) * gravity
        gain = _momentum(plant, context) - before
        if weight > 0:
            result.imbalance = (impulse - gain) / (weight * _WINDOW) - 1


def _lift(plant: MultibodyPlant, context: Context, trees: dict[BodyIndex, set[BodyIndex]]) -> None:
    """Put the lowest geometry of each free tree just above the table."""
    query = plant.get_geometry_query_input_port().Eval(context)
    inspector = query.inspector()
    for base, tree in trees.items():
        lowest = np.inf
        for body in map(plant.get_body, tree):
            for geometry in plant.GetCollisionGeometriesForBody(body):
                box = inspector.GetObbInGeometryFrame(geometry)
                X_WO = query.GetPoseInWorld(geometry) @ box.pose()
                rise = np.abs(X_WO.rotation().matrix()[2]) @ box.half_width()
                lowest = min(lowest, X_WO.translation()[2] - rise)
        if np.isfinite(lowest):
            X_WB = plant.EvalBodyPoseInWorld(context, plant.get_body(base))
            up = RigidTransform([0.0, 0.0, _DROP - lowest])
            plant.SetFreeBodyPose(context, plant.get_body(base), up @ X_WB)


def _bodies(plant: MultibodyPlant) -> list[RigidBody]:
    return [plant.get_body(BodyIndex(i)) for i in range(plant.num_bodies())]


def _tree_of(plant: MultibodyPlant, base: BodyIndex) -> set[BodyIndex]:
    """Return a floating base and all that hangs on it."""
    joints = [
        index
        for index in plant.GetJointIndices()
        if plant.get_joint(index).child_body().index() == base
    ]
    return {base, *plant.GetBodiesKinematicallyAffectedBy(joints)}


def _momentum(plant: MultibodyPlant, context: Context) -> float:
    """Upward momentum of everything [N s]."""
    return float(
        plant.CalcSpatialMomentumInWorldAboutPoint(context, np.zeros(3)).translational()[2]
    )


def _first_line(error: Exception) -> str:
    return f"{type(error).__name__}: {str(error).splitlines()[0] if str(error) else ''}"
