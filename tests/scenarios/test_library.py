"""Every scenario of the library, end to end, judged by its own acceptance."""

import pytest

from scenarios.format.errors import NotInstalledError
from scenarios.format.loading import library, load
from scenarios.runner import run

# Parts fly at each other: single steps may stay unsolved, which is told. Their acceptance counts.
POURED = {"part_bin"}
MINUTES = {"part_bin_hundred"}  # `contact-toolkit run --all` judges it
TOLD = pytest.mark.filterwarnings("default:the contact forces of the step")
QUICK = {"bullet_and_plate", "dropped_robot", "incline", "newtons_cradle"}  # a few seconds each
TESTED_ELSEWHERE = {"rock_n_stack", "rock_n_stack_unit", "rock_n_stack_energy"}


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(
            name,
            marks=(
                *(() if name in QUICK else (pytest.mark.slow,)),
                *((TOLD,) if name in POURED else ()),
            ),
        )
        for name in library()
        if name not in TESTED_ELSEWHERE | MINUTES
    ],
)
def test_it_meets_its_truth(name, tmp_path):
    """Contact that no longer does what the closed form of this experiment says."""
    try:
        summary = run(*load(name), tmp_path / "run")
    except NotInstalledError as error:
        pytest.skip(str(error))
    assert summary.verdict == "passed", summary.checks
    assert summary.truth


@pytest.mark.slow
def test_softer_ground_lets_the_robot_sink_deeper_and_rebound_less(tmp_path):
    """Mud and hard ground would be one and the same."""
    names = ("dropped_robot", "dropped_robot_mud")
    figures = [run(*load(name), tmp_path / name).figures for name in names]
    sunk = [figure["sinkage [mm]"] for figure in figures]
    assert sunk == sorted(sunk)
    assert figures[0]["rebound [mm]"] > figures[1]["rebound [mm]"]
