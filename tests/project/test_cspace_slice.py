"""The example of a C-space slice runs and draws the truth."""

import runpy
from pathlib import Path


def test_the_example_draws_the_exact_c_space(tmp_path):
    """A picture in the documentation that is wrong, or no longer drawn."""
    script = runpy.run_path(str(Path(__file__).parents[2] / "notebooks" / "cspace_slice.py"))
    picture = tmp_path / "slice.png"
    assert script["main"](picture, cells=80) == 0
    assert picture.stat().st_size > 10_000
