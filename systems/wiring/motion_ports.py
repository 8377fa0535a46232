"""MotionPorts: the input ports through which a system sees the bodies of a plant move."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import Context, DependencyTicket, InputPort, LeafSystem

from systems.body_motion import BodyMotion

Floats = NDArray[np.float64]


class MotionPorts:
    """Ports `state`, `body_poses` and `body_spatial_velocities` of `system`, named as the plant's.

    Floating bodies are read from the first, the others from the lists.

    Parameters
    ----------
    system
        Gets the ports.
    plant
        Finalized.
    bodies
        The plant's body for each body of the model.
    lists_only
        Read floating bodies from the lists too.
    """

    def __init__(
        self,
        system: LeafSystem,
        plant: MultibodyPlant,
        bodies: Sequence[BodyIndex],
        *,
        lists_only: bool = False,
    ) -> None:
        self.bodies = BodyMotion(plant, bodies, lists_only=lists_only)
        self._num_positions = plant.num_positions()
        self._no_state = np.zeros(self._num_positions + plant.num_velocities())
        self.state = system.DeclareVectorInputPort("state", len(self._no_state))
        self.poses = system.DeclareAbstractInputPort(
            "body_poses", AbstractValue.Make([RigidTransform()])
        )
        self.velocities = system.DeclareAbstractInputPort(
            "body_spatial_velocities", AbstractValue.Make([SpatialVelocity()])
        )
        self.pose_tickets = {_ticket(system, self.state), _ticket(system, self.poses)}
        self.velocity_ticket = _ticket(system, self.velocities)

    def read_positions(self, context: Context) -> Floats | None:
        """Return the plant's positions (nq,); None where `state` is not connected."""
        if not self.state.HasValue(context):
            return None
        return self.state.Eval(context)[: self._num_positions]

    def read_poses(self, context: Context) -> tuple[Floats, Floats]:
        """Return X_WB (nb, 4, 4), and V_WB (nb, 6) without the velocities of listed bodies."""
        state = self.state.Eval(context) if self.bodies.uses_state else self._no_state
        X_WB, V_WB = self.bodies.read_state(state)
        if self.bodies.uses_lists:
            self.bodies.fill_in_poses(X_WB, self.poses.Eval(context))
        return X_WB, V_WB

    def with_listed(self, context: Context, V_WB: Floats) -> Floats:
        """Return V_WB with the velocities of listed bodies."""
        if self.bodies.uses_lists:
            V_WB = V_WB.copy()
            self.bodies.fill_in_velocities(V_WB, self.velocities.Eval(context))
        return V_WB

    def read(self, context: Context) -> tuple[Floats, Floats]:
        """Return X_WB (nb, 4, 4) and V_WB (nb, 6) of all bodies."""
        X_WB, V_WB = self.read_poses(context)
        return X_WB, self.with_listed(context, V_WB)


def _ticket(system: LeafSystem, port: InputPort) -> DependencyTicket:
    return system.input_port_ticket(port.get_index())
