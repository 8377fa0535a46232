"""Key frames of runs as pictures, and the sheet of them all."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from playback_page import CHROMIUM

from scenarios.format.errors import ScenarioError
from scenarios.format.loading import library, load
from scenarios.report.gallery import SHEET, SIZE, make_gallery
from scenarios.runner import run

ROOT = Path(__file__).parents[2]


def test_a_folder_without_runs_is_named(tmp_path):
    """An empty gallery would look like a made one."""
    with pytest.raises(ScenarioError, match=r"no run in it has a playback\.html"):
        make_gallery(tmp_path, tmp_path / "gallery")


@pytest.mark.browser
@pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium (Debian: apt install chromium)")
def test_the_picture_shows_the_key_frame(tmp_path):
    """The bullet would be gone, or the picture empty."""
    pixels = {}
    for moment in ("0.011", "0.02"):
        runs, out = tmp_path / moment, tmp_path / f"{moment}-gallery"
        overrides = [f"visualization.key_frame={moment}"]
        run(*load("bullet_and_plate", overrides), runs / "bullet_and_plate")
        assert make_gallery(runs, out) == [out / "bullet_and_plate.png", out / SHEET]
        with Image.open(out / "bullet_and_plate.png") as picture:
            assert picture.size == SIZE
            pixels[moment] = np.asarray(picture).astype(int)
    brass = [np.sum(p[..., 0] > p[..., 2] + 40) for p in pixels.values()]
    assert brass[0] > 100  # pixels of the bullet beside the plate
    assert brass[1] == 0  # far behind the camera


def test_every_scenario_of_the_library_has_its_picture():
    """A card of the site without a picture, or a picture of what is gone."""
    pictures = {path.stem for path in (ROOT / "scenarios" / "gallery").glob("*.png")}
    assert pictures - {Path(SHEET).stem} == set(library())
