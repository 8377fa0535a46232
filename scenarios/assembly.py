"""Build the diagram of a scenario: plant, contact, recording, playback."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from pydrake.common import RandomGenerator
from pydrake.geometry import Meshcat, MeshcatVisualizer, MeshcatVisualizerParams, Role
from pydrake.multibody.parsing import ModelDirectives, Parser, ProcessModelDirectives
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, VectorLogSink

from scenarios.contact_counts import ContactCounts
from scenarios.errors import ScenarioError
from scenarios.models import PACKAGE, write_models
from scenarios.scenario import Scenario
from systems import AddNonlinearDamperContact, NonlinearDamperContact, WitnessPairVisualizer


@dataclass(frozen=True)
class Assembly:
    """A scenario's diagram and the parts of it that a run looks at."""

    diagram: Diagram
    plant: MultibodyPlant
    contact: NonlinearDamperContact
    logs: Mapping[str, VectorLogSink]

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
        positions = self.plant.GetPositions(plant_context)
        for model, joints in scenario.initial_position.items():
            for joint, values in joints.items():
                positions[self._positions_of(model, joint, len(values))] = values
        self.plant.SetPositions(plant_context, positions)
        return simulator

    def _positions_of(self, model: str, joint: str, count: int) -> slice:
        where = f"initial_position.{model}.{joint}"
        try:
            instance = self.plant.GetModelInstanceByName(model)
            found = self.plant.GetJointByName(joint, instance)
        except RuntimeError as error:
            raise ScenarioError(f"{where}: {error}") from error
        if count != found.num_positions():
            raise ScenarioError(f"{where}: expected {found.num_positions()} positions, not {count}")
        return slice(found.position_start(), found.position_start() + count)


def assemble(scenario: Scenario, folder: Path, meshcat: Meshcat | None = None) -> Assembly:
    """Build the diagram; generated models go to `folder`, drawings to `meshcat`.

    Raises ScenarioError for models or contact settings that cannot be.
    """
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlant(scenario.plant_config, builder)
    try:
        write_models(scenario.parts, folder)
        parser = Parser(plant)
        parser.package_map().Add(PACKAGE, str(folder))
        ProcessModelDirectives(ModelDirectives(directives=scenario.directives), parser)
        plant.Finalize()
        contact = AddNonlinearDamperContact(builder, plant, scene_graph, config=scenario.contact)
    except (ValueError, RuntimeError) as error:  # Drake raises RuntimeError for all of its own
        raise ScenarioError(str(error)) from error
    counts = builder.AddNamedSystem("contact_counts", ContactCounts())
    builder.Connect(contact.get_contacts_output_port(), counts.get_input_port())
    period = scenario.record_period
    logs = {
        name: LogVectorOutput(port, builder, publish_period=period)
        for name, port in {
            "state": plant.get_state_output_port(),
            "wrenches": contact.get_body_wrenches_output_port(),
            "energies": contact.get_energies_output_port(),
            "counts": counts.get_output_port(),
        }.items()
    }
    if meshcat is not None:
        MeshcatVisualizer.AddToBuilder(
            builder,
            scene_graph,
            meshcat,
            MeshcatVisualizerParams(
                role=Role.kIllustration, publish_period=1 / scenario.visualization.frame_rate
            ),
        )
        if scenario.visualization.web:
            WitnessPairVisualizer.AddToBuilder(
                builder, contact, meshcat, publish_period=1 / scenario.visualization.frame_rate
            )
        for scenery in ("/Grid", "/Axes"):
            meshcat.SetProperty(scenery, "visible", value=False)
        meshcat.SetCameraPose(scenario.visualization.camera, scenario.visualization.target)
    return Assembly(builder.Build(), plant, contact, MappingProxyType(logs))
