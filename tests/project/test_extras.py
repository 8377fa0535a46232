"""Every extra does something, and what is missing without it says its name."""

import re
import sys
import tomllib
from pathlib import Path

import pytest
from typer.testing import CliRunner

from scenarios.cli import app
from scenarios.format.errors import ScenarioError
from scenarios.report.video import _ffmpeg, playback_page
from scenarios.sweep.schedule import cluster

ROOT = Path(__file__).parents[2]
EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
FOLDERS = ("benchmarks", "contact_toolkit", "docs", "notebooks", "scenarios", "systems")
SPEAKERS = [ROOT / "Makefile", ROOT / ".ci" / "run", *ROOT.glob("*.md")] + [
    path for f in FOLDERS for end in ("py", "md") for path in (ROOT / f).rglob(f"*.{end}")
]


def test_extras_named_and_extras_there_are_the_same():
    """A reader is told to install an extra that there is not, or never hears of one."""
    told = r"contact-toolkit\[([a-z,]+)\]|\.extra-([a-z]+)|-e '\.\[([a-z]+)\]'|[Ee]xtra `([a-z]+)`"
    named = {
        name
        for path in SPEAKERS
        if path.is_file()
        for groups in re.findall(told, path.read_text())
        for name in "".join(groups).split(",")
    }
    assert named == set(EXTRAS)


def without(monkeypatch, *modules):
    for name in modules:
        monkeypatch.setitem(sys.modules, name, None)


def test_a_sweep_without_dask_names_its_extra(monkeypatch):
    without(monkeypatch, "dask", "distributed")
    with pytest.raises(ScenarioError, match=r"contact-toolkit\[sweep\]"), cluster(None, 1):
        pass


def test_pictures_without_a_driver_name_their_extra(monkeypatch, tmp_path):
    without(monkeypatch, "playwright", "playwright.sync_api")
    page = playback_page(tmp_path / "playback.html", (64, 64))
    with pytest.raises(ScenarioError, match=r"contact-toolkit\[video\]"), page:
        pass


def test_films_without_ffmpeg_name_their_extra(monkeypatch):
    without(monkeypatch, "imageio_ffmpeg")
    monkeypatch.setenv("PATH", "")
    with pytest.raises(ScenarioError, match=r"contact-toolkit\[video\]"):
        _ffmpeg()


def test_a_comparison_without_mujoco_names_its_extra(monkeypatch):
    found = {"ours, implicit": lambda _: None}
    monkeypatch.setattr("scenarios.compare.engines.engines", lambda: found)
    said = CliRunner().invoke(app, ["compare", "incline", "--engine", "MuJoCo"])
    assert said.exit_code != 0
    assert "contact-toolkit[compare]" in said.output
