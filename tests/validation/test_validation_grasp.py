"""A capsule pinched between two fingers, held for a minute: row 14 of the README's closed forms.

Gravity pulls along the fingers' faces. Contact that regularizes friction creeps; anchored friction
rests. The same model under Drake's own contact runs beside it, and its creep is recorded.
"""

import math

import numpy as np
import pytest
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    Box,
    Mesh,
    ProximityProperties,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import PrismaticJoint, SpatialInertia
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource
from validation_scenes import check, on

from scenarios import parts
from systems import AddNonlinearDamperContact, ContactConfig

MASS = 0.045  # [kg]
RADIUS, LENGTH = 0.004, 0.02  # [m]; the length is the cylinder's
SECTIONS = 12
MU = 0.7
PAD = (0.01, 0.02, 0.04)  # [m]
MODULUS = 1e7  # [Pa] of the rubber on a finger
SKIN = 0.002  # [m]
DISSIPATION = 7.5  # [s/m]
ALLOWED = 1e-3  # [µm/s]
MAX_STEP = 0.05  # [s] of a continuous plant
STEP = 1e-3  # [s] of a discrete one
SETTLED = 1.0  # [s]: the pinch has closed, and what swung has long died down
HELD = 60.0  # [s] from then on


def proximity(*, compliant: bool) -> ProximityProperties:
    properties = ProximityProperties()
    AddContactMaterial(
        dissipation=DISSIPATION, friction=CoulombFriction(MU, MU), properties=properties
    )
    if compliant:
        AddCompliantHydroelasticProperties(PAD[0], MODULUS, properties)
    else:
        AddRigidHydroelasticProperties(RADIUS, properties)
    return properties


def creep(folder, squeeze: float, time_step: float, *, drake: bool = False) -> float:
    """Speed [µm/s] of the capsule pinched by `squeeze` [N], averaged over the time it is held."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step)
    capsule = plant.AddRigidBody(
        "capsule", SpatialInertia.SolidCapsuleWithMass(MASS, RADIUS, LENGTH, [0, 0, 1])
    )
    surface = parts.capsule(LENGTH, RADIUS, sections=SECTIONS, cap_rings=2)
    path = parts.write_obj(folder / "capsule.obj", surface)
    facets_to_fingers = RigidTransform(RotationMatrix.MakeZRotation(math.pi / SECTIONS))
    plant.RegisterCollisionGeometry(
        capsule, facets_to_fingers, Mesh(path), "capsule", proximity(compliant=False)
    )
    touch = RADIUS * math.cos(math.pi / SECTIONS) + PAD[0] / 2
    for name, side in (("left", -1), ("right", 1)):
        finger = plant.AddRigidBody(name, SpatialInertia.SolidBoxWithMass(0.1, *PAD))
        plant.RegisterCollisionGeometry(
            finger, RigidTransform([side * touch, 0, 0]), Box(*PAD), name, proximity(compliant=True)
        )
        joint = plant.AddJoint(
            PrismaticJoint(
                name, plant.world_frame(), finger.body_frame(), [-side, 0, 0], damping=20.0
            )
        )
        plant.AddJointActuator(name, joint)
    plant.Finalize()
    drive = builder.AddSystem(ConstantVectorSource([squeeze, squeeze]))
    builder.Connect(drive.get_output_port(), plant.get_actuation_input_port())
    if not drake:
        config = ContactConfig(skin=SKIN, resolution=0.05, max_step=MAX_STEP)
        AddNonlinearDamperContact(builder, plant, scene_graph, config=config)
    simulator = Simulator(builder.Build())
    if not time_step:
        # At rest the steps of an implicit scheme grow as long as they may.
        ResetIntegratorFromFlags(simulator, "radau3", MAX_STEP)
    context = plant.GetMyContextFromRoot(simulator.get_mutable_context())
    places = []
    for time in (SETTLED, SETTLED + HELD):
        simulator.AdvanceTo(time)
        places.append(plant.EvalBodyPoseInWorld(context, capsule).translation())
    return 1e6 * float(np.linalg.norm(places[1] - places[0])) / HELD


@pytest.mark.slow
@pytest.mark.parametrize("squeeze", [12.0, 60.0])
def test_a_grasp_does_not_creep(squeeze, tmp_path, record_property):
    """Row 14: a held part that sinks, or not slower than under Drake's own contact."""
    experiment = f"capsule pinched by {squeeze:g} N, held for {HELD:g} s: creep [µm/s]"
    theirs = creep(tmp_path, squeeze, STEP, drake=True)
    record_property("validation", (14, f"{experiment}, Drake's own contact", "", theirs, "", ""))
    assert theirs > ALLOWED  # else the comparison shows nothing
    for time_step in (0.0, STEP):
        got = creep(tmp_path, squeeze, time_step)
        row = (14, experiment + on(time_step))
        check(record_property, row, 0.0, got, ALLOWED, relative=False)
