"""The dataset of a sweep: whatever happens, rows are whole, and none is there twice."""

import json
import os
import resource
import subprocess

import pytest
from sweep_scenes import SCENARIO, STUDY, plan_of, rows_of

from scenarios.format.errors import ScenarioError
from scenarios.sweep.dataset import Dataset


@pytest.fixture
def plan(tmp_path):
    return plan_of(tmp_path)


def row(run, **changes):
    said = {"key": run.key, "run": run.number, "seed": run.seed, "verdict": "passed"}
    return said | {"highest [mm]": 32.5, "wall_time": 0.1} | run.inputs | changes


def test_rows_come_back_as_they_were_in_the_order_of_the_runs(plan, tmp_path):
    dataset = Dataset(tmp_path / "sweep", plan)
    a, b, c = plan.runs()[:3]
    with dataset.writing(resume=False):
        dataset.add([row(c), row(a, verdict="error", reason="it broke")])
        dataset.add([row(b)])
    table = Dataset.load(tmp_path / "sweep").read().to_pylist()
    assert [r["run"] for r in table] == [0, 1, 2]
    assert table[0]["reason"] == "it broke"
    assert table[1]["highest [mm]"] == 32.5
    assert {k: table[2][k] for k in c.inputs} == c.inputs
    assert Dataset.load(tmp_path / "sweep").plan.runs() == plan.runs()


def test_a_second_writer_is_refused_while_the_first_is_at_it(plan, tmp_path):
    dataset = Dataset(tmp_path / "sweep", plan)
    with dataset.writing(resume=False):
        second = Dataset(tmp_path / "sweep", plan)
        with pytest.raises(ScenarioError, match="another sweep is writing"):  # noqa: SIM117
            with second.writing(resume=True):
                pass
        dataset.add([row(plan.runs()[0])])
    with Dataset(tmp_path / "sweep", plan).writing(resume=True):
        assert len(rows_of(dataset)) == 1


def test_an_earlier_sweep_is_only_gone_on_with_when_asked_and_when_it_is_the_same(plan, tmp_path):
    folder = tmp_path / "sweep"
    with Dataset(folder, plan).writing(resume=False):
        Dataset(folder, plan).add([row(plan.runs()[0])])

    def take_up(other, *, resume=True):
        with Dataset(folder, other).writing(resume=resume):
            pass

    with pytest.raises(ScenarioError, match="holds an earlier sweep; --resume goes on"):
        take_up(plan, resume=False)
    with pytest.raises(ScenarioError, match="the scenario file changed since"):
        take_up(plan_of(tmp_path, scenario=SCENARIO.replace("density: 500", "density: 501")))
    with pytest.raises(ScenarioError, match="parameters changed since"):
        take_up(plan_of(tmp_path, STUDY.replace("max: 8.0e+7", "max: 9.0e+7")))
    with pytest.raises(ScenarioError, match="random_seed changed since"):
        take_up(plan_of(tmp_path, STUDY + "  random_seed: 3\n"))
    take_up(plan_of(tmp_path, STUDY.replace("runs: 6", "runs: 60") + "  time_out: 5\n"))
    assert len(rows_of(Dataset(folder, plan))) == 1


def test_a_corrupt_file_is_named_and_touches_no_other(plan, tmp_path):
    dataset = Dataset(tmp_path / "sweep", plan)
    runs = plan.runs()
    with dataset.writing(resume=False):
        dataset.add([row(run) for run in runs[:3]])
        dataset.add([row(run) for run in runs[3:]])
    first = dataset.parts()[0]
    contents = bytearray(first.read_bytes())
    contents[40] ^= 0xFF  # within the first column of the only row group
    first.write_bytes(contents)
    with pytest.raises(ScenarioError, match=rf"{first.name}: cannot be read .* --resume repeats"):
        dataset.read()
    first.write_bytes(bytes(contents[:100]))  # half a file, as no sweep of ours leaves it
    with pytest.raises(ScenarioError, match="cannot be read"):
        dataset.read()
    first.unlink()
    assert {r["run"] for r in rows_of(dataset).values()} == {3, 4, 5}


def test_a_killed_writer_leaves_nothing_half(plan, tmp_path):
    dataset = Dataset(tmp_path / "sweep", plan)
    with dataset.writing(resume=False):
        dataset.add([row(plan.runs()[0])])
    left = tmp_path / "sweep" / "rows" / ".000002.parquet.tmp"
    left.write_bytes(b"PAR1 half a")
    assert len(rows_of(dataset)) == 1
    with dataset.writing(resume=True):
        assert not left.exists()


def check_that_rows_survive(dataset, runs):
    with pytest.raises(OSError, match=r"too large|No space left") as caught:
        dataset.add([row(run, reason=os.urandom(20_000).hex()) for run in runs[1:]])
    assert caught.value.filename is not None
    assert len(rows_of(dataset)) == 1
    assert [path.name for path in (dataset.folder / "rows").iterdir()] == ["000001.parquet"]


def test_a_disk_that_takes_no_more_costs_only_what_was_not_written(plan, tmp_path):
    # By a limit on the size of files: the same failure of write(), whoever runs the test.
    dataset = Dataset(tmp_path / "sweep", plan)
    with dataset.writing(resume=False):
        dataset.add([row(plan.runs()[0])])
        before = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, before[1]))
        try:
            check_that_rows_survive(dataset, plan.runs())
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)
        dataset.add([row(run) for run in plan.runs()[1:]])
    assert len(rows_of(dataset)) == 6


@pytest.mark.skipif(os.geteuid() != 0, reason="mounts a file system")
def test_a_full_file_system_too(plan, tmp_path):
    folder = tmp_path / "small"
    folder.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(folder)], check=False
    )
    if mounted.returncode:
        pytest.skip("mounts are not allowed here")
    try:
        dataset = Dataset(folder / "sweep", plan)
        with dataset.writing(resume=False):
            dataset.add([row(plan.runs()[0])])
            check_that_rows_survive(dataset, plan.runs())
    finally:
        subprocess.run(["umount", str(folder)], check=True)


def test_other_files_are_not_taken_for_a_sweep(plan, tmp_path):
    (tmp_path / "photos").mkdir()
    (tmp_path / "photos" / "cat.png").write_bytes(b"")
    with pytest.raises(ScenarioError, match="holds files that are no sweep"):  # noqa: SIM117
        with Dataset(tmp_path / "photos", plan).writing(resume=True):
            pass
    with pytest.raises(ScenarioError, match="not the folder of a sweep"):
        Dataset.load(tmp_path / "photos")
    (tmp_path / "photos" / "sweep.json").write_text(json.dumps({"name": "x"}))
    with pytest.raises(ScenarioError, match="does not describe a sweep"):
        Dataset.load(tmp_path / "photos")
