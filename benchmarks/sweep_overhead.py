"""What a run of a sweep costs over its bare simulation, in processor time.

Run from the root of the project: `python -m benchmarks.sweep_overhead`. Takes two minutes.

Bare is `Initialize` and `AdvanceTo` of the same diagram with nothing logged and nobody looking. Run
and bare simulation take turns, and the median of their ratios counts: on a busy machine each is off
by 5 %. What the other processes of a sweep take (worker, scheduler, the one that writes rows) is
measured beside the process for runs, of a sweep with one worker; that process is replaced when it
has grown, which costs a start.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import psutil
from pydrake.multibody.plant import AddMultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from scenarios.format.scenario import Scenario
from scenarios.simulation.assembly import Assembly, add_bodies, drive_joints
from scenarios.sweep.isolated import FRESH
from scenarios.sweep.plan import Plan
from scenarios.sweep.rollout import run_once
from scenarios.sweep.study import load_study
from scenarios.sweep.sweep import Tally, sweep
from systems import AddNonlinearDamperContact

RUNS = 24


def bare(scenario: Scenario) -> Simulator:
    """Return the simulator of a scenario's diagram with nothing logged."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlant(scenario.plant_config, builder)
    with TemporaryDirectory() as folder:
        add_bodies(plant, scenario, Path(folder))
        plant.Finalize()
        drive_joints(builder, plant, scenario)
        contact = AddNonlinearDamperContact(builder, plant, scene_graph, config=scenario.contact)
    return Assembly(builder.Build(), plant, contact, {}).simulator(scenario)


def alone_and_bare(plan: Plan) -> tuple[float, float]:
    """Return what a run takes in its process over its simulation, and this one [s]: medians."""
    warm, *runs = plan.runs()
    run_once("warm", plan.base.load(warm.overrides))
    whole, simulation = np.empty((2, len(runs)))
    for index, run in enumerate(runs):
        began = time.thread_time()
        run_once("run", plan.base.load(run.overrides))
        whole[index] = time.thread_time() - began
        # The last one's bare simulation, lest it find this one's nodes made.
        simulator = bare(plan.base.load(runs[index - 1].overrides))
        began = time.thread_time()
        simulator.Initialize()
        simulator.AdvanceTo(plan.scenario.simulation_duration)
        simulation[index - 1] = time.thread_time() - began
    return float(np.median(whole / simulation)), float(np.median(simulation))


@dataclass
class Usage:
    """Of a sweep's processes until now: processor time [s], and memory [GB] of that for runs."""

    runs: float = 0.0
    others: float = 0.0
    memory: float = 0.0

    @classmethod
    def now(cls) -> Usage:
        usage, me = cls(), psutil.Process()
        for process in (me, *me.children(recursive=True)):
            taken = sum(process.cpu_times()[:2])
            if any("run_process" in word for word in process.cmdline()):
                usage.runs += taken
                usage.memory = process.memory_info().rss / 1e9
            else:
                usage.others += taken
        return usage


def in_a_sweep(plan: Plan) -> tuple[Usage, Usage]:
    """Return the usage of a sweep with one worker after its first run and after its last."""
    seen: dict[int, Usage] = {}

    def look(tally: Tally) -> None:
        if tally.done in (1, tally.total):
            seen[tally.done] = Usage.now()

    with TemporaryDirectory() as folder:
        sweep(plan, Path(folder) / "sweep", workers=1, progress=look)
    return seen[1], seen[plan.study.runs]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=RUNS)
    name, study, base = load_study("grasp_study")
    study.runs = parser.parse_args().runs
    plan = Plan(name, study, base)
    ratio, simulation = alone_and_bare(plan)
    first, last = in_a_sweep(plan)
    beside = (last.others - first.others) / (last.runs - first.runs)
    before_fresh = (FRESH * study.memory_limit - first.memory) * (study.runs - 1)
    many = before_fresh / (last.memory - first.memory)
    shares = {
        "around the simulation": ratio - 1,
        "in other processes": beside * ratio,
        f"of a new process every {many:.0f} runs": first.runs / many / simulation,
    }
    print(f"bare simulation: {simulation:.3f} s; over it:")
    for what, share in (*shares.items(), ("all", sum(shares.values()))):
        print(f"  {share:6.1%} {what}")


if __name__ == "__main__":
    main()
