"""A study that takes a fraction of a second a run: a ball falls on a plate and bounces."""

from scenarios.sweep.plan import Plan
from scenarios.sweep.study import load_study

SCENARIO = """
drop:
  simulation_duration: 0.2
  record_period: 0.002
  plant_config: {time_step: 0.002}
  parts:
    plate: {generator: box, parameters: {size_z: 0.02}}
    ball: {generator: icosphere, parameters: {radius: 0.02, frequency: 3}, density: 500}
  directives:
  - add_model: {name: plate, file: package://parts/plate.urdf}
  - add_weld: {parent: world, child: plate::plate}
  - add_model:
      name: ball
      file: package://parts/ball.urdf
      default_free_body_pose: {ball: {translation: [0, 0, 0.04]}}
  contact: {k: 1.0e+8, alpha: 0.5, friction: {static: 0}}
  acceptance:
    figures:
      highest [mm]: '1e3 * high("ball.z", 0.1, 0.2)'
    limits:
      highest [mm]: {at_least: 29.36}
"""
STUDY = """
drop_study:
  scenario: drop.yaml
  runs: 6
  parameters:
    stiffness [Pa/m]: {sets: [contact.k], distribution: !Uniform {min: 3.0e+7, max: 8.0e+7}}
    alpha [s/m]: {sets: [contact.alpha], distribution: !Gaussian {mean: 0.5, stddev: 0.1}}
    ball:
      choices: {small: [parts.ball.parameters.radius=0.018], large: []}
"""


def write_study(folder, study=STUDY, scenario=SCENARIO):
    """Write both files, and return the study's."""
    (folder / "drop.yaml").write_text(scenario)
    (folder / "study.yaml").write_text(study)
    return folder / "study.yaml"


def plan_of(folder, study=STUDY, scenario=SCENARIO):
    """The plan of the study, its files written into the folder."""
    return Plan(*load_study(str(write_study(folder, study, scenario))))


def rows_of(dataset):
    """All rows by key, without what differs from one time to the next."""
    rows = dataset.read().to_pylist()
    assert len({row["key"] for row in rows}) == len(rows), "a run is there twice"
    return {row.pop("key"): {k: v for k, v in row.items() if k != "wall_time"} for row in rows}
