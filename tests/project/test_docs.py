"""What the site's pages tell a reader to do works, and their links lead somewhere."""

import importlib.util
import re
import shutil
import subprocess
import sys
from pathlib import Path
from urllib.parse import urlparse

import pytest
import typer.main
from pydrake.common.yaml import yaml_load

from scenarios.cli import app
from scenarios.format.loading import find, load
from scenarios.runner import run
from scenarios.sweep.fit_file import load_fit
from scenarios.sweep.plan import Plan
from scenarios.sweep.study import STUDIES, load_study

ROOT = Path(__file__).parents[2]
FOLDERS = ("docs", "benchmarks", "contact_toolkit", "notebooks", "scenarios", "systems")
PAGES = [
    *sorted(ROOT.glob("*.md")),
    *(p for f in FOLDERS for p in sorted((ROOT / f).rglob("*.md"))),
]
IDS = [str(page.relative_to(ROOT)) for page in PAGES]
# What else tells a reader what to type.
SPEAKERS = [*PAGES, ROOT / "Makefile", *sorted((ROOT / "notebooks").glob("*.py"))]
SPEAKER_IDS = [str(page.relative_to(ROOT)) for page in SPEAKERS]
COPIED = {"notebooks", "benchmarks", "systems", "scenarios", "contact_toolkit"}  # by `make docs`


_LINES = re.DOTALL | re.MULTILINE
# A file of ours or several, as `tests/query/*.py`; NAME stands for one that the reader makes.
_PATH = rf"(?<![\w/.-])((?:\.ci|tests|{'|'.join(FOLDERS)})/[^\s`'\",:;()]*)"


def blocks(page, language):
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(), _LINES)


def pages_with(language):
    return [pytest.param(page, id=page.stem) for page in PAGES if blocks(page, language)]


@pytest.mark.parametrize("page", pages_with("python"))
def test_the_code_of_a_page_runs_from_top_to_bottom(page, tmp_path):
    program = "\n".join(blocks(page, "python"))
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", program],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("page", pages_with("yaml"))
def test_the_files_of_a_page_are_what_they_seem(page, tmp_path):
    """A scenario misses its acceptance; a study or a fit has a key that there is not."""
    beside = shutil.copytree(STUDIES, tmp_path / "studies")
    for number, text in enumerate(blocks(page, "yaml")):
        file = beside / f"{number}.yaml"
        file.write_text(text)
        ((expected, contents),) = yaml_load(data=text).items()
        if "series" in contents:
            assert load_fit(file)[0] == expected
            continue
        if "scenario" in contents:
            Plan(*load_study(str(file))).check()
            continue
        name, scenario = load(str(file))
        assert name == expected
        assert run(name, scenario, tmp_path / "run").verdict == "passed"


def spoken(page):
    """What a page says in code: its blocks for shells, and what stands in backticks."""
    text = page.read_text()
    if page.name == "Makefile":
        return text.splitlines()
    fenced = re.findall(r"^```(\S*).*?\n(.*?)^```", text, _LINES)
    shells = "".join(code for language, code in fenced if language in {"", "sh"})
    return [*shells.splitlines(), *re.findall(r"`([^`\n]+)`", text)]


def test_every_block_is_of_a_kind_that_is_tested():
    """A block of code that nobody runs: as `text`, or in a page that is in no folder of ours."""
    kinds = {"python", "yaml", "sh", ""}  # by the tests above and below
    for page in PAGES:
        found = re.findall(r"^ *(?:```|~~~)(\S*).*?\n.*?^ *(?:```|~~~)$", page.read_text(), _LINES)
        assert {kind for kind in found if not kind.startswith("{")} <= kinds, page
    listed = subprocess.run(
        ["git", "ls-files", "*.md"], cwd=ROOT, capture_output=True, text=True, check=False
    ).stdout.split()  # none, where there is no repository
    assert set(listed) <= set(IDS)


@pytest.mark.parametrize("page", SPEAKERS, ids=SPEAKER_IDS)
def test_every_command_named_is_one(page):
    # A page names a command, an option or a scenario that was renamed.
    commands = typer.main.get_command(app).commands
    own = {option for parameter in typer.main.get_command(app).params for option in parameter.opts}
    for line in spoken(page):
        for said in re.findall(r"(?:contact-toolkit|-m contact_toolkit) ([^#|;&]+)", line):
            name, *rest = said.split()
            if name.startswith("-"):
                assert name in own | {"--help"}, line
            elif re.fullmatch("[a-z]+", name):
                known = {option for parameter in commands[name].params for option in parameter.opts}
                used = {word.partition("=")[0] for word in rest if word.startswith("--")}
                assert used - {"--help"} <= known, line
                for scenario in rest[: name in {"run", "play", "compare"}]:
                    if re.fullmatch("[a-z_]+", scenario):
                        find(scenario)


@pytest.mark.parametrize("page", PAGES, ids=IDS)
def test_what_is_made_and_run_exists(page, pytestconfig):
    # A target that make does not know, an option that pytest does not, or a file that was moved.
    makefile = (ROOT / "Makefile").read_text()
    for line in spoken(page):
        for target in re.findall(r"^\s*make ([a-z][a-z-]*)", line):
            assert re.search(rf"^{target}:", makefile, re.MULTILINE), line
        for option in re.findall(r'ARGS="[^"]*--([a-z-]+)', line):
            assert pytestconfig.getoption(option.replace("-", "_"), ValueError) is not ValueError
        for module in re.findall(r"python[0-9.]* -m ([\w.]+)", line):
            assert importlib.util.find_spec(module), line
        for path in re.findall(_PATH, line):
            assert re.search("[A-Z]{4}", path) or list(ROOT.glob(path)), line


def anchors(page):
    """Fragments of a page's headings, as MyST and GitHub make them."""
    titles = re.findall(r"^#+ (.*)", page.read_text(), re.MULTILINE)
    plain = (re.sub(r"[^\w\- ]", "", title.lower()) for title in titles)
    return {title.replace(" ", "-") for title in plain}


@pytest.mark.parametrize("page", PAGES, ids=IDS)
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text()):
        path, _, fragment = target.partition("#")
        if target.startswith(("http:", "https:")):
            assert urlparse(target).netloc, target  # the net is not asked
            continue
        where = page.parent / path if path else page
        if not where.exists():  # `make docs` puts these beside the pages
            assert path.lstrip("./").split("/")[0] in COPIED, target
            where = ROOT / path.lstrip("./")
        assert where.exists(), target
        assert not fragment or fragment in anchors(where), target
