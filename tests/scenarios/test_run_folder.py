"""Run folders: no run is ever lost, mixed with another, or told to be what it is not."""

import textwrap
from pathlib import Path

import pytest

from scenarios.format.errors import ScenarioError
from scenarios.run_folder import RunFolder
from tests.support.interrupted import interrupted_at


def fill(folder, text):
    partial = folder.open()
    (partial / "scenario.yaml").write_text(text)
    return partial


@pytest.fixture
def earlier(tmp_path):
    folder = RunFolder(tmp_path / "run")
    fill(folder, "earlier")
    return folder.keep()


def text(target):
    return (target / "scenario.yaml").read_text()


def test_the_target_appears_only_when_the_run_is_kept(tmp_path):
    """A half-written run would be taken for a whole one."""
    folder = RunFolder(tmp_path / "run")
    partial = fill(folder, "new")
    assert not (tmp_path / "run").exists()
    assert folder.keep() == tmp_path / "run"
    assert text(tmp_path / "run") == "new"
    assert not partial.exists()


def test_an_earlier_run_is_refused_before_anything_is_written(earlier, tmp_path):
    """Results would be lost without a question."""
    with pytest.raises(ScenarioError, match="run: holds an earlier run; --force replaces it"):
        RunFolder(earlier).open()
    assert text(earlier) == "earlier"
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_replacing_happens_when_the_new_run_is_whole(earlier, tmp_path):
    """A failed replacement would leave neither run."""
    folder = RunFolder(earlier, replace=True)
    fill(folder, "later")
    assert text(earlier) == "earlier"
    folder.keep()
    assert text(earlier) == "later"
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_a_discarded_run_leaves_the_earlier_one(earlier, tmp_path):
    """A mistake in --set would cost the earlier run."""
    folder = RunFolder(earlier, replace=True)
    fill(folder, "mistaken")
    folder.discard()
    assert text(earlier) == "earlier"
    assert [path.name for path in tmp_path.iterdir()] == ["run"]


def test_the_second_of_two_runs_into_one_folder_is_told(tmp_path):
    """Two runs would write each other's files."""
    first = RunFolder(tmp_path / "run")
    fill(first, "first")
    with pytest.raises(ScenarioError, match="another run is writing it"):
        RunFolder(tmp_path / "run").open()
    first.keep()
    assert text(tmp_path / "run") == "first"


def test_what_a_killed_run_left_does_not_get_into_the_next(tmp_path):
    """Leftovers would be mixed in, or would lock the folder for ever."""
    (tmp_path / ".run.partial" / "figures").mkdir(parents=True)
    (tmp_path / ".run.partial" / "series.parquet").touch()
    folder = RunFolder(tmp_path / "run")
    assert list(folder.open().iterdir()) == []
    folder.discard()


def test_a_run_whose_place_was_taken_meanwhile_goes_beside_it(tmp_path):
    """The later of two would be lost, or overwrite the other."""
    folder = RunFolder(tmp_path / "run")
    fill(folder, "slow")
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "scenario.yaml").write_text("quick")
    assert folder.keep() == tmp_path / "run-2"
    assert text(tmp_path / "run") == "quick"
    assert text(tmp_path / "run-2") == "slow"


@pytest.mark.parametrize("replace", [False, True])
def test_a_folder_that_is_no_run_is_never_replaced(tmp_path, replace):
    """--force with a slip of the pen would empty a home folder."""
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "chapter.tex").touch()
    with pytest.raises(ScenarioError, match="holds files that are no run"):
        RunFolder(tmp_path / "thesis", replace=replace).open()
    assert (tmp_path / "thesis" / "chapter.tex").exists()


@pytest.mark.parametrize(
    ("target", "reason"), [("/sys/run", "Operation not permitted|Permission denied|Read-only"),
                           ("file/run", "Not a directory|File exists")]
)  # fmt: skip
def test_a_place_that_cannot_be_written_is_named(tmp_path, monkeypatch, target, reason):
    """The complaint would be a traceback, or name a hidden folder that nobody asked for."""
    (tmp_path / "file").touch()
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ScenarioError, match=f"^{target}: cannot be made: ({reason}); choose"):
        RunFolder(Path(target)).open()


@pytest.mark.parametrize("name", ["with space", "ünïcode", "dots.in.it", "deep/in/there", "."])
def test_odd_paths_work(tmp_path, monkeypatch, name):
    """A path with blanks, dots or missing parents would break the renaming."""
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    folder = RunFolder(Path(name))
    fill(folder, "odd")
    assert text(folder.keep()) == "odd"


SETUP = """
import sys, time, warnings
from pathlib import Path
import scenarios.runner as runner
from scenarios.cli import app
real = runner.assemble
def slow(*a, **k):
    print("assembling", flush=True)
    time.sleep(60)
runner.assemble = slow
sys.argv = ["contact-toolkit", "run", "rock_n_stack", "--out", sys.argv[1]]
app()
"""


def test_ctrl_c_in_set_up_says_so_and_keeps_nothing(tmp_path):
    """It would hang, show a traceback, or leave a run that never ran."""
    said = interrupted_at("assembling", textwrap.dedent(SETUP), str(tmp_path / "run"))
    assert "interrupted during set-up; nothing was kept" in said
    assert list(tmp_path.iterdir()) == []
