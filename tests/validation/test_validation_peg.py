"""Row 19 of the validation: Whitney's jamming diagram, a grid of cases on either side of its sides.

A peg in two-point contact, pushed by F_x and F_z and turned by M about its tip, slides iff
|M / (r F_z) − μ (1 + λ) F_x / F_z| < λ = l / (2 r μ) and |F_x / F_z| < 1 / μ: the balance of forces
and of moments with both contacts at the limit of friction, for the peg that leans either way.
"""

from __future__ import annotations

import pytest
from validation_scenes import judge

from scenarios.format.loading import load
from scenarios.runner import run

RADIUS, DEPTH, MU, PUSH = 0.0098, 0.019, 0.3, 20.0  # of the scenario `peg_in_hole`
LAMBDA = DEPTH / (2 * RADIUS * MU)


@pytest.mark.slow
@pytest.mark.parametrize("sideways", [-1.0, 1.0, 2.5])
def test_pegs_jam_outside_of_the_parallelogram(record_property, tmp_path, sideways):
    """Row 19: 0.8 and 1.2 λ from the middle of the diagram, F_x / F_z as given."""
    moments = [MU * (1 + LAMBDA) * sideways + share * LAMBDA for share in (-1.2, -0.8, 0.8, 1.2)]
    overrides = []
    for peg, moment in zip("abcd", moments, strict=True):
        for joint, effort in ("x", sideways * PUSH), ("turn", moment * RADIUS * PUSH):
            schedule = f"{{schedule: [[0, 0], [0.02, {effort}]]}}"
            overrides.append(f"drives.{joint}_{peg}={schedule}")
    figures = {peg: f'at("peg_{peg}.z", 0.1) - at("peg_{peg}.z", 0.15)' for peg in "abcd"}
    overrides += [f"acceptance.figures={figures}", "acceptance.limits={}"]
    ways = run(*load("peg_in_hole", overrides), tmp_path / "run").figures
    verdicts = ("jams", "slides", "slides", "jams")
    for peg, moment, expected in zip("abcd", moments, verdicts, strict=True):
        told = "slides" if ways[peg] > 2e-4 else "jams" if ways[peg] < 1e-5 else "creeps"
        case = f"peg, F_x / F_z = {sideways:g}, M / (r F_z) = {moment:.2f}"
        judge(record_property, (19, case), expected, told)
