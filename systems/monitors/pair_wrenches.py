"""Who pushes whom: wrenches between chosen bodies, for logs and decisions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import BasicVector, Context, DiagramBuilder, InputPort, LeafSystem

from contact_toolkit import ContactModel
from systems.plant.body_pair import BodyPair

if TYPE_CHECKING:
    from systems.nonlinear_damper_contact import NonlinearDamperContact


class PairWrenches(LeafSystem):
    """Puts out the wrenches between chosen bodies as one vector, ready for `LogVectorOutput`.

    In: `contacts` and `poses` of a `NonlinearDamperContact`. Out: `wrenches` (6 n,), of each pair
    (a, b) what b does to a: torque about a's origin [N m] and force [N], in W.

    Examples
    --------
    >>> from pydrake.multibody.parsing import Parser
    >>> from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    >>> from pydrake.systems.analysis import Simulator
    >>> from pydrake.systems.framework import DiagramBuilder
    >>> from systems import AddNonlinearDamperContact, PairWrenches
    >>> MODEL = '''<mujoco model="fall"><worldbody><geom type="plane" size="1 1 1"/>
    ...   <body name="ball" pos="0 0 0.05"><freejoint/><geom size="0.05"/></body>
    ... </worldbody></mujoco>'''
    >>> builder = DiagramBuilder()
    >>> plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.002)
    >>> _ = Parser(plant).AddModelsFromString(MODEL, "xml")
    >>> plant.Finalize()
    >>> contact = AddNonlinearDamperContact(builder, plant, scene_graph)
    >>> between = PairWrenches.AddToBuilder(builder, contact, [("ball", "world")])
    >>> simulator = Simulator(builder.Build())
    >>> _ = simulator.AdvanceTo(0.5)
    >>> context = between.GetMyContextFromRoot(simulator.get_context())
    >>> bool(between.get_output_port().Eval(context)[5] > 0)  # the ground pushes the ball up
    True
    """

    def __init__(self, model: ContactModel, pairs: Sequence[tuple[str, str]]) -> None:
        super().__init__()
        self._pairs = [BodyPair(model, a, b) for a, b in pairs]
        self._contacts = self.DeclareAbstractInputPort("contacts", Value[object]())
        self._poses = self.DeclareAbstractInputPort("poses", Value[object]())
        self.DeclareVectorOutputPort("wrenches", 6 * len(self._pairs), self._calc)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder,
        contact: NonlinearDamperContact,
        pairs: Sequence[tuple[str, str]],
    ) -> PairWrenches:
        """Add one to the builder, connected to `contact`; see the class."""
        system = builder.AddSystem(PairWrenches(contact.model, pairs))
        builder.Connect(contact.get_contacts_output_port(), system.get_contacts_input_port())
        builder.Connect(contact.get_poses_output_port(), system.get_poses_input_port())
        return system

    def get_contacts_input_port(self) -> InputPort:
        """Return the port for a `contact_toolkit.ContactArrays`."""
        return self._contacts

    def get_poses_input_port(self) -> InputPort:
        """Return the port for the poses of the bodies of the model."""
        return self._poses

    def _calc(self, context: Context, output: BasicVector) -> None:
        contacts, X_WB = self._contacts.Eval(context), self._poses.Eval(context)
        output.SetFromVector(
            np.concatenate([pair.wrench(contacts, X_WB) for pair in self._pairs])
            if self._pairs
            else np.zeros(0)
        )
