"""WitnessPairVisualizer: draws springs and forces in Meshcat, live and in recordings."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import Value
from pydrake.geometry import Meshcat, Rgba
from pydrake.systems.framework import Context, DiagramBuilder, InputPort, LeafSystem

from contact_toolkit import ContactArrays
from systems.nonlinear_damper_contact import NonlinearDamperContact

_WEB_COLOR = Rgba(0.1, 0.35, 0.9, 1.0)
_FORCE_COLOR = Rgba(0.85, 0.1, 0.1, 1.0)
_HEAD = 0.2  # length of an arrow's head, relative to the arrow


class WitnessPairVisualizer(LeafSystem):
    """Draws a line between the witness points of each loaded spring, and an arrow for its force.

    Meshcat records motions and properties of objects, never their shapes. So when recording, each
    published frame becomes an object of its own that is visible from its frame to the next.

    Parameters
    ----------
    meshcat
        Where to draw.
    publish_period
        Time between frames [s]. A recording at the same rate shows every frame.
    path
        Folder in Meshcat's tree that holds the drawing.
    force_scale
        Length of the arrows [m/N]; zero draws none. An arrow shows the force on the first body of
        the pair, at the spring.
    record
        Keep every frame for playback; otherwise only the present is drawn.

    Examples
    --------
    >>> from pydrake.geometry import Meshcat, MeshcatParams
    >>> from pydrake.multibody.parsing import Parser
    >>> from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    >>> from pydrake.systems.analysis import Simulator
    >>> from pydrake.systems.framework import DiagramBuilder
    >>> from systems import AddNonlinearDamperContact, WitnessPairVisualizer
    >>> MODEL = '''<mujoco model="fall"><worldbody><geom type="plane" size="1 1 1"/>
    ...   <body name="ball" pos="0 0 0.05"><freejoint/><geom size="0.05"/></body>
    ... </worldbody></mujoco>'''
    >>> builder = DiagramBuilder()
    >>> plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.002)
    >>> _ = Parser(plant).AddModelsFromString(MODEL, "xml")
    >>> plant.Finalize()
    >>> contact = AddNonlinearDamperContact(builder, plant, scene_graph)
    >>> meshcat = Meshcat(MeshcatParams(host="localhost"))
    >>> _ = WitnessPairVisualizer.AddToBuilder(builder, contact, meshcat)
    >>> simulator = Simulator(builder.Build())
    >>> _ = simulator.AdvanceTo(0.1)
    >>> meshcat.HasPath("contact")
    True
    """

    def __init__(
        self,
        meshcat: Meshcat,
        *,
        publish_period: float = 1 / 32,
        path: str = "contact",
        force_scale: float = 0.0,
        record: bool = True,
    ) -> None:
        super().__init__()
        if not publish_period > 0:
            raise ValueError(f"publish_period must be a time [s] > 0, not {publish_period}")
        self._meshcat = meshcat
        self._period = publish_period
        self._path = path
        self._force_scale = force_scale
        self._record = record
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
        path: str = "contact",
        force_scale: float = 0.0,
        record: bool = True,
    ) -> WitnessPairVisualizer:
        """Add a visualizer of `contact` to the builder, connected; see the class."""
        visualizer = WitnessPairVisualizer(
            meshcat,
            publish_period=publish_period,
            path=path,
            force_scale=force_scale,
            record=record,
        )
        builder.AddNamedSystem(f"witness_pair_visualizer({path})", visualizer)
        builder.Connect(contact.get_contacts_output_port(), visualizer.get_contacts_input_port())
        return visualizer

    def get_contacts_input_port(self) -> InputPort:
        """Return the port for a `contact_toolkit.ContactArrays`."""
        return self._contacts

    def _clear(self, context: Context) -> None:  # noqa: ARG002  the signature is Drake's
        self._meshcat.Delete(self._path)

    def _draw(self, context: Context) -> None:
        contacts = self._contacts_to_draw(context)
        time = context.get_time()
        if not self._record:
            self._draw_lines(f"{self._path}/now", contacts)
            return
        recording = self._meshcat.get_mutable_recording()
        frame, before = self._frame(time), self._frame(time - self._period)
        if before != frame and self._meshcat.HasPath(self._frame_path(before)):
            self._show(before, frame, visible=False)
        if len(contacts):
            self._draw_lines(self._frame_path(frame), contacts)
            # Meshcat holds the first key backwards in time as well: every object needs one at 0.
            recording.SetProperty(0, self._frame_path(frame), "visible", frame == 0)
            self._show(frame, frame, visible=True)

    def _contacts_to_draw(self, context: Context) -> ContactArrays:
        contacts: ContactArrays = self._contacts.Eval(context)
        return contacts

    def _frame(self, time: float) -> int:
        """Return the frame of the recording nearest to a time; Meshcat itself rounds down."""
        recording = self._meshcat.get_mutable_recording()
        elapsed = time - recording.start_time()
        return max(0, round(elapsed * recording.frames_per_second()))

    def _frame_path(self, frame: int) -> str:
        return f"{self._path}/{frame:06d}"

    def _show(self, drawing: int, frame: int, *, visible: bool) -> None:
        """Show or hide a drawing from `frame` on, and at once."""
        path = self._frame_path(drawing)
        self._meshcat.SetProperty(path, "visible", visible)
        self._meshcat.get_mutable_recording().SetProperty(frame, path, "visible", visible)

    def _draw_lines(self, path: str, contacts: ContactArrays) -> None:
        self._meshcat.SetLineSegments(
            f"{path}/web", contacts.p_FCa.T, contacts.p_FCb.T, rgba=_WEB_COLOR
        )
        if self._force_scale:
            start, end = _arrows(contacts, self._force_scale)
            self._meshcat.SetLineSegments(f"{path}/forces", start.T, end.T, rgba=_FORCE_COLOR)


def _arrows(
    contacts: ContactArrays, scale: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return starts and ends (3 n, 3) of lines that make an arrow a contact: shaft, two barbs."""
    force = contacts.normal_force[:, None] * contacts.normal_F + contacts.friction_force_F
    shaft = scale * force
    tip = contacts.p_FC + shaft
    # Any direction across the shaft will do; the one across z is seen from the side.
    across = np.cross(shaft, [0.0, 0.0, 1.0])
    upright = ~across.any(axis=1)
    across[upright] = np.cross(shaft[upright], [1.0, 0.0, 0.0])
    barbs = [tip + _HEAD * (side * across / 2 - shaft) for side in (-1, 1)]
    return np.vstack([contacts.p_FC, tip, tip]), np.vstack([tip, *barbs])
