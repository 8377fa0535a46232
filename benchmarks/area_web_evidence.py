"""What the area web achieves, property by property, through the built engine.

Run from the root of the project: `python -m benchmarks.area_web_evidence [--rest SECONDS]`. Prints
a Markdown table beside the figures of the prototype that chose this formulation (clipped,
one-sided, smooth field). Ratios and relative errors, except the costs, which are this machine's.
"""

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import area_experiments as experiments  # shared with the tests

from scenarios import parts

FIELDS = ("exact", "smooth")
DEPTHS = np.array([0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0]) * 1e-3


def row(name: str, prototype: str, figures: Callable[[str], str]) -> None:
    cells = [figures(field) for field in FIELDS]
    print(f"| {name} | {prototype} | {' | '.join(cells)} |", flush=True)


def listed(values: object, form: str = ".4f") -> str:
    return " ".join(format(value, form) for value in values)


def jumps(field: str) -> str:
    web = experiments.doughnut_on_cone(field=field)
    path = experiments.path_over_cone
    return listed(experiments.largest_jump(web, path, n) for n in (600, 1200, 2400))


def loop(field: str) -> str:
    web = experiments.doughnut_on_cone(field=field)
    return f"{experiments.closed_loop_work(web, experiments.path_over_cone, 2000):.0e}"


def bouncing(field: str) -> str:
    # The exact field's jumps drive the step to nothing at a tight tolerance.
    smooth = {"duration": 2.5, "tolerance": 1e-8}
    exact = {"duration": 1.2, "tolerance": 1e-5, "method": "RK45"}
    web = experiments.doughnut_on_cone(32, field=field)
    options = smooth if field == "smooth" else exact
    drift, touch_downs = experiments.bouncing_drift(web, **options)
    return f"{drift:.0e} ({touch_downs} touch-downs)"


def refined_box(field: str) -> str:
    return listed((experiments.box_on_plane(d, field=field) for d in (1, 2, 4, 8)), ".1f")


def balls(field: str) -> str:
    truth = experiments.ball_on_ball(12, 0.03, field=field)
    ratios = (1.06, 0.53, 0.27, 0.13)
    return listed((experiments.ball_on_ball(12, r, field=field) / truth for r in ratios), ".3f")


def closed_form(field: str) -> str:
    return listed((experiments.ball_on_ball(96, r, field=field) for r in (0.53, 0.27, 0.13)), ".3f")


def fillet(field: str) -> str:
    r, K = 2e-3, 1e9
    box = parts.box()
    web = experiments.Web(box, box, K, resolution=0.005, fillet=r, field=field)
    errors = []
    for d in np.array([0.1, 0.25, 0.5, 1.0]) * r:
        force = np.linalg.norm(experiments.crossed_edges(web, d, 0.003, 0.002).force)
        errors.append(force / (np.pi * K * r * d**2 + 0.471 * K * d**3) - 1)
    return listed(errors, ".4f")


def ghosts(field: str) -> str:
    return f"{experiments.sideways(field=field):.0e}"


def plate(field: str) -> str:
    return listed(experiments.block_through_plate(DEPTHS, field=field), ".2f")


def overlap(field: str) -> str:
    if field == "exact":  # its jumps limit the integrator, not the energy
        return "–"
    return f"{experiments.release(1e-13, field=field):.0e}"


def cost(web: experiments.Web, pose: np.ndarray) -> str:
    count = len(web.find(pose)["key"])
    times = []
    for _ in range(60):
        start = time.perf_counter()
        web.find(pose)
        times.append(time.perf_counter() - start)
    return f"{min(times) / count * 1e9:.0f} ({count} nodes)"


def flat_cost(field: str) -> str:
    web = experiments.Web(parts.box(), parts.box(1, 1, 0.2), 1e9, resolution=0.068, field=field)
    return cost(web, experiments.pose([0.0123, 0.0077, -0.15 + 5e-5]))


def grazing_cost(field: str) -> str:
    web = experiments.doughnut_on_cone(resolution=0.01, field=field)
    return cost(web, experiments.pose([2e-4, 1e-4, -0.1663]))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rest", type=float, default=10.0, help="simulated time of the last row")
    options = parser.parse_args()
    print("| property | prototype | exact field | smooth field |\n|---|---|---|---|")
    row("P1 largest jump over largest force; path in n, 2 n, 4 n", ".0175 .0088 .0044", jumps)
    row("P2 work of a closed tour over largest energy", "-2e-7", loop)
    row("P2 doughnut bouncing on a cone, drift", "7e-6 (18–31)", bouncing)
    row("P3 12-facet box on a plane, × 1, 4, 16, 64 facets [N]", "500 (exact: 500.5)", refined_box)
    row("P3 ball on ball, node spacing 1.06 .53 .27 .13 a", ".754 .944 .987 1", balls)
    row("P3 fine balls over π K R δ², spacing .53 .27 .13 a", "–", closed_form)
    row("P4 box over an irregular slab, sideways over weight", "5e-17 (exact: 5e-13)", ghosts)
    row("P6 block in a 2 mm plate, .5 … 5 mm deep", ".41 .74 .90 1.23 2.20 …", plate)
    row("P7 fillets over their closed form − 1, d = .1 .25 .5 1 r", "within .07", fillet)
    row("release from 1 mm of overlap, kinetic over stored − 1", "-1e-11", overlap)
    row("cost of a flat contact, ns a loaded node", "97 (exact: 700–1100)", flat_cost)
    row("cost of a grazing contact, ns a loaded node", "–", grazing_cost)
    moved, weight = experiments.rocking(options.rest)
    print(
        f"| doughnut on cone after {options.rest:g} s: rocking [µm], force over weight "
        f"| 31 at 10 s, 1.000 | – | {moved * 1e6:.2g}, {weight:.4f} |"
    )


if __name__ == "__main__":
    main()
