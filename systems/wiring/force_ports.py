"""Add forces to a plant whose force input ports may already be in use."""

from __future__ import annotations

from collections.abc import Callable

from pydrake.multibody.plant import ExternallyAppliedSpatialForceMultiplexer
from pydrake.systems.framework import DiagramBuilder, InputPort, LeafSystem, OutputPort
from pydrake.systems.primitives import Adder


def add_generalized_force(builder: DiagramBuilder, force: OutputPort, port: InputPort) -> None:
    """Connect a generalized force; where the port is fed already, the sum of the two.

    Raises ValueError where the port is an input of the diagram: its feed is then unknown.
    """
    _connect_to_sum(builder, force, port, lambda: Adder(num_inputs=2, size=port.size()))


def add_spatial_forces(builder: DiagramBuilder, forces: OutputPort, port: InputPort) -> None:
    """Connect a list of spatial forces; where the port is fed already, both lists together.

    Raises ValueError where the port is an input of the diagram: its feed is then unknown.
    """
    _connect_to_sum(builder, forces, port, lambda: ExternallyAppliedSpatialForceMultiplexer(2))


def _connect_to_sum(
    builder: DiagramBuilder, force: OutputPort, port: InputPort, make_sum: Callable[[], LeafSystem]
) -> None:
    if not builder.IsConnectedOrExported(port):
        builder.Connect(force, port)
        return
    feed = _feed_of(builder, port)
    if feed is None:
        raise ValueError(
            f"input port {port.get_name()!r} of {port.get_system().get_name()!r} is exported from "
            "the diagram, so contact forces cannot be added to it; build the diagram within "
            "systems.OpenForcePorts(), or export the input of an Adder or "
            "ExternallyAppliedSpatialForceMultiplexer instead, and connect that to the plant"
        )
    total = builder.AddSystem(make_sum())
    builder.Disconnect(feed, port)
    builder.Connect(feed, total.get_input_port(0))
    builder.Connect(force, total.get_input_port(1))
    builder.Connect(total.get_output_port(), port)


def _feed_of(builder: DiagramBuilder, port: InputPort) -> OutputPort | None:
    for (system, index), (source, source_index) in builder.connection_map().items():
        if system is port.get_system() and index == port.get_index():
            return source.get_output_port(source_index)
    return None
