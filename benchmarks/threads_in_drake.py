"""What two threads of one process can reach that each step a diagram of their own.

Run from the root of the project: `python -m benchmarks.threads_in_drake`. Takes half a minute.

pydrake holds the interpreter's lock through `AdvanceTo`; native contact lets go of it. If a step
has it for a share s of its time, threads do at most 1/s times what one does, and two that meet by
chance 2/(1 + s²) times. Shares are of the thread's processor time, so they hold on a busy machine;
the ratio of wall-clock times beside them does not.
"""

from __future__ import annotations

import statistics
import threading
import time
import warnings
from collections.abc import Callable
from typing import Any

from pydrake.geometry import Box, Cylinder
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from contact_toolkit import ContactModel, StepSolver
from systems import AddNonlinearDamperContact, ContactConfig

REPEATS = 10
# name: (bodies, shape, resolution, simulated time [s] of a turn)
CASES = {
    "one box": (1, Box(0.1, 0.1, 0.1), None, 0.5),
    "ten boxes": (10, Box(0.1, 0.1, 0.1), None, 0.2),
    "ten cylinders, fine": (10, Cylinder(0.05, 0.1), 0.01, 0.05),
}


def at_rest(bodies: int, shape: Box | Cylinder, resolution: float | None) -> Simulator:
    """Bodies that have fallen on a table, on a discrete plant of 2 ms."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.002)
    rough, world = CoulombFriction(0.5, 0.5), plant.world_body()
    below = RigidTransform([0, 0, -0.05])
    plant.RegisterCollisionGeometry(world, below, Box(4, 4, 0.1), "table", rough)
    for i in range(bodies):
        body = plant.AddRigidBody(f"body{i}", SpatialInertia.SolidBoxWithMass(1, 0.1, 0.1, 0.1))
        plant.RegisterCollisionGeometry(body, RigidTransform(), shape, "shape", rough)
        place = [0.25 * (i % 3), 0.25 * (i // 3), 0.1 + 0.01 * i]
        X_WB = RigidTransform(RollPitchYaw(0.1 * i, 0.2, 0.3), place)
        plant.SetDefaultFloatingBaseBodyPose(body, X_WB)
    plant.Finalize()
    config = ContactConfig(resolution=resolution, initial_overlap="warn")
    AddNonlinearDamperContact(builder, plant, scene_graph, config=config)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(0.5)
    return simulator


class LockFree:
    """Adds up the processor time of calls that let go of the lock."""

    def __init__(self) -> None:
        self.seconds = 0.0
        for cls, names in (
            (ContactModel, ("find", "forces", "evaluate", "advance", "advance_implicitly")),
            (StepSolver, ("solve", "solve_under_gravity")),
        ):
            for name in names:
                setattr(cls, name, self._timed(getattr(cls, name)))

    def _timed(self, method: Callable[..., Any]) -> Callable[..., Any]:
        def call(*args: Any) -> Any:
            began = time.thread_time()
            result = method(*args)
            self.seconds += time.thread_time() - began
            return result

        return call


def advance(simulator: Simulator, duration: float) -> None:
    simulator.AdvanceTo(simulator.get_context().get_time() + duration)


def main() -> None:
    warnings.simplefilter("ignore")
    free = LockFree()
    for name, (bodies, shape, resolution, duration) in CASES.items():
        simulators = [at_rest(bodies, shape, resolution) for _ in range(2)]
        shares, alone, beside = [], [], []
        for _ in range(REPEATS):
            free.seconds, began, clock = 0.0, time.thread_time(), time.perf_counter()
            advance(simulators[0], duration)
            shares.append(1 - free.seconds / (time.thread_time() - began))
            alone.append(time.perf_counter() - clock)
            advance(simulators[1], duration)
            threads = [threading.Thread(target=advance, args=(s, duration)) for s in simulators]
            clock = time.perf_counter()
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            beside.append(time.perf_counter() - clock)
        s = statistics.median(shares)
        ratio = 2 * statistics.median(alone) / statistics.median(beside)
        print(
            f"{name}: lock held for {s:.0%}; two threads do at most {min(2, 1 / s):.2f}, by chance "
            f"{2 / (1 + s * s):.2f}, in this run {ratio:.2f} times what one does"
        )


if __name__ == "__main__":
    main()
