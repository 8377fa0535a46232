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

from contact_toolkit import CollisionMesh, NonlinearDamper, intersects
from scenarios.format.errors import ScenarioError
from scenarios.format.models import surface_of
from scenarios.format.scenario import Scenario
from scenarios.judge import heap
from scenarios.judge.brute_force_web import FacetWeb, equilibrium_height, facet_web
from scenarios.simulation.record import Record

Figures = dict[str, float]

GRAVITY = 9.81  # [m/s²]
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


@dataclass(frozen=True)
class Measure:
    """A function from a run to figures, and the names of these, known before any run."""

    function: Callable[[Run], Figures]
    figures: tuple[str, ...]
    needs_body: bool

    def __call__(self, run: Run) -> Figures:
        """Return the figures of a run; raise ValueError where there are none, and why."""
        figures = self.function(run)
        assert set(figures) == set(self.figures), f"{set(figures) ^ set(self.figures)}"
        return figures


def stack(run: Run) -> Figures:
    """Figures of a body come to rest on a fixed one, both parts of the scenario.

    The expected height is found outside the simulator: the root of vertical spring force minus
    weight, from a brute-force web at the final tilt, yaw and offset.
    """
    last = run.record.last(run.scenario.acceptance.window)
    z = run[".z"][last]
    springs, facet_pairs = run["springs"][-1], run["facet_pairs"][-1]
    expected = _height_at_rest(run)
    return rest(run.record, run.body, run.scenario.acceptance.window) | {
        "expected height [mm]": 1e3 * expected,
        "height error [mm]": 1e3 * (z.mean() - expected),
        "g-force": float(run[".g_force"][last].mean()),
        "springs": springs,
        "facet pairs": facet_pairs,
        "merged duplicates": facet_pairs - springs,
    }


def rest(record: Record, body: str, window: float) -> Figures:
    """Figures of a body come to rest that its motion alone tells."""
    last = record.last(window)
    z = record[f"{body}.z"]
    return {
        "height [mm]": float(1e3 * z[last].mean()),
        "jitter [mm rms]": float(1e3 * z[last].std()),
        "spin [rad/s]": float(np.abs(record[f"{body}.wz"][last]).max()),
        "tilt [deg]": float(np.rad2deg(record[f"{body}.tilt"][last].max())),
        "bounces": count_bounces(z, BOUNCE),
    }


def energy(run: Run) -> Figures:
    """Drift of the energy of an undamped run, as a fraction of what it has above the rest state.

    The rest state: the springs carry the weight, on the axis, upright.
    """
    total = run["kinetic_energy"] + run["gravitational_energy"] + run["elastic_energy"]
    rest, web, law = _rest_of(run, np.eye(3), np.array([0.0, 0.0, run[".z"][0]]))
    at_rest = run.weight * rest + web.energy(**law)
    swing = total[0] - at_rest
    return {
        "start energy above rest [J]": float(swing),
        "energy drift [%]": float(100 * np.abs(total - total[0]).max() / swing),
        "bounces": count_bounces(run[".z"], BOUNCE),
        "springs": run["springs"].max(),
        "facet pairs": run["facet_pairs"].max(),
    }


def bouncing(run: Run) -> Figures:
    """Speeds of a body that bounces, against the closed form of its law for each impact.

    v_{j+1} = e(D_j) v_j with D = 3/2 α v_j; an impact is the time while springs are loaded.
    """
    alpha = run.scenario.contact.alpha
    if alpha is None:
        raise ScenarioError("the measure 'bouncing' needs contact.alpha given")
    loaded = run["springs"] > 0.0
    edges = np.flatnonzero(np.diff(loaded.astype(int)))
    starts = edges[~loaded[edges]]
    law = NonlinearDamper(k=1.0, alpha=alpha)
    errors = []
    for start in starts:
        after = edges[edges > start]
        if not len(after):
            break
        down, up = -run[".vz"][start], run[".vz"][after[0] + 1]
        fall = run["time"][start + 1] - run["time"][start]
        if down > 20 * GRAVITY * fall:  # what a row of the record may be off by
            errors.append(abs(up / (law.restitution(down) * down) - 1.0))
    return {
        "bounces": float(len(errors)),
        "largest error of a bounce [%]": 100.0 * max(errors, default=float("nan")),
        "energy not accounted for [%]": _unaccounted(run),
    }


def bodies(run: Run) -> Figures:
    """How far all moving bodies have gone since the start, and what they do at the end."""
    return moved(run.record, run.scenario.acceptance.window) | {
        "energy not accounted for [%]": _unaccounted(run),
        "springs": float(run["springs"][-1]),
    }


def moved(record: Record, window: float) -> Figures:
    """Figures of `bodies` that their motion alone tells."""
    names = [name.removesuffix(".z") for name in record.columns if name.endswith(".z")]
    last = record.last(window)
    moves, turns, speeds, heights = [], [], [], []
    for name in names:
        p, v = (
            np.stack([record[f"{name}.{c}"] for c in columns])
            for columns in ("xyz", ("vx", "vy", "vz"))
        )
        moves.append(np.linalg.norm(p[:, -1] - p[:, 0]))
        turn = [record[f"{name}.{angle}"] for angle in ("tilt", "yaw")]
        turns.append(max(abs(angle[-1] - angle[0]) for angle in turn))
        speeds.append(np.linalg.norm(v[:, last], axis=0).max())
        heights.append(p[2, -1])
    return {
        "bodies": float(len(names)),
        "largest move [mm]": 1e3 * float(max(moves)),
        "largest turn [deg]": float(np.rad2deg(max(turns))),
        "largest speed at the end [m/s]": float(max(speeds)),
        "lowest at the end [m]": float(min(heights)),
    }


def _unaccounted(run: Run) -> float:
    """Largest change of kinetic + potential + stored + lost energy, of that exchanged [%]."""
    mechanical = run["kinetic_energy"] + run["gravitational_energy"]
    lost = run["damping_loss"] + run["friction_loss"] + run["step_loss"]
    total = mechanical + run["elastic_energy"] + lost
    exchanged = max(np.ptp(run["gravitational_energy"]), np.ptp(run["kinetic_energy"]), 1e-12)
    return float(100.0 * np.abs(total - total[0]).max() / exchanged)


MEASURES: Mapping[str, Measure] = MappingProxyType(
    {
        "stack": Measure(
            stack,
            (
                "height [mm]",
                "expected height [mm]",
                "height error [mm]",
                "jitter [mm rms]",
                "g-force",
                "spin [rad/s]",
                "tilt [deg]",
                "bounces",
                "springs",
                "facet pairs",
                "merged duplicates",
            ),
            needs_body=True,
        ),
        "energy": Measure(
            energy,
            (
                "start energy above rest [J]",
                "energy drift [%]",
                "bounces",
                "springs",
                "facet pairs",
            ),
            needs_body=True,
        ),
        "bouncing": Measure(
            bouncing,
            ("bounces", "largest error of a bounce [%]", "energy not accounted for [%]"),
            needs_body=True,
        ),
        "bodies": Measure(
            bodies,
            (
                "bodies",
                "largest move [mm]",
                "largest turn [deg]",
                "largest speed at the end [m/s]",
                "lowest at the end [m]",
                "energy not accounted for [%]",
                "springs",
            ),
            needs_body=False,
        ),
        "heap": Measure(heap.heap, heap.FIGURES, needs_body=False),
    }
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
    return _rest_of(run, X_WB.rotation().matrix(), X_WB.translation())[0]


def _rest_of(
    run: Run, R_WB: NDArray[np.float64], start: NDArray[np.float64]
) -> tuple[float, FacetWeb, dict[str, float]]:
    """Return the height at which the web carries the body, the web there, and its springs' law.

    Raises ValueError if there is none, or none without the surfaces crossing, where a web means
    nothing.
    """
    contact, parts = run.scenario.contact, run.scenario.parts
    k, standoff = contact.k, contact.standoff
    if contact.web != "facet" or k is None or standoff is None:
        raise ScenarioError("the measure needs a facet web with k and standoff given")
    others = [name for name in parts if name != run.body]
    if run.body not in parts or len(others) != 1:
        raise ScenarioError(f"the measure needs two parts, one called '{run.body}'")
    body, fixed = surface_of(parts[run.body]), surface_of(parts[others[0]])
    law = {"k": k, "standoff": standoff, "n": 1.0 if contact.n is None else contact.n}

    def web_at(z: float) -> FacetWeb:
        moved = body[0] @ R_WB.T + [*start[:2], z]
        web = facet_web(moved[body[1]], fixed[0][fixed[1]], standoff)
        return web.merged() if contact.weighting == "unit" else web

    height = equilibrium_height(web_at, run.weight, start=start[2], **law)
    X_WB = np.block([[R_WB, np.reshape([*start[:2], height], (3, 1))], [0, 0, 0, 1]])
    if intersects(CollisionMesh(*fixed), CollisionMesh(*body), X_WB):
        raise ValueError(f"no equilibrium: the springs would carry it at {height:.4g} m, crossing")
    return height, web_at(height), law
