"""Contact in a station that exports its plant's force ports before one can connect to them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.multibody.plant import ExternallyAppliedSpatialForce, MultibodyPlant
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiagramBuilder,
    InputPort,
    LeafSystem,
    PortDataType,
)

_FORCE_PORTS = ("applied_generalized_force", "applied_spatial_force")


class OptionalForce(LeafSystem):
    """Passes a force on: zero, or an empty list, where nothing is connected."""

    def __init__(self, port: InputPort) -> None:
        super().__init__()
        if port.get_data_type() == PortDataType.kVectorValued:
            self._zero = np.zeros(port.size())
            self._force = self.DeclareVectorInputPort("force", port.size())
            self.DeclareVectorOutputPort("force", port.size(), self._pass_vector)
        else:
            empty = AbstractValue.Make([ExternallyAppliedSpatialForce()])
            self._force = self.DeclareAbstractInputPort("force", empty)
            self.DeclareAbstractOutputPort("force", empty.Clone, self._pass_list)

    def _pass_vector(self, context: Context, output: BasicVector) -> None:
        given = self._force.HasValue(context)
        output.SetFromVector(self._force.Eval(context) if given else self._zero)

    def _pass_list(self, context: Context, output: AbstractValue) -> None:
        output.set_value(self._force.Eval(context) if self._force.HasValue(context) else [])


@contextmanager
def OpenForcePorts() -> Iterator[None]:
    """Have diagrams built meanwhile export their plants' force ports through `OptionalForce`.

    `MakeHardwareStation` of the `manipulation` package exports both ports before it calls back, so
    contact could not be connected. The station looks the same from outside:

    ::

        def add_contact(builder):
            plant = builder.GetSubsystemByName("plant")
            scene_graph = builder.GetSubsystemByName("scene_graph")
            AddNonlinearDamperContact(builder, plant, scene_graph)

        with OpenForcePorts():
            station = MakeHardwareStation(scenario, prebuild_callback=add_contact)

    Examples
    --------
    >>> from pydrake.multibody.parsing import Parser
    >>> from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    >>> from pydrake.systems.framework import DiagramBuilder
    >>> from systems import AddNonlinearDamperContact, OpenForcePorts
    >>> MODEL = '''<mujoco model="fall"><worldbody><geom type="plane" size="1 1 1"/>
    ...   <body name="ball" pos="0 0 0.05"><freejoint/><geom size="0.05"/></body>
    ... </worldbody></mujoco>'''
    >>> builder = DiagramBuilder()
    >>> plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.002)
    >>> _ = Parser(plant).AddModelsFromString(MODEL, "xml")
    >>> plant.Finalize()
    >>> with OpenForcePorts():
    ...     port = plant.get_applied_generalized_force_input_port()
    ...     _ = builder.ExportInput(port, "push")
    ...     _ = AddNonlinearDamperContact(builder, plant, scene_graph)
    ...     diagram = builder.Build()
    >>> diagram.GetInputPort("push").size()
    6
    """
    export: Callable[..., Any] = DiagramBuilder.ExportInput

    def export_openly(builder: DiagramBuilder, port: InputPort, *args: Any, **kwargs: Any) -> Any:
        force = port.get_name() in _FORCE_PORTS and isinstance(port.get_system(), MultibodyPlant)
        if not force or builder.IsConnectedOrExported(port):
            return export(builder, port, *args, **kwargs)
        through = builder.AddNamedSystem(f"outside_{port.get_name()}", OptionalForce(port))
        builder.Connect(through.get_output_port(), port)
        return export(builder, through.get_input_port(), *args, **kwargs)

    DiagramBuilder.ExportInput = export_openly
    try:
        yield
    finally:
        DiagramBuilder.ExportInput = export
