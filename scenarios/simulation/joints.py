"""Add a scenario's joints to its plant, with an actuator for each that is driven."""

from __future__ import annotations

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    Frame,
    PrismaticJoint,
    RevoluteJoint,
    ScopedName,
)
from pydrake.multibody.tree import Joint as PlantJoint

from scenarios.format.errors import ScenarioError
from scenarios.format.joint import Drive, Joint

_KINDS = {"prismatic": PrismaticJoint, "revolute": RevoluteJoint}


def add_joints(plant: MultibodyPlant, joints: dict[str, Joint], drives: dict[str, Drive]) -> None:
    """Add joints, and actuators for the driven ones that have none. Raises ScenarioError."""
    for name, joint in joints.items():
        where = f"joints.{name}"
        parent = _frame(plant, f"{where}.parent", joint.parent)
        child = _frame(plant, f"{where}.child", joint.child)
        placed = plant.AddFrame(_offset(name, parent, joint))
        axis = np.array(joint.axis) / np.linalg.norm(joint.axis)
        made = _KINDS[joint.kind](
            name, placed, child, axis, joint.lower, joint.upper, joint.damping
        )
        plant.AddJoint(made)
    actuated = {
        plant.get_joint_actuator(index).joint().index() for index in plant.GetJointActuatorIndices()
    }
    for name in drives:
        driven = find_joint(plant, f"drives.{name}", name)
        if driven.num_velocities() != 1:
            raise ScenarioError(f"drives.{name}: the joint has {driven.num_velocities()} freedoms")
        if driven.index() not in actuated:
            plant.AddJointActuator(f"{name}_drive".replace("::", "_"), driven)


def find_joint(plant: MultibodyPlant, where: str, name: str) -> PlantJoint:
    """Return the joint called `joint` or `model::joint`; raise ScenarioError with what there is."""
    scoped = ScopedName.Parse(name)
    try:
        if scoped.get_namespace():
            model = plant.GetModelInstanceByName(scoped.get_namespace())
            return plant.GetJointByName(scoped.get_element(), model)
        return plant.GetJointByName(name)
    except RuntimeError as error:
        known = [plant.get_joint(index).name() for index in plant.GetJointIndices()]
        raise ScenarioError(
            f"{where}: no joint is called so, or several are; there are: {', '.join(known)}"
        ) from error


def _offset(name: str, parent: Frame, joint: Joint) -> Frame:
    return FixedOffsetFrame(f"{name}_at", parent, RigidTransform(joint.translation))


def _frame(plant: MultibodyPlant, where: str, name: str) -> Frame:
    if name == "world":
        return plant.world_frame()
    scoped = ScopedName.Parse(name)
    try:
        if scoped.get_namespace():
            model = plant.GetModelInstanceByName(scoped.get_namespace())
            return plant.GetFrameByName(scoped.get_element(), model)
        return plant.GetFrameByName(name)
    except RuntimeError as error:
        raise ScenarioError(f"{where}: {error}") from error
