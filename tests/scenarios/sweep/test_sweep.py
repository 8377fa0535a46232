"""Sweeps: exactly the rows that an undisturbed one has, whatever it went through."""

import os
import re
import signal
import subprocess
import sys
import time
from contextlib import contextmanager

import psutil
import pytest
from sweep_scenes import STUDY, plan_of, rows_of, write_study

from scenarios.format.errors import ScenarioError
from scenarios.sweep import schedule
from scenarios.sweep.dataset import Dataset
from scenarios.sweep.rollout import run_once
from scenarios.sweep.sweep import sweep

pytest.importorskip("distributed", reason="the extra `sweep`")

BAD = """
    trouble:
      choices:
        none: []
        part: [parts.ball.parameters.radius=-1]
        speed: ['initial_velocity={ball: {ball: [0, 0, 0, 0, 0, 1.0e+12]}}']
        time: [simulation_duration=500]
"""


def command(*arguments, **options):
    program = "from scenarios.cli import app; app()"
    return subprocess.Popen(
        [sys.executable, "-c", program, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        **options,
    )


def ends_with(process, status):
    said = process.communicate(timeout=300 + RUNS)[0]
    assert process.returncode == status, said
    return said


def rows_files(out):
    return list((out / "rows").glob("[!.]*.parquet"))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("sweeps")


def test_a_sweep_has_the_figures_of_its_rollouts_one_by_one_and_goes_on(folder):
    plan, seen = plan_of(folder), []
    few = plan_of(folder, STUDY.replace("runs: 6", "runs: 4"))
    sweep(few, folder / "whole", workers=2, progress=lambda tally: seen.append(tally.done))
    assert seen == [0, 1, 2, 3, 4]
    before = rows_of(Dataset.load(folder / "whole"))
    tally = sweep(plan, folder / "whole", workers=1, resume=True)
    assert (tally.before, tally.done, tally.total) == (4, 6, 6)
    rows = rows_of(Dataset.load(folder / "whole"))
    assert rows.items() >= before.items()  # nothing repeated or lost
    assert [row["run"] for row in rows.values()] == list(range(6))
    for run in plan.runs():
        alone = run_once("drop", plan.base.load(run.overrides))
        row = rows[run.key]
        assert {name: row[name] for name in run.inputs} == run.inputs
        assert {name: row[name] for name in alone.figures} == alone.figures
        assert (row["verdict"], row["seed"]) == (alone.verdict, run.seed)
    assert {row["verdict"] for row in rows.values()} == {"passed", "failed"}


def test_nobody_at_the_address_is_told_and_no_row_written(folder, monkeypatch):
    monkeypatch.setattr(schedule, "ANSWER", 1.0)
    with pytest.raises(ScenarioError, match=r"no Dask scheduler answers at tcp://127.0.0.1:9 "):
        sweep(plan_of(folder), folder / "nobody", scheduler="tcp://127.0.0.1:9")
    assert not rows_of(Dataset.load(folder / "nobody"))


@pytest.mark.slow
def test_a_run_that_breaks_diverges_or_takes_too_long_is_a_row(folder):
    (folder / "bad").mkdir()
    text = STUDY.replace("runs: 6", "sampling: grid\n  time_out: 6")
    text = re.sub(r"(?s)  parameters:.*", "  parameters:" + BAD, text)
    sweep(plan_of(folder / "bad", text), folder / "bad" / "sweep", workers=1)
    rows = rows_of(Dataset.load(folder / "bad" / "sweep")).values()
    got = {row["trouble"]: (row["verdict"], row["reason"]) for row in rows}
    assert got["part"] == ("error", "part 'icosphere': radius must be positive, not -1.0")
    assert got["speed"][0] == "error"
    assert "diverged at" in got["speed"][1]
    assert got["time"] == ("timed out", "not done after 6 s of wall-clock time")
    assert got["none"][0] in {"passed", "failed"}


@contextmanager
def dask_cluster(folder, workers):
    """A scheduler and workers started by hand, and their address."""
    file = folder / "scheduler.json"
    scheduler = [sys.executable, "-m", "distributed.cli.dask_scheduler"]
    worker = [sys.executable, "-m", "distributed.cli.dask_worker"]
    common = ["--scheduler-file", str(file), "--no-dashboard"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": folder}
    started = [subprocess.Popen([*scheduler, *common, "--port", "0"], **quiet)]
    try:
        while not file.is_file():
            time.sleep(0.1)
        address = re.search(r'"address": "([^"]+)"', file.read_text())[1]
        one = [*worker, *common, "--nthreads", "1"]
        started += [subprocess.Popen(one, **quiet) for _ in range(workers)]
        yield address
    finally:
        for process in reversed(started):
            process.terminate()
            try:
                process.wait(15)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def descendants(process, words):
    """The processes below one whose command line has these words."""
    found = []
    for child in psutil.Process(process.pid).children(recursive=True):
        try:
            if words in " ".join(child.cmdline()):
                found.append(child)
        except psutil.NoSuchProcess:
            continue
    return found


def wait_for(condition, seconds=120.0):
    deadline = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.05)
    return found


RUNS = int(os.environ.get("CONTACT_TOOLKIT_SWEEP_RUNS", "40"))  # 2000 take an hour of a core
MANY = STUDY.replace("runs: 6", f"runs: {RUNS}")


@pytest.fixture(scope="module")
def undisturbed(folder):
    plan = plan_of(folder, MANY)
    sweep(plan, folder / "undisturbed", workers=2)
    rows = rows_of(Dataset.load(folder / "undisturbed"))
    assert len(rows) == RUNS
    return rows


@pytest.mark.slow
def test_killed_once_a_worker_killed_once_and_resumed_has_the_same_rows(folder, undisturbed):
    study, out = write_study(folder, MANY), folder / "killed"

    def started(*more):
        return command("sweep", study, "--out", out, "--workers", 2, *more)

    first = started()
    wait_for(lambda: rows_files(out))
    first.kill()
    first.communicate()
    kept = rows_of(Dataset.load(out))
    assert 0 < len(kept) < RUNS
    second = started("--resume")
    worker = wait_for(lambda: descendants(second, "multiprocessing.spawn"))
    wait_for(lambda: descendants(second, "scenarios.sweep.run_process"))
    time.sleep(1.0)
    worker[0].kill()
    ends_with(second, 0)
    rows = rows_of(Dataset.load(out))
    assert rows == undisturbed
    assert rows.items() >= kept.items()


@pytest.mark.slow
def test_a_scheduler_started_by_hand_gives_the_same_rows(folder, undisturbed):
    with dask_cluster(folder, workers=2) as address:
        sweep(plan_of(folder, MANY), folder / "elsewhere", scheduler=address)
    assert rows_of(Dataset.load(folder / "elsewhere")) == undisturbed


@pytest.mark.slow
def test_two_sweeps_into_one_folder_are_one_and_a_refusal(folder, undisturbed):
    study, out = write_study(folder, MANY), folder / "two"
    first = command("sweep", study, "--out", out, "--workers", 2)
    wait_for((out / "sweep.json").is_file)
    first.send_signal(signal.SIGSTOP)  # lest it be done before the second has begun
    second = command("sweep", study, "--out", out, "--workers", 1, "--resume")
    try:
        assert "another sweep is writing" in " ".join(ends_with(second, 2).split())
    finally:
        first.send_signal(signal.SIGCONT)
    ends_with(first, 0)
    assert rows_of(Dataset.load(out)) == undisturbed


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_done(folder, undisturbed):
    study, out = write_study(folder, MANY), folder / "stopped"
    process = command("sweep", study, "--out", out, "--workers", 2, start_new_session=True)
    wait_for(lambda: rows_files(out))
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does, to workers too
    said = ends_with(process, 130)
    assert "stopped; --resume goes on" in said
    assert "Traceback" not in said
    kept = rows_of(Dataset.load(out))
    assert kept.items() <= undisturbed.items()
    assert 0 < len(kept) < RUNS
    ends_with(command("sweep", study, "--out", out, "--workers", 2, "--resume"), 0)
    assert rows_of(Dataset.load(out)) == undisturbed


@pytest.mark.slow
def test_a_full_disk_ends_a_sweep_with_its_name_and_keeps_what_was_written(folder):
    (folder / "full").mkdir()
    plan = plan_of(folder / "full")
    out = folder / "full" / "sweep"
    sweep(plan, out, workers=1)
    more = plan_of(folder / "full", STUDY.replace("runs: 6", "runs: 8"))
    before = rows_of(Dataset.load(out))

    def fill():
        import resource

        size = (out / "sweep.json").stat().st_size
        resource.setrlimit(resource.RLIMIT_FSIZE, (size + 200, size + 200))

    study = folder / "full" / "study.yaml"
    process = command("sweep", study, "--out", out, "--workers", 1, "--resume", preexec_fn=fill)
    part = f"rows/{len(rows_files(out)) + 1:06}.parquet"
    assert f"{part}: File too large" in ends_with(process, 2).replace("\n", "")
    assert rows_of(Dataset.load(out)) == before
    assert sweep(more, out, workers=1, resume=True).done == 8
    assert rows_of(Dataset.load(out)).items() >= before.items()


@pytest.mark.slow
def test_an_interrupted_sweep_in_python_says_so(folder):
    plan = plan_of(folder, MANY)

    def interrupt(tally):
        if tally.done == 1:
            signal.raise_signal(signal.SIGINT)

    tally = sweep(plan, folder / "interrupted", workers=1, progress=interrupt)
    assert tally.stopped
    assert 1 <= len(rows_of(Dataset.load(folder / "interrupted"))) < RUNS
