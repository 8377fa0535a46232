"""The report of a sweep: its numbers are those of the rows, and it needs nothing but itself."""

import math
import re

import numpy as np
import pytest
from sweep_scenes import STUDY, plan_of
from typer.testing import CliRunner

from scenarios.cli import app
from scenarios.format.errors import ScenarioError
from scenarios.sweep.charts import Axis, interval
from scenarios.sweep.dataset import Dataset
from scenarios.sweep.report import Results, simulate_again, write_report

RUNS = 60


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """A sweep whose figure is the stiffness in units of 2 MPa/m: judged by hand."""
    folder = tmp_path_factory.mktemp("report")
    plan = plan_of(folder, STUDY.replace("runs: 6", f"runs: {RUNS}"))
    dataset = Dataset(folder / "sweep", plan)
    rows = []
    for run in plan.runs():
        height = run.inputs["stiffness [Pa/m]"] / 2e6
        said = {"key": run.key, "run": run.number, "seed": run.seed, "versions": "{}"}
        verdict = "passed" if height >= 29.36 else "failed"
        rows.append(said | run.inputs | {"verdict": verdict, "highest [mm]": height})
        rows[-1] |= {"reason": "", "wall_time": 0.1}
    rows[7] |= {"verdict": "error", "reason": "it <broke>", "highest [mm]": None}
    with dataset.writing(resume=False):
        dataset.add(rows)
    return folder / "sweep"


def test_intervals_are_wilsons():
    # The formula as published (1927).
    z = 1.959963984540054
    for k, n in ((0, 5), (3, 10), (99, 100), (200, 500)):
        p, square = k / n, z**2 / n
        middle = (p + square / 2) / (1 + square)
        half = z * math.sqrt(p * (1 - p) / n + square / (4 * n)) / (1 + square)
        assert interval(k, n) == pytest.approx((middle - half, middle + half), abs=1e-12)
    assert interval(0, 0) == (0.0, 1.0)


def test_bins_hold_every_run_once_and_choices_stand_by_name():
    values = np.random.default_rng(5).normal(size=200).tolist()
    axis = Axis("x", values, 5)
    assert np.bincount(axis.bins).tolist() == [40] * 5
    names = Axis("part", ["nut", "mug", "nut"], 5)
    assert names.names == ["mug", "nut"]
    assert names.bins.tolist() == [1, 0, 1]
    constant = Axis("c", [2.0, 2.0], 5)
    assert constant.bins.tolist() == [0, 0]


def test_runs_are_ranked_by_verdict_then_score(swept):
    results = Results.load(swept)
    stiffness = results.numbers("stiffness [Pa/m]")
    stiffness[7] = np.nan
    assert results.named("best") == np.nanargmax(stiffness)
    assert results.named("worst") == np.nanargmin(stiffness)
    assert results.named("failed") == 7  # what broke is more telling than what failed
    assert results.named("12") == 12
    with pytest.raises(ScenarioError, match="no run is meant by 'bset'"):
        results.named("bset")


def test_the_page_has_the_counts_and_needs_nothing_else(swept):
    page = write_report(swept).read_text()
    results = Results.load(swept)
    passed = int(results.passed.sum())
    low, high = interval(passed, RUNS)
    assert f'<td class="number">{passed}</td><td class="number">{RUNS}</td>' in page
    assert f"{100 * low:.1f} to {100 * high:.1f} %" in page
    assert page.count("<svg") >= 2
    assert "it &lt;broke&gt;" in page
    links = set(re.findall(r'(?:src|href)="([^"#]+)"', page))
    assert not {link for link in links if not link.startswith("data:")}
    assert (swept / "success.png").stat().st_size > 1000


def test_a_playback_is_made_from_its_row_and_linked(swept):
    summary = simulate_again(swept, "best")
    results = Results.load(swept)
    number = results.columns["run"][results.named("best")]
    planned = results.plan.run_of(number)
    assert summary.overrides == list(planned.overrides)
    assert summary.random_seed == planned.seed
    assert (swept / "playbacks" / f"run-{number}" / "playback.html").is_file()
    said = CliRunner().invoke(app, ["report", str(swept)]).output
    assert "report.html" in said.replace("\n", "")
    assert f'href="playbacks/run-{number}/playback.html"' in (swept / "report.html").read_text()


def test_a_sweep_without_rows_has_no_report(tmp_path):
    dataset = Dataset(tmp_path / "sweep", plan_of(tmp_path))
    with dataset.writing(resume=False):
        pass
    with pytest.raises(ScenarioError, match="holds no rows yet"):
        write_report(tmp_path / "sweep")
