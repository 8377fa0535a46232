"""The published example, end to end, judged by its own acceptance."""

import pytest

from scenarios.format.loading import load
from scenarios.runner import run


def test_the_doughnut_bounces_and_comes_to_rest_where_the_springs_carry_it(tmp_path):
    name, scenario = load("rock_n_stack")
    assert set(scenario.acceptance.limits) == {
        "bounces", "g-force", "height error [mm]", "jitter [mm rms]", "spin [rad/s]",
        "tilt [deg]", "springs", "facet pairs",
    }  # fmt: skip
    summary = run(name, scenario, tmp_path)
    assert summary.verdict == "passed", summary.checks
    assert summary.figures["merged duplicates"] > 0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rock_n_stack_unit", "rock_n_stack_energy"])
def test_its_variants_pass(name, tmp_path):
    summary = run(*load(name), tmp_path)
    assert summary.verdict == "passed", summary.checks
