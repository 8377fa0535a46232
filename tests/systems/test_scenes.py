"""Scenes of strangers' models at 2 ms steps with nothing set by hand, each by a truth of its own.

Statics, closed forms and Drake's mass matrix say what is true (benchmarks/scenes, extra `models`).
"""

from __future__ import annotations

import pytest

from benchmarks.scenes.run import SCENES, missing, run_apart
from benchmarks.scenes.scene import Truth


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_a_scene_is_as_its_truth_says(name: str):
    """What is held creeps or falls, a heap sinks, a nut climbs by another pitch than its own."""
    scene = SCENES[name]
    if absent := missing(scene):
        pytest.skip(f"{', '.join(absent)} not installed")
    result = run_apart(scene, "ours")
    assert not result.failure
    assert result.figures.keys() == scene.truths.keys()
    assert not result.astray(scene), result.figures


def test_the_scenes_are_those_promised():
    """The table would shrink unnoticed; a figure that is no number would pass."""
    assert len(SCENES) == 9
    assert all(scene.truths for scene in SCENES.values())
    assert Truth(1.0, 0.1).met_by(1.05)
    assert not Truth(1.0, 0.1).met_by(1.2)
    assert not Truth(1.0, 0.1).met_by(float("nan"))
