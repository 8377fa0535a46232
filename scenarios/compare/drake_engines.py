"""A scenario under our contact and under Drake's own."""

from __future__ import annotations

import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from pydrake.common import RandomGenerator
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    ProximityProperties,
    Role,
    RoleAssign,
    SceneGraph,
)
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    CoulombFriction,
    MultibodyPlant,
    MultibodyPlantConfig,
)
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, VectorLogSink

from scenarios.compare.outcome import Outcome, record_of
from scenarios.format.scenario import Scenario
from scenarios.simulation.assembly import (
    add_bodies,
    assemble,
    drive_joints,
    set_initial_state,
)
from systems.plant.names import BodyNames

_STEP = 0.001  # [s] of a discrete plant where the scenario has a continuous one
_MODULUS = 1e7  # [Pa] of compliant hydroelastic bodies, Drake's default
_DISSIPATION = 1.0  # [s/m] of Drake's Hunt and Crossley model


def ours(scenario: Scenario, *, implicit: bool) -> Outcome:
    """Run it with our contact, in a discrete plant (implicit) or a continuous one."""
    step = (scenario.plant_config.time_step or _STEP) if implicit else 0.0
    changed = replace(scenario, plant_config=_plant_config(step))
    outcome = Outcome("ours, implicit" if implicit else "ours, continuous")
    with tempfile.TemporaryDirectory() as folder:
        assembly = assemble(changed, Path(folder))
        simulator = assembly.simulator(changed)
        _run(outcome, changed, simulator, assembly.plant, assembly.logs["state"])
    return outcome


def builtin(scenario: Scenario, *, hydroelastic: bool) -> Outcome:
    """Run it with Drake's own contact, in a discrete plant."""
    model = "hydroelastic_with_fallback" if hydroelastic else "point"
    config = _plant_config(scenario.plant_config.time_step or _STEP, model)
    outcome = Outcome("Drake hydroelastic" if hydroelastic else "Drake point")
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlant(config, builder)
    with tempfile.TemporaryDirectory() as folder:
        add_bodies(plant, scenario, Path(folder))
        plant.Finalize()
        _set_materials(plant, scene_graph, scenario, hydroelastic=hydroelastic)
        drive_joints(builder, plant, scenario)
        log = LogVectorOutput(
            plant.get_state_output_port(), builder, publish_period=scenario.record_period
        )
        simulator = Simulator(builder.Build())
    context = simulator.get_mutable_context()
    simulator.get_system().SetRandomContext(context, RandomGenerator(scenario.random_seed))
    set_initial_state(plant, plant.GetMyMutableContextFromRoot(context), scenario)
    _run(outcome, scenario, simulator, plant, log)
    return outcome


def friction_of(scenario: Scenario, body: str) -> float:
    """Return the coefficient for one body that gives its pairs theirs, as Drake combines them."""
    contact = scenario.contact
    base = contact.friction.static if contact.friction.static is not None else 0.5
    for override in contact.overrides:
        other = override.friction.static
        if body in override.bodies and other is not None and override.bodies[0] == body:
            # 2 μa μb / (μa + μb) = μ with μb that of all others
            return other * base / (2 * base - other) if base else other
    return base


def _plant_config(step: float, model: str = "point") -> MultibodyPlantConfig:
    return MultibodyPlantConfig(time_step=step, contact_model=model)


def _set_materials(
    plant: MultibodyPlant, scene_graph: SceneGraph, scenario: Scenario, *, hydroelastic: bool
) -> None:
    inspector, names = scene_graph.model_inspector(), BodyNames(plant)
    for index in range(plant.num_bodies()):
        frame = plant.GetBodyFrameIdIfExists(BodyIndex(index))
        for geometry in inspector.GetGeometries(frame, Role.kProximity) if frame else ():
            friction = friction_of(scenario, names.name_of(BodyIndex(index)))
            properties = ProximityProperties()
            if hydroelastic:
                AddCompliantHydroelasticProperties(
                    resolution_hint=0.01, hydroelastic_modulus=_MODULUS, properties=properties
                )
            AddContactMaterial(
                dissipation=_DISSIPATION,
                friction=CoulombFriction(friction, friction),
                properties=properties,
            )
            scene_graph.AssignRole(plant.get_source_id(), geometry, properties, RoleAssign.kReplace)


def _run(
    outcome: Outcome,
    scenario: Scenario,
    simulator: Simulator,
    plant: MultibodyPlant,
    log: VectorLogSink,
) -> None:
    started = time.perf_counter()
    simulator.AdvanceTo(scenario.simulation_duration)
    outcome.wall_time = time.perf_counter() - started
    found = log.FindLog(simulator.get_context())
    times, states = found.sample_times().copy(), found.data().T.copy()
    fixed = {body.index() for body in plant.GetBodiesWeldedTo(plant.world_body())}
    moving = [
        plant.get_body(BodyIndex(i)) for i in range(plant.num_bodies()) if BodyIndex(i) not in fixed
    ]
    names = BodyNames(plant)
    called = [names.name_of(body.index()) for body in moving]
    poses = {name: np.empty((len(times), 4, 4)) for name in called}
    velocities = {name: np.empty((len(times), 6)) for name in called}
    kinetic, context = np.empty(len(times)), plant.CreateDefaultContext()
    for row, state in enumerate(states):
        plant.SetPositionsAndVelocities(context, state)
        kinetic[row] = plant.EvalKineticEnergy(context)
        for name, body in zip(called, moving, strict=True):
            poses[name][row] = plant.EvalBodyPoseInWorld(context, body).GetAsMatrix4()
            velocity = plant.EvalBodySpatialVelocityInWorld(context, body)
            velocities[name][row] = velocity.get_coeffs()
    masses = {name: body.default_mass() for name, body in zip(called, moving, strict=True)}
    outcome.poses = poses
    outcome.record = record_of(times, poses, velocities, masses, kinetic, scenario.gravity)
    outcome.judge(scenario)
