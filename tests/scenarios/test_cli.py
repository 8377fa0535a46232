"""The command line, as a user calls it."""

import json
import re
import warnings

import numpy as np
import pytest
from PIL import Image
from playback_page import CHROMIUM
from typer.testing import CliRunner

import contact_toolkit
from scenarios.cli import app
from scenarios.parts import make_part, write_obj
from scenarios.run_folder import RunFolder


@pytest.fixture
def call(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")

    def call(*arguments, status=0, typed=""):
        result = CliRunner().invoke(app, [str(argument) for argument in arguments], input=typed)
        assert result.exit_code == status, result.output
        return result.output

    return call


DROP = """
drop:
  description: A cube falls
  simulation_duration: 0.02
  parts:
    cube: {generator: box}
    plate: {generator: box, parameters: {size_z: 0.01}}
  directives:
  - add_model: {name: plate, file: package://parts/plate.sdf}
  - add_weld: {parent: world, child: plate::plate}
  - add_model:
      name: cube
      file: package://parts/cube.sdf
      default_free_body_pose: {cube: {translation: [0, 0, 0.0559]}}
  contact: {web: facet, standoff: 0.001, k: 1000, friction: {static: 0}}
  acceptance:
    measure: stack
    body: cube
    window: 0.01
    limits: {springs: {at_least: 1}}
"""


def test_list_names_the_library(call):
    output = call("list")
    for name in ("rock_n_stack", "rock_n_stack_unit", "rock_n_stack_energy"):
        assert name in output


def test_run_prints_the_table_the_verdict_and_the_playback(call, tmp_path):
    (tmp_path / "drop.yaml").write_text(DROP)
    output = call("run", "drop.yaml", "--set", "contact.alpha=0.5")
    for figure in (
        "height [mm]", "expected height [mm]", "g-force", "springs", "facet pairs",
        "merged duplicates", "force evaluations", "real-time factor",
    ):  # fmt: skip
        assert figure in output
    assert re.search(r"acceptance\W+passed", output)
    assert "playback: runs/drop/playback.html" in output
    assert "alpha: 0.5" in (tmp_path / "runs" / "drop" / "scenario.yaml").read_text()

    failed = call("run", "drop.yaml", "--out", "there", "--set",
                  "acceptance.limits={springs: {at_most: 0}}", status=1)  # fmt: skip
    assert re.search(r"acceptance\W+failed", failed)
    assert "there/playback.html" in failed

    (tmp_path / "there" / "figures" / "springs.png").unlink()
    reported = call("report", "there")
    assert re.search(r"acceptance\W+failed", reported)
    assert (tmp_path / "there" / "figures" / "springs.png").is_file()


def test_warnings_of_a_simulation_are_one_line_each(call, tmp_path, recwarn):
    (tmp_path / "drop.yaml").write_text(DROP)
    settings = (
        "plant_config.time_step=0.001",
        "contact.k=1e4",
        "contact.discrete=explicit",
        "acceptance.limits={}",
    )
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        output = call("run", "drop.yaml", *(f for s in settings for f in ("--set", s)))
    assert re.search(
        r"^warning: the discrete plant's time step of 0.001 s is 0\.\d", output, re.MULTILINE
    )
    assert "contact_watch.py" not in output
    assert not recwarn


def test_a_simulation_that_stops_says_why_and_where_its_record_is(call, tmp_path):
    (tmp_path / "drop.yaml").write_text(DROP)
    settings = ("plant_config.time_step=0.01", "contact.k=1e6", "contact.discrete=explicit")
    output = call("run", "drop.yaml", *(f for s in settings for f in ("--set", s)), status=1)
    assert "drop.yaml: the discrete plant's time step of 0.01 s is" in output
    assert "recorded until then is in runs/drop" in output
    assert "Traceback" not in output
    assert (tmp_path / "runs" / "drop" / "summary.json").is_file()


def test_play_shows_a_scenario_live_and_keeps_nothing(call, tmp_path, monkeypatch):
    (tmp_path / "drop.yaml").write_text(DROP)
    monkeypatch.setattr("webbrowser.open", lambda _: False)
    monkeypatch.setattr("scenarios.live._Controls.quit", lambda _: True)
    output = call("play", "drop.yaml")
    assert "watch at http://localhost:" in output
    assert [path.name for path in tmp_path.iterdir()] == ["drop.yaml"]


def test_replay_opens_the_playback_of_a_run(call, tmp_path, monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "playback.html").touch()
    assert str(tmp_path / "run" / "playback.html") in call("replay", "run")
    assert opened == [(tmp_path / "run" / "playback.html").as_uri()]
    assert "no playback.html" in call("replay", tmp_path, status=2)


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("run", "rock_and_roll"), "no scenario is called 'rock_and_roll'"),
        (("run", "missing.yaml"), "missing.yaml: no such file"),
        (("run", "rock_n_stack", "--set", "contact.k=0"), "k must"),
        (("run", "rock_n_stack", "--set", "contact.stiffness=1"), "unknown key contact.stiffness"),
        (("run",), "give either a scenario or --all"),
        (("report", "nowhere"), "not a run folder"),
        (("distance", "doughnut", "torus"), "'torus' is neither a mesh file nor one of"),
        (("inspect", "missing.stl"), "missing.stl: no such file"),
        (("inspect", "box", "--picture", "nowhere/box.png"), "nowhere/box.png: No such file"),
        (("inspect", "box", "--picture", "box.bmp3"), "box.bmp3"),
        (("distance", "box", "box", "--standoff", "-1"), "standoff must be"),
        (("distance", "box", "box", "--at", "nan", "0", "0"), "not finite"),
        (("report", "broken"), "broken/summary.json: not the summary of a run"),
        (("run", "drop.yaml", "--out", "drop.yaml"), "drop.yaml: File exists"),
        (("run", "drop.yaml", "--set", "contact.k=-1"), "drop.yaml: contact between plate"),
        (("run", "drop.yaml", "--set", "acceptance.body=cub"), "did you mean 'cube'"),
        (("run", "drop.yaml", "--set", "acceptance.limits={sprigs: {at_most: 1}}"), "'springs'"),
        (("run", "drop.yaml", "--set", "acceptance.measure=stak"), "did you mean 'stack'"),
        (("parts", "torus"), "no part is called 'torus'"),
        (("run", "drop.yaml", "--set", "contact.max_step=-1"), "a time [s] >= 0"),
    ],
)
def test_mistakes_end_with_one_clear_line(call, tmp_path, arguments, complaint):
    (tmp_path / "drop.yaml").write_text(DROP)
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "summary.json").write_text("{")
    output = call(*arguments, status=2)
    assert complaint in output
    assert "Traceback" not in output


def test_distance_between_a_file_and_a_part(call, tmp_path):
    write_obj(tmp_path / "cube.obj", make_part("box"))
    output = call("distance", "cube.obj", "box", "--at", "0.3", "0", "0", "--standoff", "0.2001")
    assert re.search(r"distance \[m\]\s+0\.2\b", output)
    assert re.search(r"facet pairs within 0\.2001 m\s+56\b", output)


def test_inspect_tells_defects_hierarchy_and_draws(call, tmp_path):
    vertices, faces = make_part("doughnut")
    write_obj(tmp_path / "open.obj", (vertices, faces[1:]))
    output = call("inspect", "open.obj", "--picture", "open.png")
    assert re.search(r"facets\s+4095\b", output)
    assert "3 open edges" in output
    assert "nearly closed" in output
    assert re.search(r"hierarchy: depth\s+\d", output)
    assert (tmp_path / "open.png").stat().st_size > 10_000
    assert re.search(r"defects\s+none", call("inspect", "nut"))


def test_a_failed_set_leaves_the_earlier_run_and_report_tells_the_truth(call, tmp_path):
    """A slip in --set would destroy a result, or leave the old verdict on the new settings."""
    (tmp_path / "drop.yaml").write_text(DROP)
    call("run", "drop.yaml")
    assert "holds an earlier run; --force replaces it" in call("run", "drop.yaml", status=2)
    before = (tmp_path / "runs" / "drop" / "summary.json").read_bytes()
    call("run", "drop.yaml", "--force", "--set", "contact.k=-1", status=2)
    assert (tmp_path / "runs" / "drop" / "summary.json").read_bytes() == before
    assert re.search(r"acceptance\W+passed", call("report", "runs/drop"))
    crash = ("plant_config.time_step=0.01", "contact.k=1e6", "contact.discrete=explicit")
    call("run", "drop.yaml", "--force", *(f for s in crash for f in ("--set", s)), status=1)
    assert re.search(r"acceptance\W+error", call("report", "runs/drop"))


def test_the_second_of_two_runs_at_once_is_told(call, tmp_path):
    """Both would write one folder."""
    (tmp_path / "drop.yaml").write_text(DROP)
    first = RunFolder(tmp_path / "runs" / "drop")
    first.open()
    output = call("run", "drop.yaml", status=2)
    assert "runs/drop: another run is writing it; wait for it, or choose another" in output
    first.discard()
    call("run", "drop.yaml")


def test_files_and_folders_may_have_odd_names(call, tmp_path):
    """Drake reads models by URL: blanks, marks and letters of other languages would break it."""
    odd = tmp_path / "50 % größer #1"
    odd.mkdir()
    write_obj(odd / "my würfel.obj", make_part("box"))
    (odd / "drop it.yaml").write_text(
        DROP.replace("cube: {generator: box}", "cube: {mesh: my würfel.obj}"), encoding="utf-8"
    )
    call("run", odd / "drop it.yaml", "--out", odd / "my runs" / "§ 1?")
    assert (odd / "my runs" / "§ 1?" / "playback.html").is_file()


def test_a_video_that_cannot_be_made_is_told_before_the_run(call, tmp_path):
    """Minutes would be simulated before the complaint."""
    (tmp_path / "drop.yaml").write_text(DROP)
    refused = call("run", "drop.yaml", "--video", "drop.avi", status=2)
    assert "drop.avi: a video ends in .mp4 or .gif" in refused
    assert "--video goes with one scenario" in call("run", "--all", "--video", "a.gif", status=2)
    assert not (tmp_path / "runs").exists()


@pytest.mark.browser
@pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium (Debian: apt install chromium)")
def test_a_video_shows_the_run_from_start_to_end(call, tmp_path):
    """An empty file, or a still picture."""
    longer = DROP.replace("simulation_duration: 0.02", "simulation_duration: 0.2")
    (tmp_path / "drop.yaml").write_text(longer.replace("0.0559", "0.3"))
    output = call("run", "drop.yaml", "--video", "drop.gif", "--set", "acceptance={}")
    assert "video: drop.gif" in output
    with Image.open(tmp_path / "drop.gif") as film:
        assert film.n_frames == 5  # 25 a second, up to the playback's last of 32 a second
        first = np.asarray(film.convert("RGB")).astype(int)
        film.seek(4)
        last = np.asarray(film.convert("RGB")).astype(int)
    assert np.any(first != last, axis=-1).sum() > 1000


def test_judging_never_ends_in_a_traceback(call, tmp_path, monkeypatch):
    """Springs too soft to carry the cube would end in Python's complaint instead of a verdict."""

    def none(*_, **__):
        raise ValueError("no equilibrium within 1 m")

    monkeypatch.setattr("scenarios.judge.measures.equilibrium_height", none)
    (tmp_path / "drop.yaml").write_text(DROP)
    output = call("run", "drop.yaml", status=1)
    assert "no equilibrium" in output
    assert "Traceback" not in output
    assert json.loads((tmp_path / "runs/drop/summary.json").read_text())["verdict"] == "failed"


def test_the_summary_says_where_the_run_came_from(call, tmp_path):
    """A result could not be traced to what made it."""
    (tmp_path / "drop.yaml").write_text(DROP)
    call("run", "drop.yaml", "--set", "contact.alpha=0.5")
    summary = json.loads((tmp_path / "runs/drop/summary.json").read_text())
    assert summary["overrides"] == ["contact.alpha=0.5"]
    assert summary["host"]
    assert summary["date"].startswith("20")
    assert summary["warnings"] == []
    assert {"python", "drake", "contact-toolkit"} <= set(summary["versions"])


def test_units_survive_in_help_and_the_version_is_told(call):
    """Rich would eat [m] as markup."""
    assert "[m]" in call("distance", "--help")
    assert "[deg]" in call("distance", "--help")
    assert f"contact-toolkit {contact_toolkit.__version__}" in call("--version")


def test_distance_tells_inside_crossing_and_touching_apart(call):
    """A bare 0, or the distance between nested surfaces, would hide that bodies share space."""
    small = call("distance", "doughnut", "nut", "--at", "0.05", "0", "0")
    assert "B is inside A, wholly" in small or "A and B cross" in small
    inside = call("distance", "box", "rod", "--scale", "1")
    assert "A and B cross" in inside
    nested = call("distance", "box", "capsule")
    assert "B is inside A, wholly" in nested
    # The capsule reaches 0.014 m up and 4 mm across: its deepest vertex lies on its pole's axis.
    deep = float(re.search(r"deepest vertex \[m\]\s+([\d.]+)", nested)[1])
    assert 0.036 <= deep <= 0.05
    crossing = call("distance", "box", "box", "--at", "0.09", "0", "0")
    assert re.search(r"A and B cross", crossing) or "touch" in crossing
    apart = call("distance", "box", "box", "--at", "0.3", "0", "0")
    assert "deepest" not in apart


def test_inspect_lists_an_inside_out_mesh_as_a_defect(call, tmp_path):
    """A body of negative mass would look healthy."""
    vertices, faces = make_part("doughnut")
    write_obj(tmp_path / "flipped.obj", (vertices, faces[:, ::-1]))
    assert "inside out" in call("inspect", "flipped.obj")
    assert re.search(r"upper corner \[m\]\s+7e-05", call("inspect", "flipped.obj", "--scale", 1e-3))


def test_parts_and_schema_tell_what_may_stand_in_a_file(call):
    """A user would have to read the code to write a scenario."""
    assert "tracked_robot" in call("parts")
    assert re.search(r"minor_radius\s+0\.02", call("parts", "doughnut"))
    assert "contact.standoff" in call("schema")
    assert json.loads(call("schema", "--json"))["type"] == "object"


def test_doctor_finds_this_installation_healthy(call):
    output = call("doctor")
    assert "engine" in output
    assert "✗" not in output
