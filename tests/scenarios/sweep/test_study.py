"""Studies: what is drawn, from what, and what a run is known by."""

import itertools

import numpy as np
import pytest
from scipy.stats import kstest, norm
from sweep_scenes import SCENARIO, STUDY, plan_of

from scenarios.format.errors import ScenarioError
from scenarios.sweep.study import STUDIES, load_study

LARGE = STUDY.replace("runs: 6", "runs: 512")


@pytest.mark.parametrize("sampling", ["sobol", "latin_hypercube", "random"])
def test_values_follow_their_distributions(tmp_path, sampling):
    # A study of other distributions than it says answers another question.
    runs = plan_of(tmp_path, LARGE + f"  sampling: {sampling}\n").runs()
    stiffness = [run.inputs["stiffness [Pa/m]"] for run in runs]
    alpha = [run.inputs["alpha [s/m]"] for run in runs]
    large = sum(run.inputs["ball"] == "large" for run in runs)
    assert kstest(stiffness, "uniform", (3e7, 5e7)).pvalue > 0.01
    assert kstest(alpha, norm(0.5, 0.1).cdf).pvalue > 0.01
    assert abs(large - 256) < 45
    assert abs(np.corrcoef(stiffness, alpha)[0, 1]) < 0.15


def test_sobol_and_latin_hypercube_fill_every_sixteenth(tmp_path):
    # They are asked for because chance leaves gaps.
    for sampling in ("sobol", "latin_hypercube"):
        text = STUDY.replace("runs: 6", "runs: 16") + f"  sampling: {sampling}\n"
        values = [run.inputs["stiffness [Pa/m]"] for run in plan_of(tmp_path, text).runs()]
        assert sorted(int((v - 3e7) / 5e7 * 16) for v in values) == list(range(16))


def test_a_grid_is_every_combination_with_the_ends(tmp_path):
    text = (STUDY + "  sampling: grid\n").replace("max: 8.0e+7}}", "max: 8.0e+7}, points: 3}")
    text = text.replace("stddev: 0.1}}", "stddev: 0.1}, points: 2}")
    runs = plan_of(tmp_path, text).runs()
    alpha = [0.5 + 0.1 * norm.ppf(share) for share in (0.25, 0.75)]
    expected = itertools.product(alpha, ["large", "small"], [3e7, 5.5e7, 8e7])
    got = [
        (run.inputs["alpha [s/m]"], run.inputs["ball"], run.inputs["stiffness [Pa/m]"])
        for run in runs
    ]
    assert got == list(expected)
    assert {run.inputs["stiffness [Pa/m]"] for run in runs} == {3e7, 5.5e7, 8e7}
    assert len({run.key for run in runs}) == 12


def test_discrete_values_are_equally_likely(tmp_path):
    text = LARGE.replace(
        "!Uniform {min: 3.0e+7, max: 8.0e+7}", "!UniformDiscrete {values: [1, 2, 3]}"
    )
    values = [run.inputs["stiffness [Pa/m]"] for run in plan_of(tmp_path, text).runs()]
    counts = [values.count(value) for value in (1.0, 2.0, 3.0)]
    assert sum(counts) == 512
    assert all(abs(count - 171) < 3 for count in counts)  # Sobol's points are even


@pytest.mark.parametrize("sampling", ["sobol", "random"])
def test_more_runs_begin_with_those_of_fewer(tmp_path, sampling):
    # A sweep that is made longer would repeat all.
    text = STUDY + f"  sampling: {sampling}\n"
    few, many = plan_of(tmp_path, text), plan_of(tmp_path, text.replace("runs: 6", "runs: 40"))
    assert many.runs()[:6] == few.runs()
    assert many.identity == few.identity


def test_equal_keys_mean_equal_inputs_seed_and_scenario(tmp_path):
    def keys(study=STUDY, scenario=SCENARIO):
        return [run.key for run in plan_of(tmp_path, study, scenario).runs()]

    first = keys()
    assert keys() == first
    assert len(set(first)) == 6
    assert not set(first) & set(keys(scenario=SCENARIO.replace("density: 500", "density: 501")))
    assert not set(first) & set(keys(STUDY + "  random_seed: 1\n"))
    assert not set(first) & set(keys(STUDY + "  settings: [contact.standoff=0.002]\n"))


def test_a_mesh_file_that_changed_makes_other_runs(tmp_path):
    (tmp_path / "ball.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    text = SCENARIO.replace(
        "generator: icosphere, parameters: {radius: 0.02, frequency: 3}", "mesh: ball.obj"
    )
    before = plan_of(tmp_path, STUDY, text).base.digest()
    (tmp_path / "ball.obj").write_text("v 0 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\n")
    assert plan_of(tmp_path, STUDY, text).base.digest() != before


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("sets: [contact.k], ", ""), r"parameters.stiffness \[Pa/m\].sets is empty"),
        (("!Uniform {min: 3.0e+7, max: 8.0e+7}", "!Uniform {min: 8, max: 3}"), "no numbers"),
        (
            ("{small: [parts.ball.parameters.radius=0.018], large: []}", "{}"),
            "either a distribution",
        ),
        (("runs: 6", "runs: 0"), "runs must be positive"),
        (("runs: 6", "sampling: sobel"), "sampling must be one of sobol"),
        (("runs: 6", "sampling: grid"), "points: how many"),
        (("runs: 6", "maps: [[ball, size]]"), "are not two of"),
        (("runs: 6", "rums: 6"), "unknown key rums"),
        (("scenario: drop.yaml", "scenario: dorp.yaml"), "dorp.yaml: no such file"),
    ],
)
def test_mistakes_in_a_study_are_named(tmp_path, change, said):
    with pytest.raises(ScenarioError, match=said):
        plan_of(tmp_path, STUDY.replace(*change))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("sets: [contact.k]", "sets: [contact.kay]"), "unknown key contact.kay"),
        (("runs: 6", "score: lowest"), "score: no figure is called 'lowest'"),
        (("ball:\n", '"highest [mm]":\n'), "both a parameter and a figure"),
        (("ball:\n", "seed:\n"), "'seed' is a column of every sweep"),
    ],
)
def test_what_the_scenario_cannot_take_is_named_before_any_run(tmp_path, change, said):
    with pytest.raises(ScenarioError, match=said):
        plan_of(tmp_path, STUDY.replace(*change)).check()


def test_our_studies_can_be_run():
    for path in STUDIES.glob("*_study.yaml"):
        from scenarios.sweep.plan import Plan

        Plan(*load_study(path.stem)).check()
