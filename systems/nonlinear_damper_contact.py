"""NonlinearDamperContact: contact forces between the bodies of a MultibodyPlant."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import ExternallyAppliedSpatialForce, MultibodyPlant
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DependencyTicket,
    InputPort,
    LeafSystem,
    OutputPort,
    State,
)

from contact_toolkit import ContactModel, Forces, StepTable
from systems.accepted_step import AcceptedStep
from systems.body_motion import BodyMotion
from systems.contact_watch import ContactWatch, Reported
from systems.python_cache import holding, producer

Floats: TypeAlias = NDArray[np.float64]


class NonlinearDamperContact(LeafSystem):
    """Pushes and rubs the bodies of a plant that touch, in place of its built-in contact.

    `AddNonlinearDamperContact` makes and connects one. By hand: connect the inputs to the plant's
    output ports of the same names, and the first two outputs to its `applied_generalized_force` and
    `applied_spatial_force`.

    ```
                              ┌──────────────────────────┐
    state ───────────────────>│                          │──> generalized_forces
    body_poses ──────────────>│  NonlinearDamperContact  │──> spatial_forces
    body_spatial_velocities ─>│                          │──> contacts
                              │       (step table)       │──> poses
                              │                          │──> body_wrenches
                              │                          │──> powers
                              │                          │──> energies
                              └──────────────────────────┘
    ```

    Floating bodies (on quaternions) are read from `state` and pushed by `generalized_forces`, which
    costs next to nothing; the others are read from the lists and pushed by `spatial_forces`. Ports
    that no body needs stay unconnected (see `uses_state`, `uses_lists`).

    - `generalized_forces` (nv,); `spatial_forces`, one for each loaded body of the others.
    - `contacts`: a `contact_toolkit.ContactArrays` in W, one row for each loaded spring.
    - `poses`: X_WB (nb, 4, 4) of the bodies of the model, as a numpy array.
    - `body_wrenches` (6 nb,): torque about Bo [N m] and force [N] in W of each body of the model.
    - `powers` (2,) [W]: lost in damping, lost to friction.
    - `energies` (4,) [J]: stored in normal and in tangential deformation; lost in damping and to
      friction since the start, summed by the trapezoidal rule over steps.

    The step table (friction anchors, losses, what speeds up the next search) is replaced once an
    accepted step. Apart from what has been warned about there is no other state; nothing changes in
    the object itself, so any number of contexts run independently.

    A discrete plant takes contact forces explicitly. Above 0.2 times the stable time step it is
    warned of, with the number; beyond the stable step, RuntimeError. A continuous plant meets
    contact only where its integrator evaluates forces, and in free flight that would soon be a
    tenth of a second apart. So a continuous plant never steps longer than `max_step`; steps still
    too long for a contact are warned of, with the accuracy to ask of the integrator.

    Parameters
    ----------
    plant
        Finalized; continuous or discrete.
    model
        The contact model.
    bodies
        The plant's body for each body of the model.
    lists_only
        Read and push floating bodies through the lists too: slower, and equal to round-off.
    max_step
        Longest step of a continuous plant [s]; nothing may cross a body in it. Zero: no limit but
        the integrator's own.
    when_deep
        What to do when bodies penetrate farther than the web can tell: "warn", once a pair and
        context, or "raise".
    when_chattering
        What to do when forces that leap leave the integrator of a continuous plant no step to take:
        "raise", or "warn", once a context.
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        model: ContactModel,
        bodies: Sequence[BodyIndex],
        *,
        lists_only: bool = False,
        max_step: float = 0.005,
        when_deep: str = "warn",
        when_chattering: str = "raise",
    ) -> None:
        super().__init__()
        self._model = model
        self._bodies = tuple(bodies)
        self._motion = BodyMotion(plant, bodies, lists_only=lists_only)
        self._no_state = np.zeros(plant.num_positions() + plant.num_velocities())
        self._declare_inputs()
        self._table = self.DeclareAbstractState(holding(model.initial_table()))
        self._watch = ContactWatch(
            plant, model, bodies, when_deep=when_deep, when_chattering=when_chattering
        )
        self._reported = self.DeclareAbstractState(holding(Reported()))
        self._declare_cache()
        self._declare_outputs(plant.num_velocities())
        self.DeclarePerStepUnrestrictedUpdateEvent(update=self._advance)
        if not max_step >= 0:
            raise ValueError(f"max_step must be a time [s] >= 0, not {max_step}")
        if max_step > 0 and plant.time_step() == 0:
            # No step passes the time of an event, be it to do nothing.
            self.DeclarePeriodicPublishEvent(max_step, 0.0, lambda context: None)  # noqa: ARG005

    @property
    def model(self) -> ContactModel:
        """The contact model, with the geometries and pairs that `contacts` refers to."""
        return self._model

    @property
    def bodies(self) -> tuple[BodyIndex, ...]:
        """The plant's body for each body of the model."""
        return self._bodies

    @property
    def uses_state(self) -> bool:
        """Whether `state` must be connected, and `generalized_forces` carries forces."""
        return self._motion.uses_state

    @property
    def uses_lists(self) -> bool:
        """Whether the list inputs must be connected, and `spatial_forces` carries forces."""
        return self._motion.uses_lists

    def get_state_input_port(self) -> InputPort:
        """Return the port for the plant's `state`, positions then velocities."""
        return self._state

    def get_body_poses_input_port(self) -> InputPort:
        """Return the port for the plant's `body_poses`."""
        return self._body_poses

    def get_body_spatial_velocities_input_port(self) -> InputPort:
        """Return the port for the plant's `body_spatial_velocities`."""
        return self._body_velocities

    def get_generalized_forces_output_port(self) -> OutputPort:
        """Return the port of the generalized forces on floating bodies."""
        return self.GetOutputPort("generalized_forces")

    def get_spatial_forces_output_port(self) -> OutputPort:
        """Return the port of the spatial forces on the other bodies."""
        return self.GetOutputPort("spatial_forces")

    def get_contacts_output_port(self) -> OutputPort:
        """Return the port of the loaded springs, a `contact_toolkit.ContactArrays` in W."""
        return self.GetOutputPort("contacts")

    def get_poses_output_port(self) -> OutputPort:
        """Return the port of the poses of the bodies of the model, (nb, 4, 4) in W."""
        return self.GetOutputPort("poses")

    def get_body_wrenches_output_port(self) -> OutputPort:
        """Return the port of the wrenches on the bodies of the model."""
        return self.GetOutputPort("body_wrenches")

    def get_powers_output_port(self) -> OutputPort:
        """Return the port of the power lost in damping and to friction [W]."""
        return self.GetOutputPort("powers")

    def get_energies_output_port(self) -> OutputPort:
        """Return the port of the energies stored and lost [J]."""
        return self.GetOutputPort("energies")

    def _declare_inputs(self) -> None:
        self._state = self.DeclareVectorInputPort("state", len(self._no_state))
        self._body_poses = self.DeclareAbstractInputPort(
            "body_poses", AbstractValue.Make([RigidTransform()])
        )
        self._body_velocities = self.DeclareAbstractInputPort(
            "body_spatial_velocities", AbstractValue.Make([SpatialVelocity()])
        )

    def _declare_cache(self) -> None:
        # The springs do not depend on the step table: it only makes finding them faster.
        self._found = self.DeclareCacheEntry(
            "loaded springs", producer(self._find), self._pose_tickets()
        )
        self._forces = self.DeclareCacheEntry(
            "forces",
            producer(self._push),
            {
                self._found.ticket(),
                self.input_port_ticket(self._body_velocities.get_index()),
                self.abstract_state_ticket(self._table),
            },
        )

    def _pose_tickets(self) -> set[DependencyTicket]:
        return {
            self.input_port_ticket(port.get_index()) for port in (self._state, self._body_poses)
        }

    def _declare_outputs(self, num_velocities: int) -> None:
        forces = {self._forces.ticket()}
        wrenches = 6 * len(self._bodies)
        self.DeclareVectorOutputPort(
            "generalized_forces", num_velocities, self._output_generalized_forces, forces
        )
        self.DeclareAbstractOutputPort(
            "spatial_forces",
            lambda: AbstractValue.Make([ExternallyAppliedSpatialForce()]),
            self._output_spatial_forces,
            forces,
        )
        self.DeclareAbstractOutputPort("contacts", Value[object], self._output_contacts, forces)
        self.DeclareAbstractOutputPort(
            "poses", Value[object], self._output_poses, self._pose_tickets()
        )
        self.DeclareVectorOutputPort("body_wrenches", wrenches, self._output_wrenches, forces)
        self.DeclareVectorOutputPort("powers", 2, self._output_powers, forces)
        self.DeclareVectorOutputPort(
            "energies", 4, self._output_energies, forces | {self.time_ticket()}
        )

    def _read_motion(self, context: Context) -> tuple[Floats, Floats]:
        """Return poses, and velocities without those of listed bodies."""
        state = self._state.Eval(context) if self._motion.uses_state else self._no_state
        X_WB, V_WB = self._motion.read_state(state)
        if self._motion.uses_lists:
            self._motion.fill_in_poses(X_WB, self._body_poses.Eval(context))
        return X_WB, V_WB

    def _find(self, context: Context, output: AbstractValue) -> None:
        X_WB, V_WB = self._read_motion(context)
        output.set_value((self._model.find(X_WB, self._eval_table(context)), V_WB))

    def _push(self, context: Context, forces: AbstractValue) -> None:
        found, V_WB = self._found.Eval(context)
        if self._motion.uses_lists:
            V_WB = V_WB.copy()
            self._motion.fill_in_velocities(V_WB, self._body_velocities.Eval(context))
        forces.set_value(self._model.forces(found, V_WB, self._eval_table(context)))

    def _eval_table(self, context: Context) -> StepTable:
        return context.get_abstract_state(self._table).get_value()

    def _eval_forces(self, context: Context) -> Forces:
        return self._forces.Eval(context)

    def _eval_advanced_table(self, context: Context) -> StepTable:
        """Return the step table as it would be were the present the end of a step."""
        forces = self._eval_forces(context)
        return self._model.advance(self._eval_table(context), context.get_time(), forces)

    def _advance(self, context: Context, state: State) -> None:
        table, advanced = self._eval_table(context), self._eval_advanced_table(context)
        reported = self._watch.look(
            context.get_abstract_state(self._reported).get_value(),
            AcceptedStep(table, advanced, self._eval_forces(context)),
            lambda: self._read_motion(context)[0],
        )
        state.get_mutable_abstract_state(self._reported).set_value(reported)
        state.get_mutable_abstract_state(self._table).set_value(advanced)

    def _output_generalized_forces(self, context: Context, output: BasicVector) -> None:
        wrenches = self._eval_forces(context).body_wrenches
        output.SetFromVector(self._motion.generalized_forces(wrenches))

    def _output_spatial_forces(self, context: Context, output: AbstractValue) -> None:
        wrenches = self._eval_forces(context).body_wrenches
        output.set_value(self._motion.spatial_forces(wrenches))

    def _output_contacts(self, context: Context, output: AbstractValue) -> None:
        output.set_value(self._eval_forces(context).contacts)

    def _output_poses(self, context: Context, output: AbstractValue) -> None:
        output.set_value(self._read_motion(context)[0])

    def _output_wrenches(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._eval_forces(context).body_wrenches.ravel())

    def _output_powers(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._eval_forces(context).powers)

    def _output_energies(self, context: Context, output: BasicVector) -> None:
        stored = self._eval_forces(context).energies
        lost = self._eval_advanced_table(context).losses
        output.SetFromVector(np.concatenate([stored, lost]))
