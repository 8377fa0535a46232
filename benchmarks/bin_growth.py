"""Parts of a thousand facets poured into a bin: who keeps them apart, and what more parts cost.

`python -m benchmarks.bin_growth --out benchmarks/BIN.md`, on a quiet machine: some ten minutes.
The first parts of the scenario `part_bin_hundred`, of more facets, under the engines of `compare`.
"""

from __future__ import annotations

import argparse
import itertools
import multiprocessing
import resource
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import trimesh

from contact_toolkit import CollisionMesh, distance
from scenarios.compare.compare import engines
from scenarios.compare.outcome import Outcome
from scenarios.compare.placements import body_names, placements
from scenarios.format.loading import RawScenario, find
from scenarios.format.models import surface_of
from scenarios.format.scenario import Scenario
from scenarios.parts import l_bracket, write_obj

COUNTS = (12, 25, 50, 100)
STEP = 0.002  # [s]
ENGINES = ("ours, implicit", "Drake hydroelastic", "MuJoCo")
LIMIT = 400  # [s] of processor time for an engine
TOUCHING = 1e-4  # [m] surfaces nearer than this touch
LOOKS = 10  # at the poses of a run
HALVINGS = 3  # of a bracket's facets
FEWEST_FACETS = 1000

HEADING = f"""# Parts in a bin

Made by `python -m benchmarks.bin_growth --out benchmarks/BIN.md`. The first parts of the scenario
`part_bin_hundred`, brackets and sleeves of at least {FEWEST_FACETS} facets each, in its bin, at
steps of {1e3 * STEP:g} ms for 2 s: under our contact, solved with the step, Drake's hydroelastic
one (which sees their convex hulls), and MuJoCo's on CoACD's convex pieces. Touching pairs: of
bodies nearer than {1e3 * TOUCHING:g} mm, on average over the run. Lost: outside the bin. Overlap:
how deep any is in another at the end. Speed and kinetic energy: at the end. A run that takes more
than {LIMIT} s of a core with set-up and judging is ended.

"""
COLUMNS = (
    "parts", "contact", "touching pairs", "a step [ms]", "× real time", "lost",
    "overlap [mm]", "speed [mm/s]", "kinetic energy [µJ]", "verdict",
)  # fmt: skip


@dataclass(frozen=True)
class Result:
    outcome: Outcome
    touching: float

    @property
    def step_time(self) -> float:
        """Of a simulated step [s]."""
        return STEP / self.outcome.real_time_factor


def bin_with(parts: int, folder: Path) -> tuple[RawScenario, tuple[str, ...]]:
    """Return the scenario of a hundred parts, and what makes it one of fewer with more facets."""
    found = find("part_bin_hundred")
    vertices, faces = l_bracket(**found.raw["parts"]["bracket"]["parameters"])
    fine = trimesh.Trimesh(vertices, faces)
    for _ in range(HALVINGS):
        fine = fine.subdivide()
    path = write_obj(folder / "bracket.obj", (fine.vertices, fine.faces))
    bodies = [d for d in found.raw["directives"] if "default_free_body_pose" in str(d)]
    kept = [d for d in found.raw["directives"] if d not in bodies[parts:]]
    raw = found.raw | {"directives": kept}
    return RawScenario(found.name, raw, found.path), (
        f"plant_config={{time_step: {STEP}}}",
        "parts.sleeve.parameters.sections=24",
        "parts.sleeve.parameters.rings=18",
        "parts.bracket.generator=''",
        "parts.bracket.parameters={}",
        f"parts.bracket.mesh={path}",
        f"acceptance.limits.parts.near={parts}",
    )


def touching_pairs(scenario: Scenario, outcome: Outcome) -> float:
    """Return how many pairs of bodies touch, on average over a run."""
    placed = placements(scenario)
    names = body_names(placed)
    of_part = {name: CollisionMesh(*surface_of(part)) for name, part in scenario.parts.items()}
    meshes = [of_part[placement.part] for placement in placed.values()]
    rows = np.linspace(0, len(next(iter(outcome.poses.values()))) - 1, LOOKS + 1)[1:]
    count = 0
    for row in rows.astype(int):
        X_WB = [
            outcome.poses[names[model]][row] if names[model] in outcome.poses else each.X_WB
            for model, each in placed.items()
        ]
        moves = [names[model] in outcome.poses for model in placed]
        for i, j in itertools.combinations(range(len(meshes)), 2):
            apart = np.linalg.norm(X_WB[i][:3, 3] - X_WB[j][:3, 3])
            if (moves[i] or moves[j]) and apart < meshes[i].diagonal + meshes[j].diagonal:
                X_AB = np.linalg.inv(X_WB[i]) @ X_WB[j]
                near = distance(meshes[i], meshes[j], X_AB, upper_bound=TOUCHING)
                count += near.distance < TOUCHING
    return count / len(rows)


def simulate(engine: str, raw: RawScenario, overrides: Sequence[str]) -> Result:
    scenario = raw.load(overrides)
    for name in ("bracket", "sleeve"):
        assert len(surface_of(scenario.parts[name])[1]) >= FEWEST_FACETS
    outcome = engines()[engine](scenario)
    return Result(outcome, touching_pairs(scenario, outcome))


def _limit(seconds: int) -> None:
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))


def within_limit(
    limit: int, engine: str, raw: RawScenario, overrides: Sequence[str]
) -> Result | str:
    """Simulate in a process of its own, and return why there is no result if there is none."""
    context = multiprocessing.get_context("spawn")
    before = _taken()
    try:
        with ProcessPoolExecutor(1, context, initializer=_limit, initargs=(limit,)) as pool:
            return pool.submit(simulate, engine, raw, overrides).result()
    except BrokenProcessPool:
        return f"not done in {limit} s" if _taken() - before > 0.9 * limit else "its process died"
    except Exception as error:  # noqa: BLE001  what an engine cannot do is a result
        return str(error).partition("\n")[0]


def _taken() -> float:
    """Return the processor time of processes that have ended [s]."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def line(parts: int, engine: str, result: Result) -> str:
    outcome = result.outcome
    assert outcome.record is not None
    figures = outcome.figures
    cells = (
        str(parts), engine, f"{result.touching:.0f}", f"{1e3 * result.step_time:.3g}",
        f"{outcome.real_time_factor:.2g}", f"{figures['parts lost']:.0f}",
        f"{figures['deepest overlap [mm]']:.2g}",
        f"{figures['largest speed at the end [mm/s]']:.2g}",
        f"{1e6 * outcome.record['kinetic_energy'][-1]:.2g}", outcome.verdict,
    )  # fmt: skip
    return f"| {' | '.join(cells)} |"


def growth(engine: str, results: Sequence[Result]) -> str:
    """Say how the time of a step grows with the pairs that touch, by a line through all."""
    pairs = np.array([result.touching for result in results])
    times = np.array([1e3 * result.step_time for result in results])
    slope, start = np.polyfit(pairs, times, 1)
    left = times - (start + slope * pairs)
    sure = 1 - left @ left / np.square(times - times.mean()).sum()
    power = np.polyfit(np.log(pairs), np.log(times), 1)[0]
    return (
        f"{engine}: a step takes {start:.2g} ms + {slope:.2g} ms × touching pairs (R² = "
        f"{sure:.3f}); as a power of the pairs, it grows by {power:.2f}.  "
    )


def lines(counts: Sequence[int], limit: int) -> Iterator[str]:
    yield f"| {' | '.join(COLUMNS)} |"
    yield "|" + "---|" * len(COLUMNS)
    done: dict[str, list[Result]] = {engine: [] for engine in ENGINES if engine in engines()}
    with TemporaryDirectory() as folder:
        for parts, engine in itertools.product(counts, done):
            raw, overrides = bin_with(parts, Path(folder))
            result = within_limit(limit, engine, raw, overrides)
            if isinstance(result, str):
                nothing = " | –" * (len(COLUMNS) - 3)
                yield f"| {parts} | {engine}{nothing} | {result} |"
                continue
            done[engine].append(result)
            yield line(parts, engine, result)
    yield ""
    yield from (growth(engine, results) for engine, results in done.items() if len(results) > 2)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--parts", type=int, nargs="+", default=COUNTS, help="how many")
    parser.add_argument("--limit", type=int, default=LIMIT, help="[s] of a core for each engine")
    parser.add_argument("--out", type=Path, help="Markdown file to write the table to")
    options = parser.parse_args()
    table = []
    for each in lines(options.parts, options.limit):
        print(each, flush=True)
        table.append(each)
    if options.out:
        options.out.write_text(HEADING + "\n".join(table) + "\n")


if __name__ == "__main__":
    main()
