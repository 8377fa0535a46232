"""What a finished run is judged by: functions from a run to named figures.

Each returns a mapping of names, with their units, to numbers; the acceptance of a scenario names
the function and puts limits on some of its figures.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Context

from scenarios.brute_force_web import FacetWeb, equilibrium_height, facet_web
from scenarios.errors import ScenarioError
from scenarios.parts import make_part
from scenarios.record import Record
from scenarios.scenario import Part, Scenario

Figures = dict[str, float]

BOUNCE = 0.001  # [m] a smaller rise after a low point is settling, not a bounce


@dataclass(frozen=True)
class Run:
    """A finished run: what was asked, what was recorded, and the plant in its end state."""

    scenario: Scenario
    record: Record
    plant: MultibodyPlant
    plant_context: Context

    @property
    def body(self) -> str:
        """The body that the acceptance looks at."""
        return self.scenario.acceptance.body

    @property
    def weight(self) -> float:
        """Its weight [N]."""
        body = self.plant.GetBodyByName(self.body)
        gravity = np.linalg.norm(self.plant.gravity_field().gravity_vector())
        return float(body.get_mass(self.plant_context) * gravity)

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """Return a column of the record; `.name` is that of the body looked at."""
        return self.record[self.body + name if name.startswith(".") else name]


def stack(run: Run) -> Figures:
    """Figures of a body come to rest on a fixed one, both parts of the scenario.

    The expected height is found outside the simulator: the root of vertical spring force minus
    weight, from a brute-force web at the final tilt, yaw and offset.
    """
    last = run.record.last(run.scenario.acceptance.window)
    z, spin = run[".z"][last], run[".wz"][last]
    springs, facet_pairs = run["springs"][-1], run["facet_pairs"][-1]
    expected = _height_at_rest(run)
    return {
        "height [mm]": 1e3 * z.mean(),
        "expected height [mm]": 1e3 * expected,
        "height error [mm]": 1e3 * (z.mean() - expected),
        "jitter [mm rms]": 1e3 * z.std(),
        "g-force": float(run[".g_force"][last].mean()),
        "spin [rad/s]": float(np.abs(spin).max()),
        "tilt [deg]": float(np.rad2deg(run[".tilt"][last].max())),
        "bounces": count_bounces(run[".z"], BOUNCE),
        "springs": springs,
        "facet pairs": facet_pairs,
        "merged duplicates": facet_pairs - springs,
    }


def energy(run: Run) -> Figures:
    """Drift of the energy of an undamped run, as a share of what it has above the rest state.

    The rest state: the springs carry the weight, on the axis, upright.
    """
    total = run["kinetic_energy"] + run["gravitational_energy"] + run["elastic_energy"]
    web_at, k, standoff = _web_of_height(run, np.eye(3), np.zeros(2))
    rest = equilibrium_height(web_at, run.weight, k, standoff, start=run[".z"][0])
    at_rest = run.weight * rest + web_at(rest).energy(k, standoff)
    swing = total[0] - at_rest
    return {
        "start energy above rest [J]": float(swing),
        "energy drift [%]": float(100 * np.abs(total - total[0]).max() / swing),
        "bounces": count_bounces(run[".z"], BOUNCE),
        "springs": run["springs"].max(),
        "facet pairs": run["facet_pairs"].max(),
    }


MEASURES: Mapping[str, Callable[[Run], Figures]] = MappingProxyType(
    {function.__name__: function for function in (stack, energy)}
)


def count_bounces(height: NDArray[np.float64], rise: float) -> int:
    """Count the low points of a height (n,) [m] that are followed by a rise of at least `rise`."""
    bounces, falling, turn = 0, True, height[0]
    for z in height:
        turn = min(turn, z) if falling else max(turn, z)
        if abs(z - turn) >= rise:
            bounces += falling
            falling, turn = not falling, z
    return bounces


def _height_at_rest(run: Run) -> float:
    X_WB = run.plant.EvalBodyPoseInWorld(run.plant_context, run.plant.GetBodyByName(run.body))
    p_WB = X_WB.translation()
    web_at, k, standoff = _web_of_height(run, X_WB.rotation().matrix(), p_WB[:2])
    return equilibrium_height(web_at, run.weight, k, standoff, start=p_WB[2])


def _web_of_height(
    run: Run, R_WB: NDArray[np.float64], offset: NDArray[np.float64]
) -> tuple[Callable[[float], FacetWeb], float, float]:
    """Return the web of the body as a function of its height, the spring constant, the standoff."""
    contact, parts = run.scenario.contact, run.scenario.parts
    k, standoff = contact.k, contact.standoff
    if contact.web != "facet" or k is None or standoff is None:
        raise ScenarioError("the measure needs a facet web with k and standoff given")
    others = [name for name in parts if name != run.body]
    if run.body not in parts or len(others) != 1:
        raise ScenarioError(f"the measure needs two parts, one called '{run.body}'")
    body, fixed = _triangles(parts[run.body]), _triangles(parts[others[0]])
    unit = contact.weighting == "unit"

    def web_at(z: float) -> FacetWeb:
        web = facet_web(body @ R_WB.T + [*offset, z], fixed, standoff)
        return web.merged() if unit else web

    return web_at, k, standoff


def _triangles(part: Part) -> NDArray[np.float64]:
    vertices, faces = make_part(part.generator, part.parameters)
    return vertices[faces]
