"""Meetings of two bodies where numbers are extreme."""

from dataclasses import dataclass

from scenarios import parts

SIDE = 0.1  # [m]
FAR = 1e4  # [m]
LOOSE = 1e-5  # share of the energy by which the integration may be off


@dataclass(frozen=True)
class Meeting:
    """A block at rest, and what comes to it, or starts in it.

    Attributes
    ----------
    p
        Where it starts, from the block [m].
    v
        Its velocity [m/s].
    duration
        [s].
    max_step
        [s].
    k
        Foundation stiffness [Pa/m].
    density
        Of the comer [kg/m³]; the block has 1000.
    part
        The comer's shape.
    turn
        How the comer is turned, about an oblique axis [rad].
    origin
        Where the block is, on every axis [m].
    """

    p: tuple[float, float, float]
    v: tuple[float, float, float] = (0.0, 0.0, 0.0)
    duration: float = 0.02
    max_step: float = 5e-4
    k: float = 1e9
    density: float = 1e3
    part: str = "box"
    turn: float = 0.0
    origin: float = 0.0


TOUCHING = (0.01, 0.02, SIDE + 1e-3)
FALLING = (0.0, 0.0, -1.0)

MEETINGS = {
    "stiffness 1e12": Meeting(TOUCHING, FALLING, duration=3e-3, max_step=2e-5, k=1e12),
    "stiffness 1": Meeting(TOUCHING, FALLING, duration=0.3, max_step=5e-3, k=1.0),
    "mass ratio 1e6": Meeting(TOUCHING, FALLING, density=1e-3, duration=3e-3, max_step=2e-5),
    "mass ratio 1e-6": Meeting(TOUCHING, FALLING, density=1e9),
    "overlapped": Meeting((0.01, 0.02, SIDE - 2e-3)),
    "overlapped at a corner": Meeting((0.09, 0.095, 0.093)),
    "coincident": Meeting((0.0, 0.0, 0.0)),
    "nearly coincident": Meeting((1e-9, 0.0, 0.0), turn=1e-9),
    "one inside the other": Meeting((0.012, 0.005, 0.02), part="ball", k=1e7, duration=5e-3),
    "concentric": Meeting((0.0, 0.0, 0.0), part="ball", k=1e7, duration=5e-3),
    "far from the origin": Meeting(TOUCHING, FALLING, origin=FAR),
    "1 km/s": Meeting(
        (0.01, 0.02, SIDE + 0.01), (0, 0, -1e3), duration=1e-4, max_step=1e-6, k=1e12
    ),
}

PARTS = {
    "box": parts.box(SIDE, SIDE, SIDE),
    "ball": parts.icosphere(0.02, frequency=4),
}
