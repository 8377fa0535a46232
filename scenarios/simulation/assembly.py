"""Build the diagram of a scenario: plant, contact, recording, playback."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Literal, cast
from urllib.parse import unquote, urlparse

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.common import RandomGenerator
from pydrake.geometry import Meshcat
from pydrake.multibody.parsing import (
    ModelDirective,
    ModelDirectives,
    Parser,
    ProcessModelDirectives,
)
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant
from pydrake.multibody.tree import Joint
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, VectorLogSink

from scenarios.format.errors import ScenarioError
from scenarios.format.models import PACKAGE, write_models
from scenarios.format.packages import package_folder
from scenarios.format.scenario import Scenario
from scenarios.simulation.columns import logs_behind
from scenarios.simulation.contact_counts import ContactCounts
from scenarios.simulation.drawings import add_drawings
from scenarios.simulation.drives import JointDrives
from scenarios.simulation.joints import add_joints
from systems import AddNonlinearDamperContact, NonlinearDamperContact, SweptContactMonitor
from systems.parse_model import readable_model

_MODELS = {".sdf", ".urdf", ".xml"}  # files that name meshes


@dataclass(frozen=True)
class Assembly:
    """A scenario's diagram and the parts of it that a run looks at."""

    diagram: Diagram
    plant: MultibodyPlant
    contact: NonlinearDamperContact
    logs: Mapping[str, VectorLogSink]
    columns: Collection[str] | None = None
    """Those that are to be recorded, None for all; see `scenarios.simulation.columns`."""

    def simulator(self, scenario: Scenario) -> Simulator:
        """Return a simulator at the scenario's initial state."""
        simulator = Simulator(self.diagram)
        try:
            ApplySimulatorConfig(scenario.simulator_config, simulator)
        except RuntimeError as error:
            raise ScenarioError(f"simulator_config: {error}") from error
        context = simulator.get_mutable_context()
        self.diagram.SetRandomContext(context, RandomGenerator(scenario.random_seed))
        plant_context = self.plant.GetMyMutableContextFromRoot(context)
        set_initial_state(self.plant, plant_context, scenario)
        return simulator


def set_initial_state(plant: MultibodyPlant, context: Context, scenario: Scenario) -> None:
    """Set the positions and velocities that a scenario gives over the models' defaults."""
    positions, velocities = plant.GetPositions(context), plant.GetVelocities(context)
    for model, joints in scenario.initial_position.items():
        for name, values in joints.items():
            where = f"initial_position.{model}.{name}"
            joint = _joint(plant, where, model, name)
            start, size = joint.position_start(), joint.num_positions()
            positions[start : start + size] = _finite(where, values, size, "positions")
    for model, joints in scenario.initial_velocity.items():
        for name, values in joints.items():
            where = f"initial_velocity.{model}.{name}"
            joint = _joint(plant, where, model, name)
            start, size = joint.velocity_start(), joint.num_velocities()
            velocities[start : start + size] = _finite(where, values, size, "velocities")
    plant.SetPositions(context, positions)
    plant.SetVelocities(context, velocities)


def _joint(plant: MultibodyPlant, where: str, model: str, joint: str) -> Joint:
    try:
        return plant.GetJointByName(joint, plant.GetModelInstanceByName(model))
    except RuntimeError as error:
        raise ScenarioError(f"{where}: {error}") from error


def _finite(where: str, values: ArrayLike, count: int, what: str) -> NDArray[np.float64]:
    given = np.atleast_1d(np.asarray(values, dtype=np.float64))
    if len(given) != count:
        raise ScenarioError(f"{where}: expected {count} {what}, not {len(given)}")
    if not np.isfinite(given).all():
        raise ScenarioError(f"{where}: must be finite numbers, not {given.tolist()}")
    return given


def assemble(
    scenario: Scenario,
    folder: Path,
    meshcat: Meshcat | None = None,
    *,
    live: bool = False,
    columns: Collection[str] | None = None,
) -> Assembly:
    """Build the diagram; generated models go to `folder`, drawings to `meshcat`.

    `live` is for watching, not for a recording; `columns` are those to record, None for all.

    Raises ScenarioError for models or contact settings that cannot be.
    """
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlant(scenario.plant_config, builder)
    try:
        add_bodies(plant, scenario, folder)
        plant.Finalize()
        drive_joints(builder, plant, scenario)
        contact = AddNonlinearDamperContact(builder, plant, scene_graph, config=scenario.contact)
    except ScenarioError:
        raise
    except (ValueError, RuntimeError) as error:  # Drake raises RuntimeError for all of its own
        raise ScenarioError(str(error)) from error
    if scenario.swept_monitor != "off":
        monitor = SweptContactMonitor.AddToBuilder(
            builder,
            contact,
            when_passed=cast(Literal["raise", "warn", "count"], scenario.swept_monitor),
        )
    needed = logs_behind(columns)
    ports = {
        "state": plant.get_state_output_port(),
        "wrenches": contact.get_body_wrenches_output_port(),
        "energies": contact.get_energies_output_port(),
    }
    if "counts" in needed:
        counts = builder.AddNamedSystem("contact_counts", ContactCounts())
        builder.Connect(contact.get_contacts_output_port(), counts.get_input_port())
        ports["counts"] = counts.get_output_port()
    if scenario.swept_monitor != "off":
        ports["passes"] = monitor.get_passes_output_port()
    logs = {
        name: LogVectorOutput(port, builder, publish_period=scenario.record_period)
        for name, port in ports.items()
        if name in needed
    }
    if meshcat is not None:
        add_drawings(builder, plant, scene_graph, contact, meshcat, scenario, live=live)
    return Assembly(builder.Build(), plant, contact, MappingProxyType(logs), columns)


def add_bodies(plant: MultibodyPlant, scenario: Scenario, folder: Path) -> None:
    """Add a scenario's models and joints to a plant; generated models go to `folder`."""
    write_models(scenario.parts, folder)
    parser = Parser(plant)
    parser.package_map().Add(PACKAGE, str(folder))
    for name, place in scenario.packages.items():
        parser.package_map().Add(name, str(package_folder(name, place)))
    directives = [_readable(directive, parser, folder) for directive in scenario.directives]
    ProcessModelDirectives(ModelDirectives(directives=directives), parser)
    for name in scenario.without_gravity:
        if not plant.HasModelInstanceNamed(name):
            raise ScenarioError(f"without_gravity: no model is called '{name}'")
        plant.set_gravity_enabled(plant.GetModelInstanceByName(name), is_enabled=False)
    plant.mutable_gravity_field().set_gravity_vector(scenario.gravity)
    add_joints(plant, scenario.joints, scenario.drives)


def _readable(directive: ModelDirective, parser: Parser, folder: Path) -> ModelDirective:
    """Return the directive with a model whose meshes Drake reads, in `folder` if it was not so."""
    url = urlparse(directive.add_model.file if directive.add_model is not None else "")
    if Path(url.path).suffix not in _MODELS or url.netloc == PACKAGE:
        return directive
    file = (
        unquote(url.path) if url.scheme == "file" else parser.package_map().ResolveUrl(url.geturl())
    )
    changed = deepcopy(directive)
    changed.add_model.file = readable_model(parser, Path(file), folder).resolve().as_uri()
    return changed


def drive_joints(builder: DiagramBuilder, plant: MultibodyPlant, scenario: Scenario) -> None:
    """Connect a scenario's drives to the plant, if it has any."""
    if not scenario.drives:
        return
    drives = builder.AddNamedSystem("drives", JointDrives(plant, scenario.drives))
    builder.Connect(plant.get_state_output_port(), drives.get_input_port())
    builder.Connect(drives.get_output_port(), plant.get_actuation_input_port())
