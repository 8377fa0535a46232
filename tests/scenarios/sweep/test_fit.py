"""Fits: the true parameters lie within the intervals as often as these promise."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from contact_toolkit import NonlinearDamper
from scenarios.cli import app
from scenarios.format.errors import ScenarioError
from scenarios.sweep.fit import FreeParameter, fit
from scenarios.sweep.fit_file import fit_rollouts, load_fit, simulate
from scenarios.sweep.study import STUDIES


def heights(alpha, first):
    """The tops of a ball's bounces [m], by the closed form of the law's restitution."""
    tops = [first]
    for _ in range(8):
        v = np.sqrt(2 * 9.81 * tops[-1])
        e = NonlinearDamper(k=1e6, alpha=max(alpha, 0.0)).restitution(v)
        tops.append(tops[-1] * float(e) ** 2)
    return np.array(tops)


def test_nine_of_ten_intervals_hold_the_true_parameters():
    # Intervals that are too narrow make a calibration look surer than it is.
    rng = np.random.default_rng(7)
    free = {
        "alpha": FreeParameter(start=0.3, lower=0.0, upper=2.0),
        "first": FreeParameter(start=0.5, lower=0.0, upper=3.0, logarithmic=True),
    }
    held, widths = np.zeros(2), []
    for _ in range(100):
        truth = {"alpha": rng.uniform(0.1, 0.6), "first": rng.uniform(0.3, 1.0)}
        measured = heights(**truth) + rng.normal(0.0, 0.002, 9)
        found = fit(lambda values: heights(**values), measured, free)
        assert found.converged
        for index, (name, true) in enumerate(truth.items()):
            estimate = found.estimates[name]
            held[index] += estimate.lower <= true <= estimate.upper
        widths.append(found.estimates["alpha"].upper - found.estimates["alpha"].lower)
    assert (held >= 90).all(), held
    assert (held <= 99).all(), held  # not because they are as wide as can be
    assert np.median(widths) < 0.05


def test_a_straight_line_has_the_intervals_of_the_textbook():
    x = np.linspace(0.0, 1.0, 12)
    y = 2.0 + 3.0 * x + np.random.default_rng(1).normal(0.0, 0.1, 12)
    free = {"a": FreeParameter(start=1.0), "b": FreeParameter(start=1.0)}
    found = fit(lambda v: v["a"] + v["b"] * x, y, free)
    from scipy.stats import linregress, t

    line = linregress(x, y)
    b = found.estimates["b"]
    assert b.value == pytest.approx(line.slope, rel=1e-6)
    assert b.upper - b.value == pytest.approx(t.ppf(0.975, 10) * line.stderr, rel=1e-4)


def test_what_the_series_do_not_tell_has_no_bounds():
    # Of a product of two only the product can be found.
    x = np.linspace(1.0, 2.0, 20)
    y = 6.0 * x + np.random.default_rng(2).normal(0.0, 0.01, 20)
    free = {"a": FreeParameter(start=2.0), "b": FreeParameter(start=2.5)}
    found = fit(lambda v: v["a"] * v["b"] * x, y, free)
    assert np.isinf(found.estimates["a"].upper)
    assert found.undetermined == ("a", "b")
    product = found.estimates["a"].value * found.estimates["b"].value
    assert product == pytest.approx(6.0, rel=0.01)


def test_an_interval_wider_than_what_it_holds_is_said_to_determine_nothing():
    # `converged` with a stiffness of 1e6 that may as well be 1e3 or 1e9 reads like a result.
    x = np.linspace(1.0, 2.0, 20)
    y = 2.0 + x + np.random.default_rng(2).normal(0.0, 0.01, 20)
    free = {
        "a": FreeParameter(start=1.0),
        "k": FreeParameter(start=1e6, lower=1.0, upper=1e12, logarithmic=True),
        "c": FreeParameter(start=0.5, lower=0.0, upper=1.0),
    }
    found = fit(lambda v: v["a"] + x * (1 + 1e-4 * np.log(v["k"] / 1e6 + v["c"])), y, free)
    assert set(found.undetermined) >= {"k", "c"}
    assert found.estimates["a"].determined
    assert found.estimates["a"].lower < 2.0 < found.estimates["a"].upper
    assert np.isfinite(found.residuals).all()


def test_too_few_samples_are_told():
    with pytest.raises(ScenarioError, match="2 samples cannot tell 2 parameters"):
        fit(
            lambda v: np.array([v["a"], v["b"]]),
            np.ones(2),
            {"a": FreeParameter(), "b": FreeParameter()},
        )


FIT = """
bounce_fit:
  scenario: bouncing_ball
  settings: [simulation_duration=0.5, 'parts.ball.parameters={radius: 0.03, frequency: 6}',
             simulator_config.accuracy=1.0e-4, record_period=0.002]
  parameters:
    alpha: {sets: [contact.alpha], start: 0.4, lower: 0.0, upper: 2.0, step: 0.01}
  series:
  - {file: heights.csv, time: t, columns: {ball.z: height}}
"""


def write(folder, text=FIT, csv="t,height\n0.0,0.14\n"):
    (folder / "fit.yaml").write_text(text)
    (folder / "heights.csv").write_text(csv)
    return folder / "fit.yaml"


def test_rollouts_give_back_the_damping_that_a_noisy_bounce_was_made_with(tmp_path):
    times = np.linspace(0.0, 0.5, 60)
    path = write(tmp_path, csv="t,height\n" + "".join(f"{t},0\n" for t in times))
    _, wanted, base, samples = load_fit(path)
    (clean,) = simulate(wanted, base, samples, {"alpha": 0.25})
    noisy = clean + np.random.default_rng(3).normal(0.0, 0.0005, len(clean))
    rows = "".join(f"{t},{z}\n" for t, z in zip(times, noisy, strict=True))
    _, wanted, base, samples = load_fit(write(tmp_path, csv="t,height\n" + rows))
    alpha = fit_rollouts(wanted, base, samples).estimates["alpha"]
    assert alpha.lower < 0.25 < alpha.upper
    assert alpha.upper - alpha.lower < 0.03


def test_the_command_names_what_the_series_do_not_determine(tmp_path):
    # A ball that falls straight down says nothing of friction.
    times = np.linspace(0.0, 0.1, 12)
    rows = "".join(f"{t},{0.14 - 9.81 / 2 * t * t}\n" for t in times)
    text = FIT.replace("simulation_duration=0.5", "simulation_duration=0.1").replace(
        "  series:",
        "    friction: {sets: [contact.friction.static], start: 0.4, lower: 0.0, upper: 2.0}\n"
        "  series:",
    )
    path = write(tmp_path, text, csv="t,height\n" + rows)
    out = tmp_path / "out"
    result = CliRunner().invoke(app, ["fit", str(path), "--out", str(out)], env={"COLUMNS": "200"})
    assert result.exit_code == 1, result.output
    assert "not determined: friction, its interval is wider than 0.4" in result.output
    said = json.loads((out / "fit.json").read_text())
    assert "friction" in said["not_determined"]
    friction = said["estimates"]["friction"]
    assert (friction["determined"], friction["upper"]) == (False, None)


@pytest.mark.parametrize(
    ("change", "csv", "said"),
    [
        (("height}", "hight}"), None, "no column 'hight'; there are: t, height"),
        (("start: 0.4", "start: 4"), None, "parameters.alpha.start must lie between"),
        (("", ""), "t,height\n0,1\n0.1,high\n", "heights.csv:3: 'high' is not a finite number"),
        (("", ""), "t,height\n0.1,1\n0.1,1\n", "times must increase"),
        (("scenario: bouncing_ball", ""), None, "scenario is missing"),
    ],
)
def test_mistakes_are_named_before_anything_is_simulated(tmp_path, change, csv, said):
    path = write(tmp_path, FIT.replace(*change), csv or "t,height\n0.0,0.14\n")
    with pytest.raises(ScenarioError, match=said):
        load_fit(path)


@pytest.mark.slow
def test_the_force_that_pushes_a_press_fit_out_gives_its_friction():
    _, wanted, base, samples = load_fit(STUDIES / "press_fit_fit.yaml")
    found = fit_rollouts(wanted, base, samples)
    assert found.converged
    friction = found.estimates["friction"]
    assert friction.lower < 0.17 < friction.upper  # what the series was made with
    assert friction.upper - friction.lower < 0.005
