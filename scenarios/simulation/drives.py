"""A system that drives joints by the schedules of a scenario."""

from __future__ import annotations

import bisect
import math

from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from scenarios.format.joint import Drive
from scenarios.simulation.joints import find_joint


class JointDrives(LeafSystem):
    """Plant state in, actuation of all actuators out; actuators without a drive get 0."""

    def __init__(self, plant: MultibodyPlant, drives: dict[str, Drive]) -> None:
        super().__init__()
        self._num_positions = plant.num_positions()
        self._driven: list[tuple[Course, int, int, int]] = []
        by_joint = {
            plant.get_joint_actuator(index).joint().index(): plant.get_joint_actuator(index)
            for index in plant.GetJointActuatorIndices()
        }
        for name, drive in drives.items():
            joint = find_joint(plant, f"drives.{name}", name)
            self._driven.append(
                (
                    Course(drive),
                    by_joint[joint.index()].input_start(),
                    joint.position_start(),
                    self._num_positions + joint.velocity_start(),
                )
            )
        self._num_actuators = plant.num_actuated_dofs()
        size = plant.num_positions() + plant.num_velocities()
        self._state = self.DeclareVectorInputPort("state", size)
        self.DeclareVectorOutputPort(
            "actuation",
            self._num_actuators,
            self._drive,
            {self.time_ticket(), self.input_port_ticket(self._state.get_index())},
        )

    def _drive(self, context: Context, output: BasicVector) -> None:
        time, state = context.get_time(), self._state.Eval(context).tolist()
        actuation = [0.0] * self._num_actuators
        for course, actuator, position, velocity in self._driven:
            actuation[actuator] = course.effort(time, state[position], state[velocity])
        output.SetFromVector(actuation)


class Course:
    """A drive as a function of time. In plain numbers: it is asked at every step for each drive."""

    def __init__(self, drive: Drive) -> None:
        self._drive = drive
        self._times, self._values = map(list, zip(*(drive.schedule or [[0.0, 0.0]]), strict=True))
        self._omega = 2.0 * math.pi * drive.frequency

    def effort(self, time: float, position: float, velocity: float) -> float:
        """Return the force [N] or torque [N m] of the drive."""
        drive = self._drive
        value, rate, second = self.value(time)
        if drive.follows == "force":
            return value
        effort = (
            drive.inertia * second
            + drive.stiffness * (value - position)
            + drive.damping * (rate - velocity)
        )
        return min(max(effort, -drive.force_limit), drive.force_limit)

    def value(self, time: float) -> tuple[float, float, float]:
        """Return the value, its rate, and the second derivative of the oscillation."""
        value, rate = self._scheduled(time)
        drive, omega = self._drive, self._omega
        if not drive.amplitude:
            return value, rate, 0.0
        angle = omega * time + drive.phase
        swing, turn = drive.amplitude * math.sin(angle), drive.amplitude * math.cos(angle)
        return value + swing, rate + omega * turn, -(omega**2) * swing

    def _scheduled(self, time: float) -> tuple[float, float]:
        times, values = self._times, self._values
        after = bisect.bisect_right(times, time)
        if after in (0, len(times)):
            return values[max(after - 1, 0)], 0.0
        rate = (values[after] - values[after - 1]) / (times[after] - times[after - 1])
        return values[after - 1] + rate * (time - times[after - 1]), rate
