# ---
# jupyter:
#   jupytext:
#     formats: ipynb,py:percent
#     text_representation:
#       extension: .py
#       format_name: percent
#       format_version: '1.3'
#       jupytext_version: 1.19.6
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Friction that sticks
#
# You will learn what a grasp and a taper do when friction holds for good, beside the same models
# under Drake's own contact. A contact solver that regularizes friction lets what it holds creep, as
# slowly as its tolerance says (Drake's stiction tolerance is left at its 1 mm/s here); springs
# anchored in the bodies carry the load at rest. Both run on the same discrete plant, at 1 ms.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    Box,
    Mesh,
    ProximityProperties,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, ContactModel, CoulombFriction
from pydrake.multibody.tree import PrismaticJoint, SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, LogVectorOutput, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from contact_toolkit.drake import AddNonlinearDamperContact
from contact_toolkit.parts import box, write_obj

MODULUS = 1e7  # [Pa]
OURS, DRAKES = "anchored", "Drake's own"
GRAVITY = 9.81

# %% [markdown]
# ## A grasp
#
# Two fingers pinch a block of 100 g. Friction could hold $2 \mu F$; gravity asks for a part of it.
# Whether it is half of it or nine tenths, the block should stay where it is.

# %%
MASS, MU, PAD, BLOCK = 0.1, 0.6, 0.02, 0.03


def surface(friction, *, compliant):
    """Return tags that both kinds of contact read: one side soft, the other rigid."""
    properties = ProximityProperties()
    AddContactMaterial(
        dissipation=5.0, friction=CoulombFriction(friction, friction), properties=properties
    )
    if compliant:
        AddCompliantHydroelasticProperties(
            resolution_hint=0.01, hydroelastic_modulus=MODULUS, properties=properties
        )
    else:
        AddRigidHydroelasticProperties(resolution_hint=0.01, properties=properties)
    return properties


def simulate(builder, plant, scene_graph, engine, drive, duration):
    """Finish a diagram whose actuators follow `drive`, run it, and return its logged states."""
    plant.set_contact_model(ContactModel.kHydroelasticWithFallback)
    plant.Finalize()
    drive = builder.AddSystem(drive)
    builder.Connect(drive.get_output_port(), plant.get_actuation_input_port())
    log = LogVectorOutput(plant.get_state_output_port(), builder, publish_period=0.005)
    if engine == OURS:
        AddNonlinearDamperContact(builder, plant, scene_graph)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(duration)
    return log.FindLog(simulator.get_context())


def grasp(engine, share):
    """Pinch so hard that gravity asks for `share` of the friction; return time [s], sunk [m]."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=1e-3)
    pads, hard = (surface(MU, compliant=soft) for soft in (True, False))
    block = plant.AddRigidBody("block", SpatialInertia.SolidBoxWithMass(MASS, BLOCK, BLOCK, BLOCK))
    cube = Box(BLOCK, BLOCK, BLOCK)
    plant.RegisterCollisionGeometry(block, RigidTransform(), cube, "block", hard)
    for name, side in (("left", -1), ("right", 1)):
        finger = plant.AddRigidBody(name, SpatialInertia.SolidBoxWithMass(0.1, PAD, PAD, PAD))
        X_FG = RigidTransform([side * (BLOCK + PAD) / 2, 0, 0])
        plant.RegisterCollisionGeometry(finger, X_FG, Box(PAD, PAD, PAD), name, pads)
        joint = PrismaticJoint(
            name, plant.world_frame(), finger.body_frame(), [-side, 0, 0], damping=20
        )
        plant.AddJointActuator(name, plant.AddJoint(joint))
    pinch = ConstantVectorSource(np.full(2, MASS * GRAVITY / (2 * MU * share)))
    samples = simulate(builder, plant, scene_graph, engine, pinch, 1.0)
    return samples.sample_times(), -samples.data()[block.floating_positions_start() + 6]


fig, ax = plt.subplots(figsize=(7, 3), layout="constrained")
print("gravity's share   contact       creep [µm/s]")
for share in (0.5, 0.9):
    for engine in (OURS, DRAKES):
        time, sunk = grasp(engine, share)
        late = time >= 0.5
        creep = 1e6 * np.polyfit(time[late], sunk[late], 1)[0]
        print(f"{share:15.1f}   {engine:12s} {creep:12.2e}")
        ax.plot(
            time, 1e6 * sunk, label=f"{engine}, {share:.0%}", ls="-" if engine == OURS else "--"
        )
ax.set(xlabel="time [s]", ylabel="sunk [µm]")
ax.legend()
plt.show()

# %% [markdown]
# ## A taper
#
# A wedge of half-angle $\beta$ = 3° is pressed between two walls by 400 N, let go, and pulled out.
# As $\mu > \tan\beta$ it holds by itself, and to come out it wants
# $\tan(\varphi - \beta)/\tan(\varphi + \beta)$ of what pressed it in. To hold is to stay
# stretched sideways under no load at all.

# %%
FRICTION, BETA, PRESS = 0.15, np.radians(3.0), 400.0
TALL, WALL = 0.04, 0.12
SCHEDULE = [(0.0, 0.0), (0.1, -PRESS), (0.15, -PRESS), (0.25, 0.0), (0.5, 0.0), (0.8, 0.6 * PRESS)]
Path("runs").mkdir(exist_ok=True)
vertices, faces = box(0.04, 0.04, TALL)
vertices[:, 0] += np.sign(vertices[:, 0]) * vertices[:, 2] * np.tan(BETA)  # wider above
WEDGE = Mesh(str(write_obj(Path("runs/wedge.obj"), (vertices, faces))))


def press_and_pull(engine):
    """Return time [s], the ram's force [N] and how far the wedge is above its start [m]."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=1e-3)
    plant.mutable_gravity_field().set_gravity_vector([0, 0, 0])
    walls, hard = (surface(FRICTION, compliant=soft) for soft in (True, False))
    wedge = plant.AddRigidBody("wedge", SpatialInertia.SolidBoxWithMass(1.0, TALL, TALL, TALL))
    plant.RegisterCollisionGeometry(wedge, RigidTransform(), WEDGE, "wedge", hard)
    for name, side in (("left", -1), ("right", 1)):
        R_WG = RotationMatrix.MakeYRotation(side * BETA)
        face = np.array([side * 0.02, 0, 0])
        X_WG = RigidTransform(R_WG, face + R_WG @ [side * WALL / 2, 0, 0])
        wall = Box(WALL, WALL, WALL)
        plant.RegisterCollisionGeometry(plant.world_body(), X_WG, wall, name, walls)
    ram = PrismaticJoint("ram", plant.world_frame(), wedge.body_frame(), [0, 0, 1], damping=100)
    plant.AddJointActuator("ram", plant.AddJoint(ram))
    times, forces = zip(*SCHEDULE, strict=True)
    force = PiecewisePolynomial.FirstOrderHold(times, [forces])
    samples = simulate(builder, plant, scene_graph, engine, TrajectorySource(force), 0.8)
    time = samples.sample_times()
    return time, np.array([force.value(t)[0, 0] for t in time]), samples.data()[0]


phi = np.arctan(FRICTION)
print(f"on paper, out/in = {np.tan(phi - BETA) / np.tan(phi + BETA):.3f}")
fig, ax = plt.subplots(figsize=(7, 3), layout="constrained")
for engine in (OURS, DRAKES):
    time, force, z = press_and_pull(engine)
    held = (time >= 0.3) & (time <= 0.5)
    creep = 1e6 * np.polyfit(time[held], z[held], 1)[0]
    out = force[(time > 0.5) & (z > z[held][-1] + 5e-5)]
    released = f"{out[0] / PRESS:.3f} of the force in" if len(out) else "not at all"
    print(f"{engine:12s} creep while unloaded {creep:9.2e} µm/s; comes out at {released}")
    ax.plot(time, 1e3 * z, label=engine, ls="-" if engine == OURS else "--")
ax.set(xlabel="time [s]", ylabel="height [mm]", ylim=(-2, 1))
ax.legend()
plt.show()
