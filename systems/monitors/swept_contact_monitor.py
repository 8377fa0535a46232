"""SweptContactMonitor: finds bodies that passed through each other within one step."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiagramBuilder,
    InputPort,
    LeafSystem,
    OutputPort,
    State,
)

from systems.monitors.swept_passes import SweptPasses
from systems.nonlinear_damper_contact import NonlinearDamperContact
from systems.python_cache import holding, producer

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class StepEnd:
    """Where bodies stood when a step ended, and how often pairs had passed by then.

    Attributes
    ----------
    time
        [s]; −infinity before the first step.
    X_WB
        (nb, 4, 4) poses of the bodies.
    loaded
        (np,) whether the pair was in contact.
    passes
        (np,) how often the pair has passed through each other.
    """

    time: float
    X_WB: Floats
    loaded: NDArray[np.bool_]
    passes: Floats

    def __deepcopy__(self, memo: dict[int, Any]) -> StepEnd:
        """Return itself: immutable, so a context may copy it for free."""
        return self


class SweptContactMonitor(LeafSystem):
    """Checks every accepted step for pairs that met on the way without being in contact.

    Contact acts only where the integrator evaluates it. A fast or thin body can stand on one side
    of a wall at the start of a step and on the other at its end: it has tunnelled. The monitor
    sweeps the pairs that are in contact neither at the start nor at the end.

    ::

                   ┌───────────────────────┐
        poses ────>│                       │
        contacts ─>│  SweptContactMonitor  │──> passes
                   └───────────────────────┘

    - `passes` (np,): how often each pair of the contact model has passed through each other.

    Parameters
    ----------
    contact
        The contact system watched.
    when_passed
        "raise" RuntimeError as soon as the step is over, "warn" each time, or just "count".

    Examples
    --------
    >>> from pydrake.multibody.parsing import Parser
    >>> from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    >>> from pydrake.systems.analysis import Simulator
    >>> from pydrake.systems.framework import DiagramBuilder
    >>> from systems import AddNonlinearDamperContact, SweptContactMonitor
    >>> MODEL = '''<mujoco model="fall"><worldbody><geom type="plane" size="1 1 1"/>
    ...   <body name="ball" pos="0 0 0.05"><freejoint/><geom size="0.05"/></body>
    ... </worldbody></mujoco>'''
    >>> builder = DiagramBuilder()
    >>> plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.002)
    >>> _ = Parser(plant).AddModelsFromString(MODEL, "xml")
    >>> plant.Finalize()
    >>> contact = AddNonlinearDamperContact(builder, plant, scene_graph)
    >>> monitor = SweptContactMonitor.AddToBuilder(builder, contact, when_passed="count")
    >>> simulator = Simulator(builder.Build())
    >>> _ = simulator.AdvanceTo(0.1)
    >>> context = monitor.GetMyContextFromRoot(simulator.get_context())
    >>> monitor.get_passes_output_port().Eval(context)
    array([0.])
    """

    def __init__(
        self,
        contact: NonlinearDamperContact,
        *,
        when_passed: Literal["raise", "warn", "count"] = "raise",
    ) -> None:
        super().__init__()
        if when_passed not in ("raise", "warn", "count"):
            raise ValueError(f"when_passed must be raise, warn or count, not {when_passed!r}")
        self._model = contact.model
        self._when_passed = when_passed
        self._swept = SweptPasses(contact.model)
        self._poses = self.DeclareAbstractInputPort("poses", Value[object]())
        self._contacts = self.DeclareAbstractInputPort("contacts", Value[object]())
        num_pairs = len(contact.model.pairs)
        before = StepEnd(-np.inf, np.zeros(0), np.zeros(num_pairs, bool), np.zeros(num_pairs))
        self._last = self.DeclareAbstractState(holding(before))
        self._next = self.DeclareCacheEntry(
            "step end",
            producer(self._calc_next),
            {
                self.input_port_ticket(self._poses.get_index()),
                self.input_port_ticket(self._contacts.get_index()),
                self.abstract_state_ticket(self._last),
                self.time_ticket(),
            },
        )
        self.DeclareVectorOutputPort(
            "passes", num_pairs, self._output_passes, {self._next.ticket()}
        )
        self.DeclarePerStepUnrestrictedUpdateEvent(update=self._advance)
        self.DeclarePerStepPublishEvent(publish=self._tell)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder,
        contact: NonlinearDamperContact,
        *,
        when_passed: Literal["raise", "warn", "count"] = "raise",
    ) -> SweptContactMonitor:
        """Add a monitor of `contact` to the builder, connected; see the class."""
        monitor = SweptContactMonitor(contact, when_passed=when_passed)
        builder.AddNamedSystem("swept_contact_monitor", monitor)
        builder.Connect(contact.get_poses_output_port(), monitor.get_poses_input_port())
        builder.Connect(contact.get_contacts_output_port(), monitor.get_contacts_input_port())
        return monitor

    def get_poses_input_port(self) -> InputPort:
        """Return the port for the poses of the contact system's bodies."""
        return self._poses

    def get_contacts_input_port(self) -> InputPort:
        """Return the port for the contact system's loaded springs."""
        return self._contacts

    def get_passes_output_port(self) -> OutputPort:
        """Return the port of how often each pair has passed through each other."""
        return self.GetOutputPort("passes")

    def _eval_last(self, context: Context) -> StepEnd:
        last: StepEnd = context.get_abstract_state(self._last).get_value()
        return last

    def _eval_next(self, context: Context) -> StepEnd:
        """Return the step end as it would be were the present the end of a step."""
        step_end: StepEnd = self._next.Eval(context)
        return step_end

    def _calc_next(self, context: Context, output: AbstractValue) -> None:
        last = self._eval_last(context)
        X_WB = self._poses.Eval(context)
        loaded = np.zeros_like(last.loaded)
        loaded[self._contacts.Eval(context).pair] = True
        passes = last.passes
        # At one and the same time the state may have been set anew: that is no motion.
        if last.X_WB.size and context.get_time() > last.time:
            met = self._swept.find(last.X_WB, X_WB, np.flatnonzero(~loaded & ~last.loaded))
            passes = passes.copy()
            passes[met] += 1
        output.set_value(StepEnd(context.get_time(), X_WB, loaded, passes))

    def _advance(self, context: Context, state: State) -> None:
        state.get_mutable_abstract_state(self._last).set_value(self._eval_next(context))

    def _tell(self, context: Context) -> None:
        if self._when_passed == "count":
            return
        last, now = self._eval_last(context), self._eval_next(context)
        for pair in np.flatnonzero(now.passes > last.passes):
            a, b = self._model.pair_names(int(pair))
            message = (
                f"{a} and {b} passed through each other between t = {last.time:.6g} s and "
                f"{now.time:.6g} s, without contact at either; shorten the integrator's maximum "
                "step, or the plant's time step"
            )
            if self._when_passed == "raise":
                raise RuntimeError(message)
            warnings.warn(message, RuntimeWarning, stacklevel=2)

    def _output_passes(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._eval_next(context).passes)
