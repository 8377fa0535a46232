"""Several runs from the terminal: Ctrl-C stops all, mistakes are told before the first."""

import io

import pytest
from rich.console import Console

from scenarios.batch import FAILED, PASSED, STOPPED, Batch
from scenarios.format.errors import NotInstalledError, ScenarioError
from scenarios.report.summary import Summary

NAMES = ["rock_n_stack", "rock_n_stack_unit", "rock_n_stack_energy"]


@pytest.fixture
def batch(tmp_path, monkeypatch):
    """A batch whose runs end as told, without simulating."""
    text = io.StringIO()
    ran = []

    def make(*verdicts):
        ends = iter(verdicts)

        def pretend(_console, name, _scenario, folder, **_):
            ran.append(name)
            end = next(ends)
            if isinstance(end, BaseException):
                raise end
            return Summary(name, verdict=end, folder=str(folder))

        monkeypatch.setattr("scenarios.batch.run_with_progress", pretend)
        return Batch(Console(file=text, width=200), [], replace=False, live=False)

    (tmp_path / "out").mkdir()
    make.text, make.ran, make.out = text, ran, tmp_path / "out"
    return make


def test_all_run_and_a_table_is_written(batch):
    """The table of results would be typed by hand."""
    assert batch("passed", "passed", "passed").run_all(NAMES, batch.out) == PASSED
    assert batch.ran == NAMES
    table = (batch.out / "RESULTS.md").read_text()
    assert all(f"`{name}`" in table for name in NAMES)


def test_the_table_goes_between_the_marks_of_a_document(batch):
    """The README would keep old results, or lose what stands around them."""
    document = batch.out / "README.md"
    document.write_text("before\n<!-- scenarios -->\nold\n<!-- /scenarios -->\nafter\n")
    batch("passed", "passed", "passed").run_all(NAMES, batch.out, document)
    results = (batch.out / "RESULTS.md").read_text()
    marked = f"<!-- scenarios -->\n{results}<!-- /scenarios -->"
    assert document.read_text() == f"before\n{marked}\nafter\n"


def test_what_needs_an_absent_package_is_skipped_among_all_and_refused_alone(batch, tmp_path):
    """`run --all` would fail wherever the extra with robot models is not installed."""
    absent = NotInstalledError("packages.arm: no_such_robot is not installed; pip install it")
    assert batch("passed", absent, "passed").run_all(NAMES, batch.out) == PASSED
    assert (
        f"{NAMES[1]}: skipped: packages.arm: no_such_robot is not installed"
        in batch.text.getvalue()
    )
    row = (batch.out / "RESULTS.md").read_text().splitlines()[3]
    assert row.startswith(f"| `{NAMES[1]}`")
    assert "no_such_robot" in row
    assert "skipped" in row
    with pytest.raises(ScenarioError, match="no_such_robot"):
        batch(absent).run_one(NAMES[0], tmp_path / "alone")


def test_a_document_without_marks_is_told_before_the_first_run(batch):
    """Ten minutes would be simulated before the complaint."""
    (batch.out / "README.md").write_text("no marks")
    with pytest.raises(ScenarioError, match="no lines <!-- scenarios -->"):
        batch("passed").run_all(NAMES, batch.out, batch.out / "README.md")
    assert batch.ran == []


def test_what_takes_minutes_is_told_before_the_first_run(batch):
    """A user would take `run --all` for hung."""
    batch("passed", "interrupted").run_all(["incline", "part_bin_hundred"], batch.out)
    before, _, _ = batch.text.getvalue().partition("scenario")
    assert "minutes each: part_bin_hundred\n" in before
    batch("passed").run_all(["bouncing_ball"], batch.out)
    assert batch.text.getvalue().count("minutes each") == 1


def test_ctrl_c_stops_all_and_says_how_many_were_left(batch):
    """Ctrl-C would only go on to the next of thirty runs."""
    assert batch("passed", "interrupted").run_all(NAMES, batch.out) == STOPPED
    assert batch.ran == NAMES[:2]
    assert "stopped; 1 scenarios were not run" in batch.text.getvalue()


def test_ctrl_c_in_set_up_stops_all_too(batch, capsys):
    """It would be taken for a failed scenario."""
    assert batch(KeyboardInterrupt()).run_all(NAMES, batch.out) == STOPPED
    assert batch.ran == NAMES[:1]
    assert "interrupted during set-up; nothing was kept" in capsys.readouterr().err


def test_one_that_cannot_be_run_does_not_stop_the_others(batch):
    """One scenario's mistake would cost the results of all others."""
    ends = (ScenarioError("no such file"), RuntimeError("integrator"), "passed")
    assert batch(*ends).run_all(NAMES, batch.out) == FAILED
    assert batch.ran == NAMES


def test_a_folder_in_the_way_is_told_before_the_first_run(batch):
    """Twenty minutes would be simulated before the complaint."""
    (batch.out / NAMES[-1]).mkdir()
    (batch.out / NAMES[-1] / "scenario.yaml").touch()
    with pytest.raises(ScenarioError, match="holds an earlier run"):
        batch("passed").run_all(NAMES, batch.out)
    assert batch.ran == []
