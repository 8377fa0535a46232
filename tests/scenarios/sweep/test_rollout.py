"""Rollouts: one row, whatever happens, and the same as a run into a folder."""

import os
import re
import signal
import threading
import time
from dataclasses import replace

import numpy as np
import pytest
from sweep_scenes import plan_of

import scenarios
from scenarios.format.errors import ScenarioError
from scenarios.runner import run
from scenarios.sweep import rollout as rollouts
from scenarios.sweep.isolated import GRACE, IsolatedRuns, Task


@pytest.fixture
def plan(tmp_path):
    return plan_of(tmp_path)


def test_a_rollout_has_the_figures_of_a_run_into_a_folder(plan, tmp_path):
    summary = run("drop", plan.base.load(["contact.alpha=0.4"]), tmp_path / "run")
    outcome = scenarios.rollout(str(plan.base.path), {"contact.alpha": 0.4}, record=True)
    assert outcome.figures == summary.figures
    assert outcome.verdict == summary.verdict
    # Falls from rest until it touches: z = 40 mm − g t²/2, but for the plant's steps.
    z, t = outcome.record["ball.z"][:15], outcome.record["time"][:15]
    np.testing.assert_allclose(z, 0.04 - 9.81 / 2 * (t**2 + 0.002 * t), atol=1e-9)


READ_FROM = {
    "ball.z": set(),
    "ball.wx": set(),
    "kinetic_energy": set(),
    "ball.ty": {"wrenches"},
    "ball.g_force": {"wrenches"},
    "facet_pairs": {"counts"},
    "elastic_energy": {"energies"},
    "step_loss": {"energies"},
    "passes": {"passes"},
}


def test_a_run_logs_only_what_its_figures_read_and_reads_the_same(plan, monkeypatch):
    # Wrenches, energies and contacts that nobody reads cost a twentieth of a run.
    logged = []
    assemble = rollouts.assemble

    def assemble_and_look(*args, **options):
        assembly = assemble(*args, **options)
        logged.append(set(assembly.logs))
        return assembly

    monkeypatch.setattr(rollouts, "assemble", assemble_and_look)

    def rollout(columns, **options):
        figures = {column: f'travel("{column}")' for column in columns}
        inputs = {"acceptance": f"{{figures: {figures}}}", "swept_monitor": "count"}
        return scenarios.rollout(plan.base, inputs, **options)

    whole = rollout(READ_FROM, record=True)
    assert logged.pop() == {"state"}.union(*READ_FROM.values())
    assert set(READ_FROM) < set(whole.record.columns)
    for column, behind in READ_FROM.items():
        alone = rollout([column])
        assert alone.figures == {column: whole.figures[column]}, alone.reason
        assert logged.pop() == {"state"} | behind


def test_the_same_inputs_give_the_same_bits_whatever_ran_before(plan):
    # Meshes, hierarchies and fields of the run before are used again.
    first = scenarios.rollout(plan.base, {"contact.k": 7e7})
    scenarios.rollout(plan.base, {"contact.k": 3e7, "parts.ball.parameters.radius": 0.018})
    assert scenarios.rollout(plan.base, {"contact.k": 7e7}).figures == first.figures


def test_what_runs_have_in_common_is_prepared_once(plan, monkeypatch):
    # Each run would make the hierarchies and nodes of all its meshes anew.
    meshes = []
    assemble = rollouts.assemble

    def assemble_and_look(*args, **options):
        assembly = assemble(*args, **options)
        meshes.append({each.name: each.mesh for each in assembly.contact.model.geometries})
        return assembly

    monkeypatch.setattr(rollouts, "assemble", assemble_and_look)
    for radius in (0.02, 0.018):
        scenarios.rollout(plan.base, {"parts.ball.parameters.radius": radius})
    first, second = meshes
    assert first["plate/plate::collision"] is second["plate/plate::collision"]
    assert first["ball/ball::collision"] is not second["ball/ball::collision"]


@pytest.mark.parametrize(
    ("inputs", "verdict", "said"),
    [
        ({"parts.ball.parameters.radius": -1}, "error", "radius must be positive"),
        ({"initial_velocity": "{ball: {ball: [0, 0, 0, 0, 0, 1.0e+12]}}"}, "error", "diverged at"),
        ({"acceptance.limits": "{'highest [mm]': {at_least: 99}}"}, "failed", "^$"),
    ],
)
def test_what_goes_wrong_in_a_run_is_its_reason(plan, inputs, verdict, said):
    outcome = scenarios.rollout(plan.base, inputs)
    assert outcome.verdict == verdict
    assert re.search(said, outcome.reason)


def test_a_run_that_takes_too_long_ends_between_steps(plan):
    outcome = scenarios.rollout(plan.base, {"simulation_duration": 500}, time_out=1.0)
    assert outcome.verdict == "timed out"
    assert outcome.reason == "not done after 1 s of wall-clock time"
    assert not outcome.figures


def test_keys_that_the_scenario_does_not_have_are_the_callers_mistake(plan):
    with pytest.raises(ScenarioError, match=r"unknown key contact.kay"):
        scenarios.rollout(plan.base, {"contact.kay": 1})


@pytest.fixture
def isolated(plan):
    made = []

    def make(**changes):
        said = {"time_out": 30.0, "memory_limit": 2.0} | changes
        base = plan.base
        task = Task(base.name, base.raw, str(base.path), plan.identity["versions"], **said)
        made.append(IsolatedRuns(task))
        return made[-1]

    yield make
    for runs in made:
        runs.close()


LONG = ["simulation_duration=500"]


def signal_in(runs, number):
    """Send a signal to the process for runs once it is at work."""

    def send():
        while runs._process is None:
            time.sleep(0.01)
        time.sleep(0.5)
        os.kill(runs._process.pid, number)

    threading.Thread(target=send, daemon=True).start()


def test_a_process_that_dies_or_hangs_costs_its_run_only(isolated, plan):
    runs = isolated(time_out=4.0)
    good = runs.run([])
    assert good.figures == scenarios.rollout(plan.base).figures
    signal_in(runs, signal.SIGKILL)
    assert runs.run(LONG).reason == "the process died by SIGKILL"
    assert runs.run([]).figures == good.figures
    signal_in(runs, signal.SIGSTOP)
    hung = runs.run(LONG)
    assert (hung.verdict, hung.reason) == (
        "timed out",
        f"hung: not done after {GRACE * 4:g} s, and had to be killed",
    )


def test_a_process_that_grows_too_large_is_ended(isolated):
    runs = isolated()
    runs.run([])
    runs.task = replace(runs.task, memory_limit=0.05)  # less than Drake takes
    assert runs.run(LONG).reason == "used more than its 0.05 GB of memory"


def test_other_versions_on_a_worker_are_no_rows(isolated):
    runs = isolated()
    runs.task.versions["drake"] = "1.0"
    with pytest.raises(ScenarioError, match=r"a worker has other versions .* not .* drake 1\.0"):
        runs.run([])
