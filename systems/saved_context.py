"""SavedContext: what a simulation has come to, to be pickled and taken up again."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import (
    Context,
    Diagram,
    InputPort,
    InputPortIndex,
    PortDataType,
    System,
)

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class SavedContext:
    """Time, state, parameters and fixed inputs of a root context, which Drake does not pickle.

    Another diagram built alike, in this process or another, goes on from it: with the same bits as
    if nothing had been saved, where steps are of a fixed length (a discrete plant, or an integrator
    in fixed step mode). An integrator with error control chooses its first step anew.

    Attributes
    ----------
    time
        [s]
    accuracy
        That the context asks for, if it does.
    continuous, discrete, numeric
        Continuous state; groups of discrete state; groups of numeric parameters.
    states, parameters
        Index of each abstract state and parameter that Python knows and can pickle, and its value.
        Left out is what belongs to Drake's C++ alone: a discrete plant's sampled output ports tell
        of the last step again after the next one.
    inputs
        Of each input port that is fixed: the numbers of the systems it lies in, as they were added
        to their diagrams, and its own; and its value.

    Examples
    --------
    >>> import pickle
    >>> from pydrake.multibody.parsing import Parser
    >>> from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    >>> from pydrake.systems.analysis import Simulator
    >>> from pydrake.systems.framework import DiagramBuilder
    >>> from systems import AddNonlinearDamperContact, SavedContext
    >>> MODEL = '''<mujoco model="fall"><worldbody><geom type="plane" size="1 1 1"/>
    ...   <body name="ball" pos="0 0 0.05"><freejoint/><geom size="0.05"/></body>
    ... </worldbody></mujoco>'''
    >>> def build():
    ...     builder = DiagramBuilder()
    ...     plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.002)
    ...     Parser(plant).AddModelsFromString(MODEL, "xml")
    ...     plant.Finalize()
    ...     AddNonlinearDamperContact(builder, plant, scene_graph)
    ...     return builder.Build()
    >>> simulator = Simulator(build())
    >>> _ = simulator.AdvanceTo(0.1)
    >>> saved = pickle.dumps(SavedContext.of(simulator.get_system(), simulator.get_context()))
    >>> again = Simulator(build())  # in another process, say
    >>> pickle.loads(saved).restore(again.get_system(), again.get_mutable_context())
    >>> for each in (simulator, again):
    ...     _ = each.AdvanceTo(0.2)
    >>> bool((simulator.get_context().get_discrete_state_vector().CopyToVector() ==
    ...       again.get_context().get_discrete_state_vector().CopyToVector()).all())
    True
    """

    time: float
    accuracy: float | None
    continuous: Floats
    discrete: tuple[Floats, ...]
    numeric: tuple[Floats, ...]
    states: dict[int, Any]
    parameters: dict[int, Any]
    inputs: dict[tuple[int, ...], Any]

    @classmethod
    def of(cls, system: System, context: Context) -> SavedContext:
        """Save a root context of the system."""
        discrete = context.get_discrete_state()
        return cls(
            context.get_time(),
            context.get_accuracy(),
            context.get_continuous_state_vector().CopyToVector(),
            tuple(
                discrete.get_vector(i).CopyToVector()
                for i in range(context.num_discrete_state_groups())
            ),
            tuple(
                context.get_numeric_parameter(i).CopyToVector()
                for i in range(context.num_numeric_parameter_groups())
            ),
            _known(context.num_abstract_states(), context.get_abstract_state),
            _known(context.num_abstract_parameters(), context.get_abstract_parameter),
            {
                path: _value_of(port, own)
                for path, port, own in _unfed_ports(system, context)
                if port.HasValue(own)
            },
        )

    def restore(self, system: System, context: Context) -> None:
        """Put all of it into a root context of a system built alike.

        A simulator that has stepped already wants `Initialize` after it.

        Raises
        ------
        ValueError
            Where the system has other states, parameters or input ports.
        """
        own = SavedContext.of(system, context)
        for name in ("continuous", "discrete", "numeric"):
            mine, others = (_sizes(getattr(each, name)) for each in (own, self))
            if mine != others:
                raise ValueError(
                    f"the context was saved of another system: its {name} values are of sizes "
                    f"{others}, those of this one {mine}; build the diagram as it was built then"
                )
        ports = {path: (port, at) for path, port, at in _unfed_ports(system, context)}
        lacking = sorted(set(self.inputs) - set(ports))
        states = max(self.states, default=-1), max(self.parameters, default=-1)
        here = context.num_abstract_states(), context.num_abstract_parameters()
        if lacking or states[0] >= here[0] or states[1] >= here[1]:
            raise ValueError(
                "the context was saved of another system: this one lacks "
                + (f"an input port at {lacking[0]}" if lacking else "some of its abstract values")
                + "; build the diagram as it was built then"
            )
        context.SetTime(self.time)
        context.SetAccuracy(self.accuracy)
        context.SetContinuousState(self.continuous)
        for i, values in enumerate(self.discrete):
            context.SetDiscreteState(i, values)
        for i, values in enumerate(self.numeric):
            context.get_mutable_numeric_parameter(i).SetFromVector(values)
        for i, value in self.states.items():
            context.get_mutable_abstract_state(i).set_value(value)
        for i, value in self.parameters.items():
            context.get_mutable_abstract_parameter(i).set_value(value)
        for path, value in self.inputs.items():
            port, at = ports[path]
            port.FixValue(at, value)


def _sizes(values: Any) -> list[int]:
    return [np.size(each) for each in values] if isinstance(values, tuple) else [values.size]


def _known(count: int, get: Any) -> dict[int, Any]:
    """Return the values that Python knows and can pickle."""
    known = {}
    for i in range(count):
        try:
            value = get(i).get_value()
            pickle.dumps(value)
        except (RuntimeError, TypeError, AttributeError, pickle.PicklingError):
            continue  # of a C++ type: see the class
        known[i] = value
    return known


def _value_of(port: InputPort, context: Context) -> Any:
    value = port.Eval(context)
    return np.array(value) if port.get_data_type() == PortDataType.kVectorValued else value


_Unfed: TypeAlias = Iterator[tuple[tuple[int, ...], InputPort, Context]]


def _unfed_ports(system: System, context: Context) -> _Unfed:
    """Yield the input ports that nothing feeds, and where they are fixed if they are."""
    for i in range(system.num_input_ports()):
        yield (i,), system.get_input_port(i), context
    yield from _unfed_within(system, context, ())


def _unfed_within(system: System, context: Context, path: tuple[int, ...]) -> _Unfed:
    if not isinstance(system, Diagram):
        return
    fed = set(system.connection_map())
    for i in range(system.num_input_ports()):
        fed.update(system.GetInputPortLocators(InputPortIndex(i)))
    for number, inner in enumerate(system.GetSystems()):
        own = system.GetSubsystemContext(inner, context)
        for i in range(inner.num_input_ports()):
            port = inner.get_input_port(i)
            if (inner, port.get_index()) not in fed:
                yield (*path, number, i), port, own
        yield from _unfed_within(inner, own, (*path, number))
