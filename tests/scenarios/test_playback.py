"""The playback of Rock-N-Stack in a browser: it loads, moves, and shows the web when it should."""

import numpy as np
import pytest
from playback_page import CHROMIUM, playback_page

from scenarios.format.loading import load
from scenarios.runner import run
from scenarios.simulation.record import Record

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium (Debian: apt install chromium)"),
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("playback")
    run(*load("rock_n_stack", ["simulation_duration=0.3"]), folder)
    return folder


@pytest.fixture(scope="module")
def page(folder):
    with playback_page() as page:
        page.open(folder / "playback.html")
        yield page


def pixels_of_the_web(page, time):
    """How many pixels change when the proximity edges are hidden."""
    page.seek(time)
    page.show_web(visible=True)
    shown = page.pixels()
    page.show_web(visible=False)
    hidden = page.pixels()
    page.show_web(visible=True)
    return np.any(shown != hidden, axis=-1).sum()


def test_it_loads_without_a_complaint_and_is_as_long_as_the_run(page):
    assert page.duration == pytest.approx(0.3, abs=1 / 32)
    assert page.complaints == []


def test_the_canvas_shows_the_bodies(page):
    page.seek(0.0)
    colours = np.unique(page.pixels().reshape(-1, 3), axis=0)
    assert len(colours) > 1000


def test_the_picture_changes_as_the_animation_plays(page):
    page.seek(0.0)
    before = page.pixels()
    page.play(0.15)
    during = page.pixels()
    page.seek(0.0)
    again = page.pixels()
    assert np.any(before != during, axis=-1).sum() > 1000
    np.testing.assert_array_equal(before, again)


def test_proximity_edges_show_after_contact_and_not_before(page, folder):
    record = Record.load(folder / "series.parquet")
    touch = record["time"][np.argmax(record["springs"] > 0)]
    assert touch > 2 / 32
    for time in (0.0, touch - 1 / 32):
        assert pixels_of_the_web(page, time) == 0
    assert pixels_of_the_web(page, 0.3) > 200
