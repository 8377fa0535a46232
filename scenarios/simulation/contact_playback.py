"""What the playback shows of contact: springs, and for each pair its normal and friction force."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import Meshcat, Rgba
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Context, DiagramBuilder

from contact_toolkit import ContactArrays
from systems import NonlinearDamperContact, WitnessPairVisualizer

_WEB = Rgba(0.1, 0.35, 0.9, 1.0)
_NORMAL = Rgba(0.85, 0.1, 0.1, 1.0)
_FRICTION = Rgba(0.1, 0.6, 0.2, 1.0)
_LEAST_SHARE = 0.02  # an arrow shorter than this share of the longest is not drawn
_LONGEST = 3.0  # an impact's arrow is cut at this multiple of that of the weight
_HEAD = 0.2  # length of an arrow's head, relative to the arrow

Floats = NDArray[np.float64]


class ContactPlayback(WitnessPairVisualizer):
    """Draws loaded springs as lines, and two arrows a pair at its centre of pressure.

    Arrows show the force on the body that moves. An impact that begins and ends between two frames
    is shown, at its strongest, by the frame after it.

    Parameters
    ----------
    plant, contact
        The plant and its contact system.
    meshcat
        Where to draw.
    publish_period
        Time between frames [s].
    arrow
        Length [m] of the arrow of `weight`, 0 for no arrows.
    weight
        Force [N] whose arrow has that length; longer than three times that no arrow gets.
    lines
        Whether to draw the springs.
    record
        Keep every frame for playback; otherwise only the present is drawn.
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        contact: NonlinearDamperContact,
        meshcat: Meshcat,
        *,
        publish_period: float,
        arrow: float,
        weight: float,
        lines: bool,
        record: bool = True,
    ) -> None:
        super().__init__(meshcat, publish_period=publish_period, record=record)
        self._arrow, self._weight, self._lines = arrow, weight, lines
        welded = {body.index() for body in plant.GetBodiesWeldedTo(plant.world_body())}
        fixed = [body in welded for body in contact.bodies]
        body_of = contact.model.geometry_bodies
        # The force on a pair's first geometry; on the second it is the opposite.
        self._sense = np.array(
            [-1.0 if fixed[body_of[pair.a]] else 1.0 for pair in contact.model.pairs]
        )
        self._strongest: ContactArrays | None = None
        self.DeclarePerStepPublishEvent(publish=self._remember)

    @staticmethod
    def add_to(
        builder: DiagramBuilder, contact: NonlinearDamperContact, drawing: ContactPlayback
    ) -> None:
        """Add and connect it."""
        builder.AddNamedSystem("contact_playback", drawing)
        builder.Connect(contact.get_contacts_output_port(), drawing.get_contacts_input_port())

    def _clear(self, context: Context) -> None:
        super()._clear(context)
        self._strongest = None

    def _remember(self, context: Context) -> None:
        contacts: ContactArrays = self._contacts.Eval(context)
        if len(contacts) and _load(contacts) > _load(self._strongest):
            self._strongest = contacts

    def _contacts_to_draw(self, context: Context) -> ContactArrays:
        now: ContactArrays = self._contacts.Eval(context)
        strongest, self._strongest = self._strongest, None
        return now if len(now) or strongest is None else strongest

    def _draw_lines(self, path: str, contacts: ContactArrays) -> None:
        if self._lines:
            self._meshcat.SetLineSegments(
                f"{path}/web", contacts.p_FCa.T, contacts.p_FCb.T, rgba=_WEB
            )
        if not self._arrow or not len(contacts):
            return
        point, normal, friction = self._pair_forces(contacts)
        scale = self._arrow / self._weight
        for name, force, colour in (("normal", normal, _NORMAL), ("friction", friction, _FRICTION)):
            start, end = arrows(point, scale * force, _LONGEST * self._arrow, self._arrow)
            if len(start):
                self._meshcat.SetLineSegments(
                    f"{path}/{name}", start.T, end.T, line_width=3.0, rgba=colour
                )

    def _pair_forces(self, contacts: ContactArrays) -> tuple[Floats, Floats, Floats]:
        """Return centre of pressure, normal and friction force of each loaded pair, (n, 3)."""
        pairs, row = np.unique(contacts.pair, return_inverse=True)
        point, normal, friction = (np.zeros((len(pairs), 3)) for _ in range(3))
        load = np.maximum(contacts.normal_force, 1e-12)[:, None]
        total = np.zeros((len(pairs), 1))
        np.add.at(total, row, load)
        np.add.at(point, row, load * contacts.p_FC)
        np.add.at(normal, row, contacts.normal_force[:, None] * contacts.normal_F)
        np.add.at(friction, row, contacts.friction_force_F)
        sense = self._sense[pairs][:, None]
        return point / total, sense * normal, sense * friction


def _load(contacts: ContactArrays | None) -> float:
    return 0.0 if contacts is None else float(contacts.normal_force.sum())


def arrows(point: Floats, shaft: Floats, longest: float, usual: float) -> tuple[Floats, Floats]:
    """Return starts and ends (3 n, 3) of lines that make an arrow each: shaft and two barbs."""
    length = np.linalg.norm(shaft, axis=1)
    shown = length > _LEAST_SHARE * usual
    point, shaft, length = point[shown], shaft[shown], length[shown]
    shaft = shaft * np.minimum(1.0, longest / np.maximum(length, 1e-300))[:, None]
    tip = point + shaft
    # Any direction across the shaft will do; the one across z is seen from the side.
    across = np.cross(shaft, [0.0, 0.0, 1.0])
    upright = np.linalg.norm(across, axis=1) < 1e-6 * np.linalg.norm(shaft, axis=1)
    across[upright] = np.cross(shaft[upright], [1.0, 0.0, 0.0])
    barbs = [tip + _HEAD * (side * across / 2 - shaft) for side in (-1, 1)]
    return np.vstack([point, tip, tip]), np.vstack([tip, *barbs])
