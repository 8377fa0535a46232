"""The comparison of engines: what it writes, and that each engine runs the same experiment."""

import importlib.util
import json
import math

import pytest

from scenarios.compare.compare import compare, comparison_markdown, comparison_table, engines
from scenarios.compare.drake_engines import builtin, friction_of, ours
from scenarios.format.loading import load

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


def test_an_engine_that_cannot_is_a_row_and_not_the_end(slide, tmp_path, monkeypatch):
    """One engine's refusal would cost the results of all."""

    def refuse(_):
        raise RuntimeError("no such shape\nand more")

    table = {"ours, implicit": lambda scenario: ours(scenario, implicit=True), "other": refuse}
    monkeypatch.setattr("scenarios.compare.compare.engines", lambda: table)
    outcomes, folder = compare("slide", slide, tmp_path / "out")
    assert [outcome.verdict for outcome in outcomes] == ["passed", "cannot"]
    assert outcomes[1].error == "no such shape"
    assert math.isnan(outcomes[1].real_time_factor)
    saved = json.loads((folder / "comparison.json").read_text())
    assert [row["engine"] for row in saved["engines"]] == ["ours, implicit", "other"]
    assert (folder / "comparison.png").stat().st_size > 10_000
    assert "From left to right: ours, implicit (passed)</p>" in (
        folder / "comparison.html"
    ).read_text(encoding="utf-8")
    assert comparison_table("slide", slide, outcomes).row_count >= 2
    rows = comparison_markdown(slide, outcomes)
    assert "| ours, implicit | passed | 2.9" in rows
    assert "| other | cannot | – | – |" in rows
    assert "other: no such shape." in rows


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
