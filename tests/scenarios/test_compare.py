"""The comparison of engines: what it writes, and that each engine runs the same experiment."""

import importlib.util
import json
import math
import sys
from pathlib import Path

import numpy as np
import pytest

from scenarios.compare.apart import run_apart
from scenarios.compare.compare import compare
from scenarios.compare.document import write_into
from scenarios.compare.drake_engines import builtin, friction_of, ours
from scenarios.compare.engines import engines
from scenarios.compare.tables import comparison_table
from scenarios.format.loading import load
from tests.support.interrupted import interrupted_at

SLIDE = """
slide:
  simulation_duration: 0.3
  plant_config: {time_step: 0.001}
  parts:
    floor: {generator: box, parameters: {size_x: 4, size_y: 1, size_z: 0.1}}
    block: {generator: box, mass: 2.0}
  directives:
  - add_model: {name: floor, file: package://parts/floor.sdf}
  - add_weld: {parent: world, child: "floor::floor", X_PC: {translation: [0, 0, -0.05]}}
  - add_model:
      name: block
      file: package://parts/block.sdf
      default_free_body_pose: {block: {translation: [0, 0, 0.05]}}
  initial_velocity: {block: {block: [0, 0, 0, 1, 0, 0]}}
  contact:
    {k: 1.0e+8, alpha: 0.2, resolution: 0.1, field: exact, friction: {static: 0.3}}
  acceptance:
    window: 0.02
    figures: {deceleration: '-slope("block.vx", 0.1, 0.25)'}
    limits: {deceleration: {near: 2.943, within: 0.15}}
"""


@pytest.fixture
def slide(tmp_path):
    (tmp_path / "slide.yaml").write_text(SLIDE)
    return load(str(tmp_path / "slide.yaml"))[1]


@pytest.mark.parametrize("engine", ["ours, implicit", "Drake hydroelastic", "MuJoCo"])
def test_each_engine_slides_the_same_block(slide, engine):
    """An engine would be given another mass, friction, gravity or start than the others."""
    if engine == "MuJoCo" and importlib.util.find_spec("mujoco") is None:
        pytest.skip("MuJoCo is not installed")
    outcome = engines()[engine](slide)
    assert outcome.figures["deceleration"] == pytest.approx(0.3 * 9.81, rel=0.1)
    assert outcome.record["kinetic_energy"][0] == pytest.approx(1.0)
    assert outcome.wall_time > 0.0
    assert outcome.poses["block"].shape[1:] == (4, 4)


PAIR = """
pair:
  simulation_duration: 0.05
  plant_config: {time_step: 0.001}
  parts:
    floor: {generator: box, parameters: {size_x: 0.2, size_y: 0.2, size_z: 0.1}}
    cube: {generator: box, parameters: {size_x: 0.02, size_y: 0.02, size_z: 0.02}}
  directives:
  - add_model: {name: ground, file: package://parts/floor.urdf}
  - add_weld: {parent: world, child: "ground::floor", X_PC: {translation: [0, 0, -0.05]}}
  - add_model: &cube
      name: a
      file: package://parts/cube.urdf
      default_free_body_pose: {cube: {translation: [0, 0, 0.01]}}
  - add_model:
      <<: *cube
      name: b
      default_free_body_pose: {cube: {translation: [0.05, 0, 0.01]}}
  contact: {k: 1.0e+9, alpha: 2.0, resolution: 0.2, friction: {static: 0.4}}
  acceptance:
    measure: heap
    window: 0.01
    limits: {parts: {near: 2, within: 0}, "deepest overlap [mm]": {at_most: 0.5}}
"""


@pytest.mark.parametrize("engine", ["ours, implicit", "Drake point", "MuJoCo"])
def test_every_model_of_a_part_is_a_body_of_its_own(tmp_path, engine):
    """An engine would be given one of the hundred parts in a bin; verdicts would not see a heap."""
    if engine == "MuJoCo" and importlib.util.find_spec("mujoco") is None:
        pytest.skip("MuJoCo is not installed")
    (tmp_path / "pair.yaml").write_text(PAIR)
    outcome = engines()[engine](load(str(tmp_path / "pair.yaml"))[1])
    assert set(outcome.poses) == {"a::cube", "b::cube"}
    for name, x in (("a::cube", 0.0), ("b::cube", 0.05)):
        assert outcome.poses[name][-1][:3, 3] == pytest.approx([x, 0, 0.01], abs=5e-4)
    assert outcome.verdict == "passed"
    assert 0 < outcome.penetration < 5e-4
    assert outcome.figures["parts"] == 2


def test_an_engine_that_cannot_is_a_row_and_not_the_end(slide, tmp_path):
    """One engine's refusal would cost the results of all."""
    slide.contact.web, slide.contact.standoff = "facet", 0.001  # with an area web's settings
    wanted = ("ours, implicit", "Drake hydroelastic")
    outcomes, folder = compare("slide", slide, tmp_path / "out", time_out=300.0, only=wanted)
    assert [outcome.verdict for outcome in outcomes] == ["cannot", "passed"]
    assert outcomes[0].error.startswith("field, resolution: of the area web")
    assert math.isnan(outcomes[0].real_time_factor)
    saved = json.loads((folder / "comparison.json").read_text())
    assert [row["engine"] for row in saved["engines"]] == list(wanted)
    assert 10_000 < (folder / "comparison.png").stat().st_size < 60_000
    assert "From left to right: Drake hydroelastic (passed)</p>" in (
        folder / "comparison.html"
    ).read_text(encoding="utf-8")
    assert comparison_table("slide", slide, outcomes).row_count >= 2
    document = tmp_path / "COMPARE.md"
    document.write_text("before\n<!-- slide -->\nold\n<!-- /slide -->\nafter\n")
    slide.cannot = {"MuJoCo": "no such thing"}
    write_into(document, "slide", slide, outcomes, folder)
    said = document.read_text()
    assert said.startswith("before\n<!-- slide -->\nTruth: ")
    assert said.endswith("\n<!-- /slide -->\nafter\n")
    assert "| Drake hydroelastic | passed | 2.9" in said
    assert "| ours, implicit | cannot | – | – |" in said
    assert "- ours, implicit: " in said
    assert "- MuJoCo: no such thing" in said
    assert "](compare/slide.png)" in said
    assert (tmp_path / "compare" / "slide.png").read_bytes() == (
        folder / "comparison.png"
    ).read_bytes()


def test_an_engine_that_takes_too_long_or_dies_is_a_row(tmp_path, monkeypatch):
    """One engine that hangs or crashes would cost the results of all."""
    saved = tmp_path / "slide.yaml"
    saved.write_text(SLIDE.replace("simulation_duration: 0.3", "simulation_duration: 600"))
    outcome = run_apart("ours, implicit", saved, time_out=6.0)
    assert (outcome.verdict, outcome.error) == ("timed out", "not done in 6 s")
    crash = tmp_path / "crash"
    crash.write_text("#!/bin/sh\necho out of luck >&2\nkill -SEGV $$\n")
    crash.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(crash))
    outcome = run_apart("ours, implicit", saved, time_out=60.0)
    assert (outcome.verdict, outcome.error) == ("cannot", "died by SIGSEGV: out of luck")


INTERRUPTED = """
import sys, time
import scenarios.compare.compare as comparison
from scenarios.cli import app
if sys.argv[2] == "set-up":
    def slow(*_):
        print("ready", flush=True)
        time.sleep(60)
    comparison.dump = slow
else:
    import subprocess
    wait = subprocess.Popen.wait
    def told(process, timeout=None):
        if process.poll() is None and timeout is not None and timeout > 100:
            print("engine", process.pid, "ready", flush=True)
        return wait(process, timeout)
    subprocess.Popen.wait = told
sys.argv = ["contact-toolkit", "compare", sys.argv[1], "--out", sys.argv[3]]
app()
"""


@pytest.mark.parametrize(
    ("stage", "said"),
    [
        ("set-up", "slide: interrupted during set-up; nothing was kept"),
        ("engine", "slide: interrupted while ours, implicit was running; nothing was kept"),
    ],
)
def test_ctrl_c_stops_all_engines_and_keeps_nothing(tmp_path, stage, said):
    """It would go on with the next engine, leave one running, or half of a comparison."""
    file, out = tmp_path / "slide.yaml", tmp_path / "runs" / "slide"
    file.write_text(SLIDE.replace("simulation_duration: 0.3", "simulation_duration: 600"))
    all_said = interrupted_at("ready", INTERRUPTED, str(file), stage, str(out))
    assert said in " ".join(all_said.split())
    assert list(out.parent.iterdir()) == []
    if stage == "engine":
        engine = next(line for line in all_said.splitlines() if "ready" in line).split()[1]
        assert not Path(f"/proc/{engine}").exists()


def test_friction_of_a_pair_survives_a_model_with_friction_of_bodies(slide):
    """Engines that combine friction of bodies would be given another for the pairs overridden."""
    slide.contact.overrides = [
        type("Pair", (), {"bodies": ["block", "floor"], "friction": slide.contact.friction})()
    ]
    a, b = friction_of(slide, "block"), friction_of(slide, "floor")
    assert 2 * a * b / (a + b) == pytest.approx(0.3)


def test_drakes_own_contact_is_judged_by_the_same_figures(slide):
    """A comparison of different figures is none."""
    outcome = builtin(slide, hydroelastic=False)
    assert [check.figure for check in outcome.checks] == ["deceleration"]


def test_figures_that_motion_alone_tells_are_judged_under_every_engine(slide):
    """A stack would be judged by its creep alone where it is under contact other than ours."""
    slide.acceptance.measure = "bodies"
    outcome = ours(slide, implicit=True)
    way = 0.3 - 0.5 * 0.3 * 9.81 * 0.3**2
    assert outcome.figures["largest move [mm]"] == pytest.approx(1e3 * way, rel=0.02)
    slide.acceptance.measure, slide.acceptance.body = "stack", "block"
    outcome = ours(slide, implicit=True)
    assert outcome.figures["height [mm]"] == pytest.approx(50.0, abs=1.0)
    assert outcome.figures["tilt [deg]"] < 1.0


def test_mujoco_that_blows_up_says_so(slide):
    """MuJoCo begins again from the start, and goes on as if nothing had been."""
    pytest.importorskip("mujoco")
    slide.initial_velocity["block"]["block"] = np.array([0, 0, 0, 1e11, 0, 0])
    with pytest.raises(RuntimeError, match="blew up after 0"):
        engines()["MuJoCo"](slide)
