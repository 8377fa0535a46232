"""The time series of a run: one column per quantity, one row per sample."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray
from pydrake.math import RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, RigidBody
from pydrake.systems.framework import Context

from scenarios.assembly import Assembly

Column = NDArray[np.float64]


@dataclass(frozen=True)
class Record:
    """Columns by name, all of the same length; `units` says what they are measured in."""

    columns: Mapping[str, Column]
    units: Mapping[str, str]

    def __getitem__(self, name: str) -> Column:
        return self.columns[name]

    def last(self, window: float) -> NDArray[np.bool_]:
        """Mark the samples of the last `window` seconds."""
        time = self["time"]
        return np.asarray(time >= time[-1] - window)

    def save(self, path: Path) -> None:
        """Write a Parquet file; the units are metadata of its fields."""
        fields = [
            pa.field(name, pa.float64(), metadata={"unit": self.units[name]})
            for name in self.columns
        ]
        pq.write_table(pa.table(list(self.columns.values()), schema=pa.schema(fields)), path)

    @classmethod
    def load(cls, path: Path) -> Record:
        """Read what `save` wrote."""
        table = pq.read_table(path)
        columns = {name: table[name].to_numpy() for name in table.column_names}
        units = {field.name: field.metadata[b"unit"].decode() for field in table.schema}
        return cls(columns, units)


_POSE = {"x": "m", "y": "m", "z": "m", "tilt": "rad", "yaw": "rad"}
_VELOCITY = {"wx": "rad/s", "wy": "rad/s", "wz": "rad/s", "vx": "m/s", "vy": "m/s", "vz": "m/s"}
_WRENCH = {"tx": "N m", "ty": "N m", "tz": "N m", "fx": "N", "fy": "N", "fz": "N"}


def collect(assembly: Assembly, root: Context) -> Record:
    """Gather the logs of a run, finished or not, into one record.

    Every moving body has the position of its origin, its tilt (of its z axis from up) and yaw (of
    its x axis, unwrapped), its spatial velocity, the contact wrench about its origin, all in the
    world, and `g_force`, the contact's upward force over the weight. Energies: kinetic,
    gravitational, elastic (of the springs).
    """
    plant = assembly.plant
    logs = {name: sink.FindLog(root) for name, sink in assembly.logs.items()}
    samples = min(log.num_samples() for log in logs.values())  # an interrupted run may differ
    data = {name: log.data()[:, :samples].T for name, log in logs.items()}
    columns = {"time": logs["state"].sample_times()[:samples].copy()}
    units = {"time": "s"}
    for name, column, unit in (
        ("springs", data["counts"][:, 0], "1"),
        ("facet_pairs", data["counts"][:, 1], "1"),
        ("elastic_energy", data["energies"][:, 0], "J"),
    ):
        columns[name], units[name] = column, unit

    bodies = moving_bodies(plant)
    gravity = float(np.linalg.norm(plant.gravity_field().gravity_vector()))
    context = plant.CreateDefaultContext()
    kinematics = np.empty((samples, len(bodies), 11))
    energy = np.empty((samples, 2))
    for row, state in enumerate(data["state"]):
        plant.SetPositionsAndVelocities(context, state)
        energy[row] = plant.EvalKineticEnergy(context), plant.EvalPotentialEnergy(context)
        for column_, body in enumerate(bodies):
            kinematics[row, column_] = _kinematics(plant, context, body)
    columns["kinetic_energy"], columns["gravitational_energy"] = energy.T
    units |= {"kinetic_energy": "J", "gravitational_energy": "J"}
    wrenches = data["wrenches"].reshape(samples, -1, 6)
    rows = {body: row for row, body in enumerate(assembly.contact.bodies)}
    free = np.zeros((samples, 6))  # of bodies that no contact pair names
    for index, body in enumerate(bodies):
        wrench = wrenches[:, rows[body.index()]] if body.index() in rows else free
        values = np.hstack([kinematics[:, index], wrench])
        values[:, 4] = np.unwrap(values[:, 4])
        for name, unit, column in zip(
            [*_POSE, *_VELOCITY, *_WRENCH],
            [*_POSE.values(), *_VELOCITY.values(), *_WRENCH.values()],
            values.T,
            strict=True,
        ):
            columns[f"{body.name()}.{name}"], units[f"{body.name()}.{name}"] = column, unit
        weight = body.default_mass() * gravity
        if weight > 0.0:
            columns[f"{body.name()}.g_force"] = values[:, -1] / weight
            units[f"{body.name()}.g_force"] = "1"
    return Record(columns, units)


def moving_bodies(plant: MultibodyPlant) -> list[RigidBody]:
    """Return the bodies that are not welded to the world."""
    fixed = {int(body.index()) for body in plant.GetBodiesWeldedTo(plant.world_body())}
    bodies = (plant.get_body(BodyIndex(index)) for index in range(plant.num_bodies()))
    return [body for body in bodies if int(body.index()) not in fixed]


def _kinematics(plant: MultibodyPlant, context: Context, body: RigidBody) -> Column:
    X_WB = plant.EvalBodyPoseInWorld(context, body)
    V_WB = plant.EvalBodySpatialVelocityInWorld(context, body)
    R_WB: RotationMatrix = X_WB.rotation()
    axis = R_WB.matrix()
    tilt = np.arctan2(np.hypot(axis[0, 2], axis[1, 2]), axis[2, 2])
    yaw = np.arctan2(axis[1, 0], axis[0, 0])
    return np.concatenate(
        [X_WB.translation(), [tilt, yaw], V_WB.rotational(), V_WB.translational()]
    )
