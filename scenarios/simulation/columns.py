"""What a run records, in which units, and which of the diagram's logs it is read from."""

from __future__ import annotations

from collections.abc import Collection

_MOTION = {
    **dict.fromkeys(("x", "y", "z"), "m"),
    **dict.fromkeys(("tilt", "yaw"), "rad"),
    **dict.fromkeys(("wx", "wy", "wz"), "rad/s"),
    **dict.fromkeys(("vx", "vy", "vz"), "m/s"),
}
_WRENCH = {**dict.fromkeys(("tx", "ty", "tz"), "N m"), **dict.fromkeys(("fx", "fy", "fz"), "N")}
BODY_UNITS = _MOTION | _WRENCH
"""Of each moving body; with a weight also `g_force`."""

COUNTS = {"springs": "1", "facet_pairs": "1"}
ENERGIES = dict.fromkeys(("elastic_energy", "damping_loss", "friction_loss", "step_loss"), "J")
MECHANICS = dict.fromkeys(("kinetic_energy", "gravitational_energy"), "J")
UNITS = {"time": "s"} | COUNTS | ENERGIES | MECHANICS
"""Of all bodies together."""

_LOGS: dict[str, Collection[str]] = {
    "wrenches": {*_WRENCH, "g_force"},
    "energies": ENERGIES,
    "counts": COUNTS,
    "passes": {"passes"},
}


def motion_units() -> dict[str, str]:
    """Return what is recorded of a body's motion, in order, and its units."""
    return dict(_MOTION)


def logs_behind(columns: Collection[str] | None) -> set[str]:
    """Return the names of the logs that columns are read from; None stands for all columns."""
    if columns is None:
        return {"state", *_LOGS}
    quantities = {column.rpartition(".")[2] for column in columns}
    return {"state"} | {log for log, held in _LOGS.items() if not quantities.isdisjoint(held)}


def bodies_in(columns: Collection[str]) -> set[str]:
    """Return the names of the bodies that columns are of."""
    return {column.rpartition(".")[0] for column in columns} - {""}
