"""Runs: what a run folder holds, however the run ends."""

import json
import os
import signal

import numpy as np
import pyarrow.parquet as pq
import pytest

from scenarios.format.errors import ScenarioError
from scenarios.format.loading import load
from scenarios.report.summary import Summary
from scenarios.runner import run
from scenarios.simulation.record import Record

DROP = """
drop:
  simulation_duration: 0.2
  record_period: 0.001
  simulator_config: {max_step_size: 0.005}
  parts:
    plate: {generator: box, parameters: {size_z: 0.02}}
    ball: {generator: icosphere, parameters: {radius: 0.02, frequency: 3}, density: 500}
  directives:
  - add_model: {name: plate, file: package://parts/plate.sdf}
  - add_weld: {parent: world, child: plate::plate}
  - add_model:
      name: ball
      file: package://parts/ball.sdf
      default_free_body_pose: {ball: {translation: [0, 0, 0.04]}}
  contact: {web: facet, standoff: 0.001, k: 500, alpha: 0.5, friction: {static: 0}}
"""


@pytest.fixture
def scenario(tmp_path):
    path = tmp_path / "drop.yaml"
    path.write_text(DROP)
    return lambda *overrides: load(str(path), overrides)[1]


def test_a_run_leaves_a_complete_folder(scenario, tmp_path):
    reports = []
    summary = run("drop", scenario(), tmp_path / "run", progress=reports.append)
    folder = tmp_path / "run"
    assert summary.verdict == "not judged"
    assert summary.simulated_time == pytest.approx(0.2)
    assert summary.force_evaluations > 50
    assert summary.real_time_factor > 0.0
    assert reports == sorted(reports)
    assert reports[-1] == pytest.approx(0.2)
    assert Summary.load(folder) == summary
    assert json.loads((folder / "summary.json").read_text())["versions"]["drake"]
    figures = {path.name for path in (folder / "figures").iterdir()}
    assert figures == {
        "ball_height.png",
        "ball_attitude.png",
        "springs.png",
        "web.png",
        "energy.png",
    }
    assert "<html" in (folder / "playback.html").read_text()[:500]
    assert load(str(folder / "scenario.yaml"))[0] == "drop"


def test_time_series_hold_the_bounce_with_units(scenario, tmp_path):
    run("drop", scenario(), tmp_path / "run")
    record = Record.load(tmp_path / "run" / "series.parquet")
    assert record.units["ball.z"] == "m"
    assert record.units["ball.fz"] == "N"
    assert len(record["time"]) == 201  # every millisecond, both ends included
    np.testing.assert_allclose(np.diff(record["time"]), 0.001, rtol=1e-9)
    # Falls 9 mm from rest; pushed while springs are loaded; then rises.
    free = record["springs"] == 0
    assert 0 < (~free).sum() < 60
    np.testing.assert_array_equal(record["ball.fz"][free], 0.0)
    assert (record["ball.fz"][~free] > 0.0).all()
    assert (record["elastic_energy"][~free] > 0.0).all()
    assert record["ball.vz"].min() == pytest.approx(-np.sqrt(2 * 9.81 * 0.009), rel=0.05)
    assert record["ball.vz"].max() > 0.2
    np.testing.assert_array_equal(record["facet_pairs"] >= record["springs"], True)
    assert (np.diff(record["damping_loss"]) >= 0.0).all()
    total = sum(record[f"{kind}_energy"] for kind in ("kinetic", "gravitational", "elastic"))
    np.testing.assert_allclose(total + record["damping_loss"], total[0], atol=2e-3 * total[0])
    weight = record["ball.fz"][~free] / record["ball.g_force"][~free]
    assert weight == pytest.approx(500 * 4 / 3 * np.pi * 0.02**3 * 9.81, rel=0.1)


def test_bodies_of_one_name_keep_their_own_columns(tmp_path):
    second = DROP.split("  - add_model:\n      name: ball")[1].split("  contact:", maxsplit=1)[0]
    twin = "  - add_model:\n      name: twin" + second.replace("[0, 0, 0.04]", "[0, 0, 0.14]")
    path = tmp_path / "two.yaml"
    path.write_text(DROP.replace("  contact:", twin + "  contact:"))
    run("two", load(str(path), ["simulation_duration=0.01"])[1], tmp_path / "run")
    record = Record.load(tmp_path / "run" / "series.parquet")
    assert record["ball::ball.z"][0] == 0.04
    assert record["twin::ball.z"][0] == 0.14


def test_the_same_run_twice_gives_the_same_bits(scenario, tmp_path):
    for name in ("first", "second"):
        run("drop", scenario(), tmp_path / name)
    tables = [pq.read_table(tmp_path / name / "series.parquet") for name in ("first", "second")]
    assert tables[0].equals(tables[1])


def test_ctrl_c_leaves_a_readable_partial_run(scenario, tmp_path):
    def interrupt(simulated):
        if simulated > 0.05:
            os.kill(os.getpid(), signal.SIGINT)

    before = signal.getsignal(signal.SIGINT)
    summary = run("drop", scenario("simulation_duration=60"), tmp_path / "run", progress=interrupt)
    assert signal.getsignal(signal.SIGINT) is before
    assert summary.verdict == "interrupted"
    assert 0.05 < summary.simulated_time < 60.0
    assert Summary.load(tmp_path / "run") == summary
    record = Record.load(tmp_path / "run" / "series.parquet")
    assert 0.05 < record["time"][-1] <= summary.simulated_time
    assert (tmp_path / "run" / "playback.html").is_file()


@pytest.mark.parametrize("stage", ["collect", "judge_run", "draw_series", "draw_web"])
def test_ctrl_c_after_the_simulation_leaves_a_run_that_says_so(
    scenario, tmp_path, monkeypatch, stage
):
    """Minutes of simulation would be lost, or a run without its figures would be called passed."""

    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(f"scenarios.runner.{stage}", interrupt)
    run("drop", scenario("simulation_duration=0.01"), tmp_path / "run")
    summary = Summary.load(tmp_path / "run")
    assert summary.verdict == "interrupted"
    assert summary.error == "interrupted while the run was evaluated"
    assert summary.simulated_time == pytest.approx(0.01)
    assert [path.name for path in tmp_path.iterdir() if path.name != "drop.yaml"] == ["run"]


def test_a_crash_is_passed_on_and_leaves_a_readable_partial_run(scenario, tmp_path):
    def fail(simulated):
        if simulated > 0.05:
            raise ZeroDivisionError("in the middle of it")

    with pytest.raises(ZeroDivisionError):
        run("drop", scenario("simulation_duration=60"), tmp_path / "run", progress=fail)
    summary = Summary.load(tmp_path / "run")
    assert summary.verdict == "error"
    assert summary.error == "ZeroDivisionError: in the middle of it"
    assert len(Record.load(tmp_path / "run" / "series.parquet")["time"]) > 10


@pytest.mark.parametrize(
    ("override", "complaint"),
    [
        ("contact.k=0", "k must"),
        ("contact.k=-3", "k must"),
        ("contact.n=0.9", "n must"),
        ("contact.standoff=0", "standoff"),
        ("contact.web=spider", "web"),
        ("contact.weighting=heavy", "weighting"),
        ("contact.alpha=-1", "alpha"),
        ("contact.pairs=[[ball, moon]]", "moon"),
        ("parts.ball.generator=torus", "no part is called 'torus'"),
        ("parts.ball.parameters.radius=-1", "radius must be positive"),
        ("parts.ball.parameters.radus=1", "radus"),
        ("directives.0.add_model.file=package://parts/table.sdf", "table.sdf"),
        ("directives.0.add_model.file=/nowhere/table.sdf", "table.sdf"),
        ("initial_position.moon.joint=[1]", "initial_position.moon.joint"),
        ("initial_position.ball.ball=[1]", "expected 7 positions, not 1"),
        ("simulator_config.integration_scheme=euler_cromer", "euler_cromer"),
        ("acceptance.measure=beauty", "acceptance.measure: none is called 'beauty'"),
    ],
)
def test_impossible_scenarios_say_why(scenario, tmp_path, override, complaint):
    with pytest.raises(ScenarioError, match=complaint):
        run("drop", scenario(override), tmp_path / "run")


def test_joints_start_where_the_scenario_says(scenario, tmp_path):
    pose = "initial_position.ball.ball=[1, 0, 0, 0, 0.01, 0.02, 0.3]"
    run("drop", scenario(pose, "simulation_duration=0.01"), tmp_path / "run")
    record = Record.load(tmp_path / "run" / "series.parquet")
    assert [record[f"ball.{axis}"][0] for axis in "xyz"] == [0.01, 0.02, 0.3]


def test_a_folder_without_a_run_is_refused(tmp_path):
    with pytest.raises(ScenarioError, match="not a run folder"):
        Summary.load(tmp_path)
