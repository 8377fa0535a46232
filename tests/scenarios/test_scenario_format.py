"""Scenario files: what loads, what is refused and how the refusal reads."""

import json

import jsonschema
import numpy as np
import pytest
from pydrake.common.yaml import yaml_load

from scenarios.format.errors import ScenarioError
from scenarios.format.loading import LIBRARY, dump, library, load
from scenarios.format.models import surface_of
from scenarios.format.scenario import Acceptance, Limit, Scenario
from scenarios.format.schema import json_schema, keys
from scenarios.judge.acceptance import judge
from scenarios.parts import make_part, write_obj

MINIMAL = """
fall:
  directives:
  - add_model: {name: ball, file: package://parts/ball.sdf}
  parts:
    ball: {generator: icosphere, parameters: {radius: 0.02, frequency: 3}}
"""


@pytest.fixture
def write(tmp_path):
    def write(text):
        path = tmp_path / "scenario.yaml"
        path.write_text(text)
        return str(path)

    return write


@pytest.mark.parametrize("name", library())
def test_every_scenario_of_the_library_loads_and_is_described(name):
    loaded, scenario = load(name)
    assert loaded == name
    assert scenario.description
    assert scenario.acceptance.limits


def test_what_is_left_out_has_its_default(write):
    name, scenario = load(write(MINIMAL))
    assert name == "fall"
    assert scenario.plant_config.time_step == 0.0
    assert scenario.simulator_config.integration_scheme == "runge_kutta3"
    assert scenario.simulation_duration == Scenario().simulation_duration


@pytest.mark.parametrize("name", library())
def test_resolved_yaml_loads_to_the_same_scenario(name, write):
    _, scenario = load(name, ["simulation_duration=0.25", "contact.k=7"])
    again_name, again = load(write(dump(name, scenario)))
    assert again_name == name
    assert dump(name, again) == dump(name, scenario)
    assert again.contact.k == 7.0
    assert again.simulation_duration == 0.25


def test_overrides_reach_into_mappings_and_lists(write):
    _, scenario = load(
        write(MINIMAL),
        [
            "simulator_config.accuracy=1e-6",
            "parts.ball.parameters.radius=0.03",
            "directives.0.add_model.name=marble",
            "visualization.camera=[1, 2, 3]",
            "initial_position.ball.joint=[1.0]",
        ],
    )
    assert scenario.simulator_config.accuracy == 1e-6
    assert scenario.parts["ball"].parameters["radius"] == 0.03
    assert scenario.directives[0].add_model.name == "marble"
    np.testing.assert_array_equal(scenario.visualization.camera, [1, 2, 3])
    np.testing.assert_array_equal(scenario.initial_position["ball"]["joint"], [1.0])


@pytest.mark.parametrize(
    ("addition", "complaint"),
    [
        ("duration: 3", r"scenario.yaml: fall: unknown key duration"),
        ("contact: {stiffness: 3}", "unknown key contact.stiffness"),
        ("simulator_config: {acuracy: 1e-3}", "unknown key simulator_config.acuracy"),
        ("acceptance: {limits: {g: {about: 1}}}", "unknown key acceptance.limits.g.about"),
        ("contact:", "contact is empty"),
        ("simulation_duration: long", "simulation_duration cannot be 'long'"),
        ("acceptance: {limits: {g: {at_most: one}}}", "limits.g.at_most cannot be 'one'"),
        ("contact: {friction: 3}", "contact.friction cannot be 3"),
        ("visualization: {camera: [1, two, 3]}", "visualization.camera.1 cannot be 'two'"),
        ("parts: [ball]", r"parts cannot be .*ball"),
        ("simulation_duration: -1", "simulation_duration must be positive, not -1"),
        ("simulation_duration: .nan", "simulation_duration must be positive, not nan"),
        ("record_period: 0", "record_period must be positive"),
        ("visualization: {frame_rate: 0}", "frame_rate must be positive"),
        ("visualization: {key_frame: -1}", "visualization.key_frame must not be negative"),
        ("visualization: {camera: [1, 2]}", "visualization.camera must be three finite numbers"),
        ("acceptance: {limits: {g: {near: 1}}}", "limits.g needs both near and within"),
        ("acceptance: {limits: {g: {}}}", "limits.g bounds nothing"),
        ("contact: [", "not readable as YAML"),
        (
            "acceptance: {limits: {g: {near: 1, within: -1}}}",
            "limits.g.within must not be negative",
        ),
        ("acceptance: {limits: {g: {at_most: .nan}}}", "limits.g.at_most must be a finite number"),
        ("acceptance: {limits: {g: {at_least: 2, at_most: 1}}}", "limits.g can never hold"),
        ("contact: {web: aera}", "contact.web must be one of area, facet.*did you mean 'area'"),
        ("contact: {materials: {ball: stell}}", "contact.materials.ball .*did you mean 'steel'"),
        ("contact: {overrides: [{web: net}]}", "contact.overrides.0.web must be one of"),
        ("simulator_config: {accuracy: -1}", "simulator_config.accuracy must be positive"),
        ("simulator_config: {integration_scheme: rk}", "simulator_config.integration_scheme must"),
        ("random_seed: -1", "random_seed must not be negative"),
        ("random_seed: 4294967296", "random_seed must be below 2³²"),
        ("simulator_config: {target_realtime_rate: -1}", "target_realtime_rate must not be"),
        ("simulator_config: {accuracy: .nan}", "simulator_config.accuracy must be positive"),
        ("plant_config: {time_step: -0.001}", "plant_config.time_step must not be negative"),
        ("visualization: {frame_rate: 1e9}", "frame_rate of 1e.09 1/s makes .* no browser"),
        ("record_period: 1e-9", "record_period of 1e-09 s makes"),
        ("gravity: [0, 0]", "gravity must be three finite numbers"),
        ("joints: {j: {kind: prismattic}}", "joints.j.kind .*did you mean 'prismatic'"),
        ("joints: {j: {axis: [0, 0, 0], child: b}}", "joints.j.axis must not be zero"),
        ("joints: {j: {axes: [0, 0, 1]}}", "unknown key joints.j.axes"),
        ("drives: {j: {}}", "drives.j needs a schedule or an amplitude"),
        ("drives: {j: {schedule: [[1, 0], [0, 0]]}}", "drives.j.schedule: times must increase"),
        ("drives: {j: {schedule: [[0, 1]], follows: position}}", "drives.j.stiffness"),
    ],
)
def test_bad_values_are_named_with_their_place(write, addition, complaint):
    with pytest.raises(ScenarioError, match=complaint):
        load(write(f"{MINIMAL}  {addition}\n"))


EVERYWHERE = """
fall:
  visualization: {web: true}
  simulator_config: {accuracy: 1.0e-3}
  plant_config: {time_step: 0.001}
  parts: {ball: {generator: icosphere}}
  joints: {j: {child: "ball::ball"}}
  drives: {j: {amplitude: 1.0, frequency: 1.0}}
  contact: {friction: {static: 0.1}, overrides: [{bodies: [ball, box], friction: {static: 0.2}}]}
  acceptance: {limits: {g: {at_most: 1}}}
  directives:
  - add_model: {name: ball, file: package://parts/ball.sdf}
  - add_weld: {parent: world, child: "ball::ball", X_PC: {translation: [0, 0, 0]}}
"""


@pytest.mark.parametrize(
    "place",
    [
        "", "visualization", "simulator_config", "plant_config", "parts.ball", "joints.j",
        "drives.j",
        "contact", "contact.friction", "contact.overrides.0", "contact.overrides.0.friction",
        "acceptance", "acceptance.limits.g", "directives.0", "directives.0.add_model",
        "directives.1.add_weld", "directives.1.add_weld.X_PC",
    ],
)  # fmt: skip
def test_a_misspelt_key_is_named_wherever_it_stands(write, place):
    """It would be passed over, and the run would be another than the one written down."""
    path = write(EVERYWHERE)
    assert load(path)[0] == "fall"
    wrong = f"{place}.mispelt" if place else "mispelt"
    with pytest.raises(ScenarioError, match=rf"scenario\.yaml: fall: unknown key {wrong}$"):
        load(path, [f"{wrong}=1"])


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "expected a mapping of names to scenarios"),
        ("- a", "expected a mapping of names to scenarios"),
        ("fall: 3", "expected the keys of a scenario, found 3"),
        ("fall: {}", "directives are empty"),
        ("a: {}\nb: {}", "holds a, b; say which"),
        (MINIMAL.replace("icosphere,", "icosphere, density: -1,"), "parts.ball.density"),
        (MINIMAL.replace("icosphere,", "icosphere, rgba: [2, 0, 0, 1],"), "parts.ball.rgba"),
    ],
)
def test_bad_files_are_refused(write, text, complaint):
    with pytest.raises(ScenarioError, match=complaint):
        load(write(text))


MISSING = pytest.mark.parametrize(
    ("wanted", "complaint"),
    [
        ("rock_and_roll", "no scenario is called 'rock_and_roll'; there are: .*rock_n_stack"),
        ("/nowhere/it.yaml", "/nowhere/it.yaml: no such file"),
    ],
)


def test_paths_are_relative_to_the_file_and_not_to_the_user(tmp_path, monkeypatch):
    """A scenario would run only from the folder its author stood in."""
    (tmp_path / "mine").mkdir()
    write_obj(tmp_path / "mine" / "cube.obj", make_part("box"))
    (tmp_path / "mine" / "fall.yaml").write_text(
        "fall:\n"
        "  parts: {cube: {mesh: cube.obj, scale: 0.5}}\n"
        "  packages: {models: ../models}\n"
        "  directives: [{add_model: {name: a, file: a.sdf}},"
        " {add_model: {name: b, file: package://parts/cube.sdf}}]\n"
    )
    monkeypatch.chdir("/")
    _, scenario = load(str(tmp_path / "mine" / "fall.yaml"))
    assert scenario.parts["cube"].mesh == str(tmp_path / "mine" / "cube.obj")
    assert scenario.packages["models"] == str(tmp_path / "models")
    assert scenario.directives[0].add_model.file == (tmp_path / "mine" / "a.sdf").as_uri()
    assert scenario.directives[1].add_model.file == "package://parts/cube.sdf"
    vertices, _ = surface_of(scenario.parts["cube"])
    np.testing.assert_allclose(np.ptp(vertices, axis=0), 0.05)


def test_the_saved_scenario_is_complete(write):
    """A later version's defaults would change what an old run says it was."""
    _, scenario = load(write(MINIMAL))
    saved = dump("fall", scenario)
    for key in ("accuracy", "time_step", "half_space_reach", "frame_rate", "window", "gravity"):
        assert f"{key}:" in saved


def test_the_schema_tells_every_key_with_unit_default_and_choices():
    """A user could not find out what may stand in a file."""
    found = {key.place: key for key in keys()}
    assert found["simulation_duration"].unit == "s"
    assert found["simulation_duration"].default == "1.0"
    assert found["contact.web"].allowed == ("area", "facet")
    assert "kind" in str(found["joints.*.kind"])
    assert [key.place for key in found.values() if not key.meaning] == []


@pytest.mark.parametrize(
    "path",
    sorted(  # studies and fits say what to do with scenarios
        path
        for path in LIBRARY.parent.glob("*/*.yaml")
        if not path.stem.endswith(("_study", "_fit"))
    ),
    ids=lambda path: path.stem,
)
def test_the_json_schema_accepts_what_runs(path):
    """Editors would underline what runs; a misspelt key must be underlined."""
    schema = json.loads(json_schema())
    contents = yaml_load(filename=str(path))
    jsonschema.validate(contents, schema)
    next(iter(contents.values()))["contcat"] = {}
    with pytest.raises(jsonschema.ValidationError, match="contcat"):
        jsonschema.validate(contents, schema)


@MISSING
def test_missing_scenarios_are_named(wanted, complaint):
    with pytest.raises(ScenarioError, match=complaint):
        load(wanted)


def test_one_of_several_scenarios_in_a_file_can_be_chosen(write):
    path = write(MINIMAL + MINIMAL.replace("fall:", "drop:"))
    assert load(f"{path}:drop")[0] == "drop"
    with pytest.raises(ScenarioError, match="no scenario 'fly', only fall, drop"):
        load(f"{path}:fly")


@pytest.mark.parametrize(
    "override", ["record_period", "record_period=", "=3", "directives.7.x=1", "a.b=["]
)
def test_bad_overrides_are_quoted(write, override):
    with pytest.raises(ScenarioError):
        load(write(MINIMAL), [override])


@pytest.mark.parametrize(
    ("limit", "holding", "failing"),
    [
        (Limit(near=1.0, within=0.01), 1.0099, 1.0101),
        (Limit(at_least=3), 3, 2.9),
        (Limit(at_most=0.05), 0.05, 0.051),
        (Limit(at_least=0.0, at_most=1.0), 0.5, float("nan")),
    ],
)
def test_limits_hold_up_to_their_bounds(limit, holding, failing):
    assert limit.holds(holding)
    assert not limit.holds(failing)


def test_verdicts():
    acceptance = Acceptance(measure="m", limits={"g": Limit(at_most=1.0)})
    assert judge(acceptance, {"g": 0.5})[0] == "passed"
    assert judge(acceptance, {"g": 1.5})[0] == "failed"
    assert judge(Acceptance(), {"g": 1.5})[0] == "not judged"
    with pytest.raises(ScenarioError, match="no figure is called g; 'm' gives h"):
        judge(acceptance, {"h": 0.5})
