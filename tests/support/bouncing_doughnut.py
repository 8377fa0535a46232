"""Property P2 as it is stated: an undamped, frictionless doughnut bounces on the cone, in Drake."""

from pathlib import Path

import numpy as np
from area_experiments import DOUGHNUT, doughnut_and_cone
from pydrake.geometry import Mesh
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import SpatialInertia, UnitInertia
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import Context, DiagramBuilder, EventStatus

from scenarios import parts
from systems import AddNonlinearDamperContact, ContactConfig

GRAVITY = 9.81
START, TOUCH = 0.172, 0.1675  # [m] heights of its middle


def bounce(folder: Path, field: str, *, duration: float, accuracy: float) -> tuple[float, int]:
    """Let it fall on runge_kutta3; return how far its energy strays, and how often it touches down.

    The energy's error is a share of m g times the fall to the first touch.
    """
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    plant.mutable_gravity_field().set_gravity_vector([0, 0, -GRAVITY])
    mass = DOUGHNUT["mass"]
    inertia = UnitInertia(*(np.array(DOUGHNUT["inertia"]) / mass))
    body = plant.AddRigidBody("doughnut", SpatialInertia(mass, [0, 0, 0], inertia))
    for owner, surface in zip((body, plant.world_body()), doughnut_and_cone(32), strict=True):
        mesh = Mesh(parts.write_obj(folder / f"{owner.name()}.obj", surface))
        plant.RegisterCollisionGeometry(
            owner, RigidTransform(), mesh, owner.name(), CoulombFriction(0, 0)
        )
    plant.Finalize()
    config = ContactConfig(k=1e8, alpha=0.0, field=field)
    contact = AddNonlinearDamperContact(builder, plant, scene_graph, config=config)
    simulator = Simulator(builder.Build())
    ResetIntegratorFromFlags(simulator, "runge_kutta3", 0.005)
    simulator.get_mutable_integrator().set_target_accuracy(accuracy)
    context = simulator.get_mutable_context()
    plant_context = plant.GetMyMutableContextFromRoot(context)
    contact_context = contact.GetMyContextFromRoot(context)
    pose = RigidTransform(RollPitchYaw(0.01, 0.02, 0), [4e-4, 0, START])
    plant.SetFreeBodyPose(plant_context, body, pose)
    stored, energy = [], []

    def watch(_: Context) -> EventStatus:
        stored.append(contact.get_energies_output_port().Eval(contact_context)[0])
        motion = plant.EvalKineticEnergy(plant_context) + plant.EvalPotentialEnergy(plant_context)
        energy.append(stored[-1] + motion)
        return EventStatus.DidNothing()

    simulator.set_monitor(watch)
    simulator.AdvanceTo(duration)
    touching = np.array(stored) > 0
    drift = np.abs(np.array(energy) - energy[0]).max() / (mass * GRAVITY * (START - TOUCH))
    return float(drift), int((touching[1:] & ~touching[:-1]).sum())
