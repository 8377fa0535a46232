"""Model files of strangers, each falling on a table at 2 ms steps with nothing set by hand.

The models are those of installable packages (extra `models`); the list is what Drake loads of them.
Truth is momentum: whatever a model does, the contact forces' impulse over the last half second is
its weight times that plus what its momentum gained, as Drake reckons it.
"""

from __future__ import annotations

import math

import pytest

from benchmarks.model_zoo.files import ModelFile, folder_of, listed_files
from benchmarks.model_zoo.run import fall_apart
from benchmarks.model_zoo.table import table

# What does not run, and why. Nothing is to be added for want of looking.
KNOWN: dict[str, str] = {}


@pytest.mark.slow
@pytest.mark.parametrize("model", listed_files(), ids=lambda model: model.name)
def test_a_stranger_s_model_falls_on_a_table(model: ModelFile):
    """A newcomer's first model would be refused, blow up, or be held by forces not its weight."""
    if folder_of(model.package) is None:
        pytest.skip(f"{model.package} is not installed")
    result = fall_apart(model, budget=300)  # of a slow machine
    if model.name in KNOWN and result.outcome != "ran":
        pytest.xfail(KNOWN[model.name])
    assert result.outcome == "ran", table({model: result})
    if not math.isnan(result.imbalance):
        assert abs(result.imbalance) < 0.01


def test_the_list_holds_what_was_promised():
    """The table would shrink unnoticed to the models that happen to run."""
    files = listed_files()
    assert len(files) >= 27
    assert len({model.package for model in files}) >= 4
    assert len(set(files)) == len(files)
