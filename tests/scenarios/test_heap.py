"""Heaps of parts: overlaps as they can be worked out by hand, and parts that are lost are told."""

import numpy as np
import pytest

from contact_toolkit import CollisionMesh
from contact_toolkit.shapes.primitives import box
from scenarios.format.loading import load
from scenarios.judge.overlap import deepest_overlap
from scenarios.runner import run

BOX = CollisionMesh(*box([0.02, 0.02, 0.02]))


def at(*p, turned=0.0):
    c, s = np.cos(turned), np.sin(turned)
    return np.block(
        [[np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]), np.reshape(p, (3, 1))], [0, 0, 0, 1]]
    )


@pytest.mark.parametrize(
    ("other", "depth"),
    [
        (at(0.0, 0.0, 0.021), 0.0),
        (at(0.0, 0.0, 0.019), 0.001),
        (at(0.0, 0.0, 0.0), 0.0),  # the same box: no edge is inside
        (at(0.003, 0.0, 0.0), 0.003),  # by the diagonal of a face alone
        (at(0.0, 0.001, 0.01 + 0.02 / np.sqrt(2) - 0.002, turned=np.pi / 4), 0.002),  # on an edge
        (at(0.019, 0.019, 0.0), 0.001),
    ],
)
def test_overlaps_are_as_deep_as_worked_out_by_hand(other, depth):
    """A part within another would be taken for one at rest beside it."""
    both = np.array([True, True])
    assert deepest_overlap([BOX, BOX], [at(0, 0, 0), other], both) == pytest.approx(depth, abs=1e-9)


def test_a_part_wholly_inside_is_found_and_fixed_ones_may_overlap():
    """No edge crosses a face, and yet one is in the other; walls of a bin meet in its corners."""
    small = CollisionMesh(*box([0.002, 0.002, 0.002]))
    meshes, poses = [BOX, small], [at(0, 0, 0), at(0.003, 0, 0)]
    assert deepest_overlap(meshes, poses, np.array([False, True])) == pytest.approx(0.008)
    assert deepest_overlap(meshes, poses, np.array([False, False])) == 0.0


TWO = """
two:
  simulation_duration: 0.1
  record_period: 0.001
  plant_config: {time_step: 0.001}
  parts:
    floor: {generator: box, parameters: {size_x: 0.2, size_y: 0.2, size_z: 0.1}}
    cube: {generator: box, parameters: {size_x: 0.02, size_y: 0.02, size_z: 0.02}}
  directives:
  - add_model: {name: floor, file: package://parts/floor.urdf}
  - add_weld: {parent: world, child: "floor::floor"}
  - add_model:
      name: a
      file: package://parts/cube.urdf
      default_free_body_pose: {cube: {translation: [0, 0, 0.06]}}
  - add_model:
      name: b
      file: package://parts/cube.urdf
      default_free_body_pose: {cube: {translation: [AT, 0, 0.06]}}
  contact: {k: 1.0e+9, alpha: 2.0, resolution: 0.2, friction: {static: 0.4}}
  acceptance: {measure: heap, window: 0.02, limits: {parts: {near: 2, within: 0}}}
"""


@pytest.mark.parametrize(("x", "carried"), [(0.05, 1.0), (0.5, 0.5)])
def test_what_is_lost_and_what_is_not_carried_is_told(tmp_path, x, carried):
    """A heap would pass with parts that fall beside it. Both cubes stick out of the slab."""
    (tmp_path / "two.yaml").write_text(TWO.replace("AT", str(x)))
    figures = run(*load(str(tmp_path / "two.yaml")), tmp_path / "run").figures
    assert figures["parts lost"] == 2
    assert figures["weight carried"] == pytest.approx(carried, rel=1e-3)
    unbalanced = 0.0 if carried == 1.0 else 1.0
    assert figures["largest unbalanced force [weights]"] == pytest.approx(unbalanced, abs=1e-3)
    fallen = 0.0 if carried == 1.0 else 981.0  # g t after 0.1 s
    assert figures["largest speed at the end [mm/s]"] == pytest.approx(fallen, abs=1.0)
    sunk = 1000 * 0.02 * 9.81 / 1e9  # ρ g h / k
    assert figures["deepest overlap [mm]"] == pytest.approx(1e3 * sunk, rel=0.01)
