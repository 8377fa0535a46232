"""Parts made by our own code, each a function of its dimensions returning (vertices, faces).

All are closed, wound outward, in metres: float64 (n, 3) and int32 (m, 3). Impossible dimensions
raise ValueError. `make_part` and `PARTS` name them for scenario files.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from scenarios.parts.bodies import spinning_top, tracked_robot, voussoir
from scenarios.parts.fits import hole_plate, peg, taper_plug, taper_socket, v_groove, wedge
from scenarios.parts.gear import involute_gear
from scenarios.parts.obj_file import write_obj
from scenarios.parts.solids import box, capsule, doughnut, l_bracket, rod, truncated_cone
from scenarios.parts.spheres import bumpy_sphere, icosphere
from scenarios.parts.surface import Surface
from scenarios.parts.terrain import boulder_field, height_field, rock, stairs
from scenarios.parts.thread import bolt, nut
from scenarios.parts.vessels import bowl_feeder, collet, mug

PARTS: Mapping[str, Callable[..., Surface]] = MappingProxyType(
    {
        generator.__name__: generator
        for generator in (
            bolt,
            spinning_top,
            tracked_robot,
            voussoir,
            boulder_field,
            height_field,
            rock,
            stairs,
            bowl_feeder,
            collet,
            mug,
            box,
            bumpy_sphere,
            capsule,
            doughnut,
            hole_plate,
            icosphere,
            involute_gear,
            l_bracket,
            nut,
            peg,
            rod,
            taper_plug,
            taper_socket,
            truncated_cone,
            v_groove,
            wedge,
        )
    }
)


def make_part(name: str, parameters: Mapping[str, Any] | None = None) -> Surface:
    """Return the surface of the part `name` of PARTS; raise ValueError if it cannot be made."""
    if name not in PARTS:
        raise ValueError(f"no part is called '{name}'; there are: {', '.join(PARTS)}")
    generator, given = PARTS[name], dict(parameters or {})
    known = inspect.signature(generator).parameters
    if unknown := sorted(set(given) - set(known)):
        raise ValueError(
            f"part '{name}' has no parameter {', '.join(unknown)}; it has: {', '.join(known)}"
        )
    for key, value in given.items():
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise ValueError(  # noqa: TRY004  ValueError is what the docstring promises
                f"part '{name}': {key} must be a number, not {value!r}"
            )
        if not math.isfinite(value):
            raise ValueError(f"part '{name}': {key} must be finite, not {value}")
        if isinstance(known[key].default, int):
            if value != int(value):
                raise ValueError(f"part '{name}': {key} must be a whole number, not {value}")
            given[key] = int(value)
    try:
        return generator(**given)
    except ValueError as error:
        raise ValueError(f"part '{name}': {error}") from error


__all__ = [
    "PARTS",
    "Surface",
    "bolt",
    "boulder_field",
    "bowl_feeder",
    "box",
    "bumpy_sphere",
    "capsule",
    "collet",
    "doughnut",
    "height_field",
    "hole_plate",
    "icosphere",
    "involute_gear",
    "l_bracket",
    "make_part",
    "mug",
    "nut",
    "peg",
    "rock",
    "rod",
    "spinning_top",
    "stairs",
    "taper_plug",
    "taper_socket",
    "tracked_robot",
    "truncated_cone",
    "v_groove",
    "voussoir",
    "wedge",
    "write_obj",
]
