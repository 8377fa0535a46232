"""What the area web achieves, property by property, through the built engine.

Run from the root of the project: `python -m benchmarks.area_web_evidence [--out FILE]`. Prints a
Markdown table beside the figures of the prototype that chose this formulation (clipped, one-sided),
and writes it where asked: `benchmarks/AREA_WEB.md` is such a file. Takes some twelve minutes.
"""

import argparse
import functools
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

import area_experiments as experiments  # shared with the tests
from bouncing_doughnut import bounce
from test_validation_sliding import BoxOnIncline, foundation

from scenarios import parts

BOUNCING = 5.0  # [s], in which it touches down at least twenty times
DEPTHS = np.array([0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0]) * 1e-3

HEADING = """# The area web's properties, measured

Made by `python -m benchmarks.area_web_evidence --out benchmarks/AREA_WEB.md`; the experiments are
those of `tests/contact/test_area_web.py`. Beside the built engine stand the figures of the
prototype that chose this formulation. Forces are relative to the closed form unless
something else is said.

"""

REMARKS = """
- P1, sampled: how large the changes are says how fast the path is, and the prototype's was another.
  How they shrink does not hang on the path: where the force is continuous, a step cut in 2, 4, 16
  changes it 2, 4, 16 times less; where it jumps, 1, 1, 1. The row after says what is left at a
  point.
- P2, bouncing: fractions of m g times the first fall, over 5 s. The smooth field is integrated to
  order 8 (tolerance 1e-8, then 1e-9), the exact one by runge_kutta3 (accuracy 1e-8, then 1e-9).
  Both drifts go on shrinking with the tolerance: they are the integrator's, and the fields' own are
  smaller. Ten bounces are the property as it is stated.
- P3, balls: relative to the same facets sampled at 0.03 a.
- P4 is round-off (2⁻⁵³ = 1.1e-16), and so is a release by quadrature; that by flight is the
  integrator's, at the tightest tolerance it has.
- Costs are this machine's, on one thread. A node is looked at where its facet may be loaded.
"""

Figures = Callable[[str], str]


def listed(values: object, form: str = ".4f") -> str:
    return " ".join(format(value, form) for value in values)


@functools.cache
def largest_changes(field: str) -> tuple[float, ...]:
    """Of the force over a step, with the path in n, 2 n, 4 n and 16 n steps."""
    web = experiments.doughnut_on_cone(field=field)
    forces = experiments.forces_along(web, experiments.path_over_cone, 16 * 600)
    return tuple(experiments.largest_change(forces, stride) for stride in (16, 8, 4, 1))


def sampled(field: str) -> str:
    return listed(largest_changes(field)[:3])


def cut(field: str) -> str:
    whole, *pieces = largest_changes(field)
    return listed((whole / piece for piece in pieces), ".2f")


def jump_left(field: str) -> str:
    web = experiments.doughnut_on_cone(field=field)
    return f"{experiments.jump_left(web, experiments.path_over_cone, 600):.0e}"


def loop(field: str) -> str:
    web = experiments.doughnut_on_cone(field=field)
    return f"{experiments.closed_loop_work(web, experiments.path_over_cone, 2000):.0e}"


def counted(drift: float, touch_downs: int) -> str:
    return f"{drift:.0e} ({touch_downs})"


def bouncing(field: str, tolerance: float = 1e-8) -> str:
    """By the order of integration that suits the field: 8 for a smooth one, 3 for jumps."""
    if field == "smooth":
        web = experiments.doughnut_on_cone(32, field=field)
        return counted(*experiments.bouncing_drift(web, BOUNCING, tolerance=tolerance))
    return in_drake(field, BOUNCING, tolerance)


def bouncing_closer(field: str) -> str:
    return bouncing(field, 1e-9)


def in_drake(field: str, duration: float = 2.1, accuracy: float = 1e-6) -> str:
    with tempfile.TemporaryDirectory() as folder:
        return counted(*bounce(Path(folder), field, duration=duration, accuracy=accuracy))


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


def flown_out(field: str) -> str:
    return f"{experiments.release(3e-14, field=field):.0e}"


def pulled_out(field: str) -> str:
    return f"{experiments.work_of_release(field=field):.0e}"


def rest(field: str) -> str:
    times = (10.0, 30.0) if field == "smooth" else (6.0,)
    moved, weight = experiments.rocking(times, field=field)
    seen = ", ".join(f"{m * 1e6:.2g} at {t:g} s" for t, m in zip(times, moved, strict=True))
    return f"{seen}; {weight:.4f}"


def incline(field: str) -> str:
    mu = 0.5
    box = BoxOnIncline(foundation(mu=mu, field=field), np.arctan(0.99 * mu))
    box.run.advance_to(20.0)
    return f"{abs(box.slide(40.0)):.0e}"


def cost(web: experiments.Web, pose: np.ndarray) -> str:
    rows = web.find(pose)
    times = []
    for _ in range(60):
        start = time.perf_counter()
        web.find(pose)
        times.append(time.perf_counter() - start)
    looked_at, loaded = (min(times) / n * 1e9 for n in (rows["probed"], len(rows["key"])))
    return f"{looked_at:.0f} ({loaded:.0f})"


def flat_cost(field: str) -> str:
    web = experiments.Web(parts.box(), parts.box(1, 1, 0.2), 1e9, resolution=0.068, field=field)
    return cost(web, experiments.pose([0.0123, 0.0077, -0.15 + 5e-5]))


def grazing_cost(field: str) -> str:
    web = experiments.doughnut_on_cone(resolution=0.01, field=field)
    return cost(web, experiments.pose([2e-4, 1e-4, -0.1663]))


# What is measured; the prototype's figures with the smooth and the exact field; ours.
ROWS: tuple[tuple[str, str, str, Figures], ...] = (
    (
        "P1 largest change of the force over the largest force; path in n, 2 n, 4 n steps",
        ".0175 .0088 .0044",
        ".029 .029 .029",
        sampled,
    ),
    (
        "P1 how many times less the largest change is when each step is cut in 2, 4, 16",
        "1.99 3.98 –",
        "1.00 1.00 –",
        cut,
    ),
    ("P1 largest jump at a point of the path over the largest force", "–", ".029", jump_left),
    ("P2 work of a closed tour over the largest energy", "-2e-7", "-7e-4", loop),
    (
        "P2 doughnut bouncing on a cone, drift (touch-downs)",
        "7e-6 (18–31)",
        "6e-5 (18–31)",
        bouncing,
    ),
    ("P2 the same integrated at a tenth of the tolerance", "–", "–", bouncing_closer),
    ("P2 ten bounces by runge_kutta3 at accuracy 1e-6", "–", "–", in_drake),
    ("P3 12-facet box on a plane, × 1, 4, 16, 64 facets [N]", "exact", "500.5 all", refined_box),
    (
        "P3 ball on ball, node spacing 1.06 .53 .27 .13 a",
        ".754 .944 .987 1",
        ".750 .945 .988 1",
        balls,
    ),
    ("P3 fine balls over π K R δ², spacing .53 .27 .13 a", "–", "–", closed_form),
    ("P4 box over an irregular slab, sideways over weight", "5e-17", "5e-13", ghosts),
    (
        "P6 block in a 2 mm plate, .5 1 1.5 2 2.5 3 4 5 mm deep, over K A · 1 mm",
        "same as exact",
        ".41 .74 .90 1.23 2.20 …",
        plate,
    ),
    ("P7 fillets over their closed form − 1, d = .1 .25 .5 1 r", "within .07", "–", fillet),
    (
        "release from 1 mm of overlap in flight, kinetic over stored − 1",
        "-1e-11",
        "2e-8",
        flown_out,
    ),
    ("the same by quadrature: work over stored − 1", "–", "–", pulled_out),
    (
        "frictionless doughnut on a cone: rocking [µm]; force over weight at the end",
        "31 at 10 s, .8 at 30 s; 1.000",
        "140 at 6 s",
        rest,
    ),
    (
        "block on an incline at .99 μ, through Drake: moved from 20 to 60 s [m]",
        "–",
        "1e-15",
        incline,
    ),
    ("cost of a flat contact, ns a node looked at (loaded)", "97", "700–1100", flat_cost),
    ("cost of a grazing contact, ns a node looked at (loaded)", "–", "–", grazing_cost),
)


def lines() -> Iterator[str]:
    yield "| | smooth field: prototype | **ours** | exact field: prototype | **ours** |"
    yield "|---|---|---|---|---|"
    for name, smooth, exact, figures in ROWS:
        yield f"| {name} | {smooth} | {figures('smooth')} | {exact} | {figures('exact')} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, help="Markdown file to write the table to")
    options = parser.parse_args()
    table = []
    for line in lines():
        print(line, flush=True)
        table.append(line)
    if options.out:
        options.out.write_text(HEADING + "\n".join(table) + "\n" + REMARKS)


if __name__ == "__main__":
    main()
