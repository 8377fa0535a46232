"""PlantInputs: a system's copies of a plant's input ports, fed by whatever feeds the plant."""

from __future__ import annotations

from collections.abc import Callable

from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import (
    Context,
    DependencyTicket,
    DiagramBuilder,
    InputPort,
    LeafSystem,
    PortDataType,
)

_GEOMETRY = "geometry_query"
_FORCES = ("applied_generalized_force", "applied_spatial_force")


class PlantInputs:
    """Input ports `plant_…` of `system`, one for each of the plant's but geometry.

    The two force ports of the plant carry what `system` itself puts out, so their copies are for
    the forces of others alone.
    """

    def __init__(self, system: LeafSystem, plant: MultibodyPlant) -> None:
        self._plant = plant
        self._ports: dict[str, InputPort] = {}
        for i in range(plant.num_input_ports()):
            port = plant.get_input_port(i)
            name = port.get_name()
            vector = port.get_data_type() == PortDataType.kVectorValued
            if name == _GEOMETRY or (vector and port.size() == 0):
                continue
            copy = f"plant_{name}"
            self._ports[name] = (
                system.DeclareVectorInputPort(copy, port.size())
                if vector
                else system.DeclareAbstractInputPort(copy, port.Allocate())
            )

    def connect(self, builder: DiagramBuilder) -> None:
        """Feed the copies of all ports that are connected, or exported, by now."""
        for name, copy in self._ports.items():
            port = self._plant.GetInputPort(name)
            if (
                name not in _FORCES
                and builder.IsConnectedOrExported(port)
                and not builder.IsConnectedOrExported(copy)
            ):
                builder.ConnectToSame(port, copy)

    def connect_forces(self, builder: DiagramBuilder) -> None:
        """Feed the copies of the force ports by what feeds these now."""
        for name in _FORCES:
            if builder.IsConnectedOrExported(self._plant.GetInputPort(name)):
                builder.ConnectToSame(self._plant.GetInputPort(name), self._ports[name])

    def tickets(self) -> set[DependencyTicket]:
        """Return what depends on them depends on."""
        return {
            port.get_system().input_port_ticket(port.get_index()) for port in self._ports.values()
        }

    def read(self, context: Context) -> dict[str, object]:
        """Return the values of those that have one, by the plant's names."""
        return {
            name: port.Eval(context) for name, port in self._ports.items() if port.HasValue(context)
        }


def before_build(builder: DiagramBuilder, finish: Callable[[], None]) -> None:
    """Call `finish` when the builder builds, after everything has been connected."""
    for name in ("Build", "BuildInto"):
        build = getattr(builder, name)

        def finish_and_build(*args: object, build: Callable[..., object] = build) -> object:
            finish()
            return build(*args)

        setattr(builder, name, finish_and_build)
