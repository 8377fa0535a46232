"""The time series of a run: one column per quantity, one row per sample."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, RigidBody
from pydrake.systems.framework import Context

from scenarios.simulation.assembly import Assembly
from scenarios.simulation.columns import (
    BODY_UNITS,
    COUNTS,
    ENERGIES,
    MECHANICS,
    UNITS,
    bodies_in,
)
from systems.plant.names import BodyNames

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

    def positions(self) -> NDArray[np.float64]:
        """Return where the origins of all moving bodies were, (n, 3) in the world [m]."""
        bodies = [name.removesuffix(".z") for name in self.columns if name.endswith(".z")]
        tracks = [np.stack([self[f"{b}.{axis}"] for axis in "xyz"], axis=1) for b in bodies]
        return np.concatenate(tracks) if tracks else np.zeros((1, 3))

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


def collect(assembly: Assembly, root: Context) -> Record:
    """Gather the logs of a run, finished or not, into one record of `column_names`.

    Energies: elastic (of the springs); lost until then in damping, to friction and to implicit
    steps; kinetic, gravitational. Every moving body has the position of its origin, its tilt (of
    its z axis from up) and yaw (of its x axis, unwrapped), its spatial velocity, the contact wrench
    about its origin, all in the world, and `g_force`, the contact's upward force over the weight.
    """
    units = column_names(assembly)
    logs = {name: sink.FindLog(root) for name, sink in assembly.logs.items()}
    samples = min(log.num_samples() for log in logs.values())  # an interrupted run may differ
    data = {name: log.data()[:, :samples].T for name, log in logs.items()}
    columns = {"time": logs["state"].sample_times()[:samples].copy()}
    if "counts" in data:
        columns |= zip(COUNTS, data["counts"].T, strict=True)
    if "energies" in data:
        normal, tangential, *losses = data["energies"].T
        columns |= zip(ENERGIES, (normal + tangential, *losses), strict=True)
    columns |= _mechanics(assembly, units, data)
    if "passes" in data:
        columns["passes"] = data["passes"].sum(axis=1)
    return Record({name: columns[name] for name in units}, units)


def _mechanics(
    assembly: Assembly, units: Mapping[str, str], data: Mapping[str, Column]
) -> dict[str, Column]:
    """Return energies and bodies' columns, of those asked for at least, of the logs' data."""
    plant, asked = assembly.plant, bodies_in(units)
    names, gravity = BodyNames(plant), np.linalg.norm(plant.gravity_field().gravity_vector())
    bodies = {names.name_of(body.index()): body for body in _moving_bodies(plant)}
    bodies = {name: body for name, body in bodies.items() if name in asked}
    samples, with_energies = len(data["state"]), not units.keys().isdisjoint(MECHANICS)
    energies = np.empty((samples, 2))
    X_WB, V_WB = np.empty((samples, len(bodies), 4, 4)), np.empty((samples, len(bodies), 6))
    context = plant.CreateDefaultContext()
    for sample, state in enumerate(data["state"]):
        plant.SetPositionsAndVelocities(context, state)
        if with_energies:
            energies[sample] = plant.EvalKineticEnergy(context), plant.EvalPotentialEnergy(context)
        for index, body in enumerate(bodies.values()):
            X_WB[sample, index] = body.EvalPoseInWorld(context).GetAsMatrix4()
            V_WB[sample, index] = body.EvalSpatialVelocityInWorld(context).get_coeffs()
    columns = dict(zip(MECHANICS, energies.T, strict=True))
    motion = _motion(X_WB, V_WB)
    wrenches: dict[BodyIndex, Column] = {}
    if "wrenches" in data:
        pushed = assembly.contact.bodies
        wrenches = dict(zip(pushed, np.hsplit(data["wrenches"], len(pushed)), strict=True))
    for index, (name, body) in enumerate(bodies.items()):
        wrench = wrenches.get(body.index(), np.zeros((samples, 6)))
        values = np.hstack([motion[:, index], wrench]).T
        values[4] = np.unwrap(values[4])
        columns |= {f"{name}.{q}": column for q, column in zip(BODY_UNITS, values, strict=True)}
        if f"{name}.g_force" in units:
            columns[f"{name}.g_force"] = values[-1] / (body.default_mass() * gravity)
    return columns


def column_names(assembly: Assembly) -> dict[str, str]:
    """Return the names and units of the columns that a run of this diagram will record."""
    units = dict(UNITS)
    names = BodyNames(assembly.plant)
    for body in _moving_bodies(assembly.plant):
        name = names.name_of(body.index())
        units |= {f"{name}.{quantity}": unit for quantity, unit in BODY_UNITS.items()}
        if body.default_mass() > 0.0 and np.any(assembly.plant.gravity_field().gravity_vector()):
            units[f"{name}.g_force"] = "1"
    if "passes" in assembly.logs:
        units["passes"] = "1"
    asked = assembly.columns
    return units if asked is None else {n: u for n, u in units.items() if n in {"time", *asked}}


def _moving_bodies(plant: MultibodyPlant) -> list[RigidBody]:
    """Return the bodies that are not welded to the world."""
    fixed = {body.index() for body in plant.GetBodiesWeldedTo(plant.world_body())}
    bodies = (plant.get_body(BodyIndex(index)) for index in range(plant.num_bodies()))
    return [body for body in bodies if body.index() not in fixed]


def _motion(X_WB: Column, V_WB: Column) -> Column:
    """Return what is recorded (…, 11) of poses (…, 4, 4) and velocities (…, 6)."""
    tilt = np.arctan2(np.hypot(X_WB[..., 0, 2], X_WB[..., 1, 2]), X_WB[..., 2, 2])
    yaw = np.arctan2(X_WB[..., 1, 0], X_WB[..., 0, 0])
    angles = np.stack([tilt, yaw], axis=-1)
    return np.concatenate([X_WB[..., :3, 3], angles, V_WB], axis=-1)
