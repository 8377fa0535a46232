"""What the site's pages tell a reader to do works, and their links lead somewhere."""

import re
import subprocess
import sys
from pathlib import Path
from urllib.parse import urlparse

import pytest
import typer.main
from pydrake.common.yaml import yaml_load

from scenarios.cli import app
from scenarios.format.loading import load
from scenarios.runner import run

ROOT = Path(__file__).parents[2]
FOLDERS = ("docs", "benchmarks", "contact_toolkit", "notebooks", "scenarios", "systems")
PAGES = [
    *sorted(ROOT.glob("*.md")),
    *(p for f in FOLDERS for p in sorted((ROOT / f).rglob("*.md"))),
]
IDS = [str(page.relative_to(ROOT)) for page in PAGES]
COPIED = {"notebooks", "benchmarks", "systems", "scenarios", "contact_toolkit"}  # by `make docs`


def blocks(page, language):
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(), re.DOTALL | re.MULTILINE)


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
def test_the_scenarios_of_a_page_meet_their_acceptance(page, tmp_path):
    for number, text in enumerate(blocks(page, "yaml")):
        file = tmp_path / f"{number}.yaml"
        file.write_text(text)
        (expected,) = yaml_load(data=text)
        name, scenario = load(str(file))
        assert name == expected
        assert run(name, scenario, tmp_path / "run").verdict == "passed"


def spoken(page):
    """What a page says in code: its blocks for shells, and what stands in backticks."""
    text = page.read_text()
    fenced = re.findall(r"^```(\w*).*?\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    shells = "".join(code for language, code in fenced if language in {"", "sh"})
    return [*shells.splitlines(), *re.findall(r"`([^`\n]+)`", text)]


@pytest.mark.parametrize("page", PAGES, ids=IDS)
def test_every_command_named_is_one(page):
    # A page names a command or an option that was renamed.
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


@pytest.mark.parametrize("page", PAGES, ids=IDS)
def test_what_is_made_and_run_exists(page):
    # A target that make does not know, or a script that was moved.
    makefile = (ROOT / "Makefile").read_text()
    for line in spoken(page):
        for target in re.findall(r"^\s*make ([a-z][a-z-]*)", line):
            assert re.search(rf"^{target}:", makefile, re.MULTILINE), line
        for script in re.findall(r"python[0-9.]* ([a-z]\S*\.py)", line):
            assert (ROOT / script).exists(), line


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
