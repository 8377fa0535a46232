"""What the playback shows: the camera finds the scene, arrows point the right way."""

import numpy as np
import pytest
from pydrake.geometry import Meshcat

from scenarios.format.loading import load
from scenarios.live import with_sliders
from scenarios.runner import run, unwatched_meshcat
from scenarios.simulation.contact_playback import arrows
from scenarios.simulation.drawings import camera_for


@pytest.mark.parametrize("size", [0.003, 1.0, 500.0])
def test_the_camera_stands_off_by_the_scenes_size(size):
    """Small scenes would be a dot, large ones would be around the camera."""
    points = size * np.random.default_rng(0).uniform(-1, 1, (200, 3)) + [7.0, 0.0, 0.0]
    camera, target = camera_for(points, 0.1 * size)
    assert np.linalg.norm(target - [7.0, 0.0, 0.0]) < 0.2 * size
    away = np.linalg.norm(camera - target)
    reach = np.linalg.norm(points - target, axis=1).max()
    assert 1.2 * reach < away < 8 * reach


def test_one_body_that_flies_off_does_not_take_the_camera_along():
    """A single lost part would make all others invisible."""
    points = np.vstack([np.zeros((99, 3)), [[1e6, 0, 0]]])
    camera, _ = camera_for(points, 0.1)
    assert np.linalg.norm(camera) < 10.0


def test_a_run_that_failed_at_its_start_has_a_camera_too():
    """Nothing was recorded: the picture's error hid the run's own."""
    camera, target = camera_for(np.empty((0, 3)), 0.1)
    np.testing.assert_array_equal(target, np.zeros(3))
    assert 0.1 < np.linalg.norm(camera) < 1.0


def test_an_arrow_is_a_shaft_with_two_barbs_and_has_a_longest_length():
    """An impact's arrow would fill the picture, a vertical one would lose its barbs."""
    point = np.zeros((3, 3))
    shaft = np.array([[0.0, 0.0, 1.0], [100.0, 0.0, 0.0], [1e-9, 0.0, 0.0]])
    start, end = arrows(point, shaft, longest=3.0, usual=1.0)
    assert len(start) == len(end) == 6  # the third is too short to draw
    np.testing.assert_allclose(end[:2], [[0, 0, 1], [3, 0, 0]])
    for barb in (end[2:4], end[4:]):
        assert np.linalg.norm(barb - end[:2], axis=1).min() > 0.1
    assert np.isfinite(end).all()


DROP = """
drop:
  simulation_duration: 0.12
  plant_config: {time_step: 0.001}
  parts:
    plate: {generator: box, parameters: {size_z: 0.02}}
    ball: {generator: icosphere, parameters: {radius: 0.02, frequency: 4}}
  directives:
  - add_model: {name: plate, file: package://parts/plate.sdf}
  - add_weld: {parent: world, child: plate::plate}
  - add_model:
      name: ball
      file: package://parts/ball.sdf
      default_free_body_pose: {ball: {translation: [0, 0, 0.034]}}
  contact: {k: 1.0e+10, alpha: 0.1, friction: {static: 0.3}}
  visualization: {frame_rate: 9}
"""


def test_an_impact_between_two_frames_is_shown(tmp_path, monkeypatch):
    """At 9 frames a second an impact of two milliseconds would never be seen."""
    (tmp_path / "drop.yaml").write_text(DROP)
    drawn = []
    real = Meshcat.SetLineSegments

    def spy(self, path, *arguments, **named):
        drawn.append(path)
        return real(self, path, *arguments, **named)

    monkeypatch.setattr(Meshcat, "SetLineSegments", spy)
    run(*load(str(tmp_path / "drop.yaml")), tmp_path / "run", meshcat=unwatched_meshcat())
    assert any(path.endswith("/web") for path in drawn)
    assert any(path.endswith("/normal") for path in drawn)


def test_sliders_change_gravity_and_contact_and_nothing_else(tmp_path):
    """A slider at its rest would change the scenario, or one would do nothing."""
    (tmp_path / "drop.yaml").write_text(DROP)
    _, scenario = load(str(tmp_path / "drop.yaml"))
    same = with_sliders(scenario, 1.0, 0.0, 1.0, 1.0)
    assert same.contact == scenario.contact
    np.testing.assert_array_equal(same.gravity, scenario.gravity)
    other = with_sliders(scenario, 0.5, 1.0, 2.0, 3.0)
    assert other.gravity[2] == pytest.approx(-4.905)
    assert other.contact.k == pytest.approx(1e11)
    assert other.contact.alpha == pytest.approx(0.2)
    assert other.contact.friction.static == pytest.approx(0.9)
    assert scenario.contact.k == 1e10
