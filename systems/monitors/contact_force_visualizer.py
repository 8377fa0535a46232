"""ContactForceVisualizer: arrows in Meshcat where Drake's own contact visualizer has them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import Value
from pydrake.geometry import Cylinder, Meshcat, MeshcatCone, Rgba
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.framework import Context, DiagramBuilder, InputPort, LeafSystem

from contact_toolkit import ContactArrays, ContactModel

if TYPE_CHECKING:
    from systems.nonlinear_damper_contact import NonlinearDamperContact

_COLOR = Rgba(0.5, 0.0, 0.5)  # Drake's, for hydroelastic forces
_RADIUS, _HEAD = 0.002, 0.006  # [m] of the arrow, and of its head
_LEAST = 1e-3  # [N] smaller forces are not drawn, as with Drake's visualizer


class ContactForceVisualizer(LeafSystem):
    """Draws one arrow for each two bodies that push each other: the whole force on the second.

    It stands where the force has no moment but about itself, as near as springs tell: at their
    centre, weighted by load. Paths are those of Drake's `ContactVisualizer`,
    `contact_forces/hydroelastic/A+B`, whose results are empty for what touches by this system.

    Parameters
    ----------
    model
        Of the contact that is shown.
    meshcat
        Where to draw.
    publish_period
        Time between frames [s].
    prefix
        Folder in Meshcat's tree that holds the arrows.
    newtons_per_meter
        Force that an arrow of a metre stands for.

    Examples
    --------
    >>> from pydrake.geometry import Meshcat, MeshcatParams
    >>> from pydrake.multibody.parsing import Parser
    >>> from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    >>> from pydrake.systems.analysis import Simulator
    >>> from pydrake.systems.framework import DiagramBuilder
    >>> from systems import AddNonlinearDamperContact, ContactForceVisualizer
    >>> MODEL = '''<mujoco model="fall"><worldbody><geom type="plane" size="1 1 1"/>
    ...   <body name="ball" pos="0 0 0.05"><freejoint/><geom size="0.05"/></body>
    ... </worldbody></mujoco>'''
    >>> builder = DiagramBuilder()
    >>> plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.002)
    >>> _ = Parser(plant).AddModelsFromString(MODEL, "xml")
    >>> plant.Finalize()
    >>> contact = AddNonlinearDamperContact(builder, plant, scene_graph)
    >>> meshcat = Meshcat(MeshcatParams(host="localhost"))
    >>> _ = ContactForceVisualizer.AddToBuilder(builder, contact, meshcat)
    >>> simulator = Simulator(builder.Build())
    >>> _ = simulator.AdvanceTo(0.1)
    >>> meshcat.HasPath("contact_forces")
    True
    """

    def __init__(
        self,
        model: ContactModel,
        meshcat: Meshcat,
        *,
        publish_period: float = 1 / 32,
        prefix: str = "contact_forces",
        newtons_per_meter: float = 100.0,
    ) -> None:
        super().__init__()
        if not publish_period > 0:
            raise ValueError(f"publish_period must be a time [s] > 0, not {publish_period}")
        if not newtons_per_meter > 0:
            raise ValueError(f"newtons_per_meter must be > 0, not {newtons_per_meter}")
        self._meshcat = meshcat
        self._folder = f"{prefix}/hydroelastic"
        self._scale = 1 / newtons_per_meter
        body_of = model.geometry_bodies
        # Of each pair: the two bodies, in their order in the model, and the sign of the force.
        sides = [(body_of[pair.a], body_of[pair.b]) for pair in model.pairs]
        self._names = {
            (a, b): "+".join(model.bodies[row].replace("::", ".") for row in (a, b))
            for a, b in {(min(ab), max(ab)) for ab in sides}
        }
        self._key = [(min(ab), max(ab)) for ab in sides]
        self._sign = np.array([1.0 if a > b else -1.0 for a, b in sides])
        self._drawn: set[str] = set()
        self._contacts = self.DeclareAbstractInputPort("contacts", Value[object]())
        self.DeclareInitializationPublishEvent(publish=self._clear)
        self.DeclarePeriodicPublishEvent(publish_period, 0.0, self._draw)

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder,
        contact: NonlinearDamperContact,
        meshcat: Meshcat,
        *,
        publish_period: float = 1 / 32,
        prefix: str = "contact_forces",
        newtons_per_meter: float = 100.0,
    ) -> ContactForceVisualizer:
        """Add a visualizer of `contact` to the builder, connected; see the class."""
        visualizer = ContactForceVisualizer(
            contact.model,
            meshcat,
            publish_period=publish_period,
            prefix=prefix,
            newtons_per_meter=newtons_per_meter,
        )
        builder.AddNamedSystem(f"contact_force_visualizer({prefix})", visualizer)
        builder.Connect(contact.get_contacts_output_port(), visualizer.get_contacts_input_port())
        return visualizer

    def get_contacts_input_port(self) -> InputPort:
        """Return the port for a `contact_toolkit.ContactArrays`."""
        return self._contacts

    def _clear(self, context: Context) -> None:  # noqa: ARG002  the signature is Drake's
        self._meshcat.Delete(self._folder)
        self._drawn.clear()

    def _draw(self, context: Context) -> None:
        time = context.get_time()
        arrows = self._arrows(self._contacts.Eval(context))
        for name in self._drawn - arrows.keys():
            self._meshcat.SetProperty(f"{self._folder}/{name}", "visible", False, time)
        for name, (point, force) in arrows.items():
            path = f"{self._folder}/{name}"
            if name not in self._drawn:
                self._make(path)
                self._drawn.add(name)
            length = self._scale * float(np.linalg.norm(force))
            along = RotationMatrix.MakeFromOneVector(force, 2)
            self._meshcat.SetProperty(path, "visible", True, time)
            self._meshcat.SetTransform(path, RigidTransform(along, point), time)
            self._meshcat.SetProperty(f"{path}/shaft", "scale", [1, 1, length], time)
            self._meshcat.SetTransform(f"{path}/head", RigidTransform([0, 0, length + _HEAD]), time)

    def _make(self, path: str) -> None:
        self._meshcat.SetObject(f"{path}/shaft/unit", Cylinder(_RADIUS, 1.0), _COLOR)
        self._meshcat.SetTransform(f"{path}/shaft/unit", RigidTransform([0, 0, 0.5]))
        self._meshcat.SetObject(f"{path}/head/cone", MeshcatCone(2 * _HEAD, _HEAD, _HEAD), _COLOR)
        turned = RigidTransform(RotationMatrix.MakeXRotation(np.pi), [0, 0, _HEAD])
        self._meshcat.SetTransform(f"{path}/head/cone", turned)

    def _arrows(
        self, contacts: ContactArrays
    ) -> dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]:
        """Return point and force of each two bodies that push each other, by name."""
        forces = self._sign[contacts.pair][:, None] * (
            contacts.normal_force[:, None] * contacts.normal_F + contacts.friction_force_F
        )
        rows_of: dict[tuple[int, int], list[NDArray[np.intp]]] = {}
        for pair in np.unique(contacts.pair):
            rows_of.setdefault(self._key[pair], []).append(np.flatnonzero(contacts.pair == pair))
        arrows = {}
        for key, parts in rows_of.items():
            rows = np.concatenate(parts)
            force = forces[rows].sum(axis=0)
            load = np.abs(contacts.normal_force[rows])
            if np.linalg.norm(force) > _LEAST and load.sum() > 0:
                point = load @ contacts.p_FC[rows] / load.sum()
                arrows[self._names[key]] = point, force
        return arrows
