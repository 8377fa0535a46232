"""Joints between the bodies of a scenario, and what drives them."""

# No `from __future__ import annotations`: the loader reads the annotations as types.
import dataclasses


@dataclasses.dataclass
class Joint:
    """A joint of one freedom between two frames, beside those that the models bring.

    Attributes
    ----------
    kind
        What it allows.
    parent, child
        Frames or bodies, as `model::frame`; the parent may be `world`.
    axis
        In the parent's frame, (3,).
    translation
        Of the joint in the parent's frame, (3,) [m].
    lower, upper
        Limits of the position [m or rad]; a continuous plant takes no notice of them.
    damping
        [N s/m or N m s/rad]
    """

    kind: str = "prismatic"
    parent: str = "world"
    child: str = ""
    axis: list[float] = dataclasses.field(default_factory=lambda: [0.0, 0.0, 1.0])
    translation: list[float] = dataclasses.field(default_factory=lambda: [0.0, 0.0, 0.0])
    lower: float = float("-inf")
    upper: float = float("inf")
    damping: float = 0.0


@dataclasses.dataclass
class Drive:
    """What drives a joint: a force, or a servo that follows a position.

    The value in time is the schedule, straight between its corners, plus
    amplitude · sin(2π frequency t + phase).

    Attributes
    ----------
    follows
        Whether the value is a force [N or N m] or a position [m or rad].
    schedule
        Corners, each a time [s] and a value.
    amplitude
        Of the oscillation, in the value's unit.
    frequency
        Of the oscillation [Hz].
    phase
        Of the oscillation [rad].
    stiffness, damping
        Gains of the servo on position [N/m or N m/rad] and velocity [N s/m or N m s/rad].
    inertia
        What the servo moves [kg or kg m²], for the force it gives ahead of any error.
    force_limit
        Largest force of the servo [N or N m].
    """

    follows: str = "force"
    schedule: list[list[float]] = dataclasses.field(default_factory=list)
    amplitude: float = 0.0
    frequency: float = 0.0
    phase: float = 0.0
    stiffness: float = 0.0
    damping: float = 0.0
    inertia: float = 0.0
    force_limit: float = float("inf")
