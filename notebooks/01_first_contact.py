# ---
# jupyter:
#   jupytext:
#     formats: ipynb,py:percent
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # First contact
#
# A ball made of triangles falls on a plate, in an ordinary Drake diagram whose contact is ours.
# We watch it bounce, and compare how it bounces with the closed form of the contact law.

# %%
from itertools import pairwise
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from IPython.display import IFrame
from pydrake.geometry import Box, Mesh, Meshcat, MeshcatParams, MeshcatVisualizer
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import CalcSpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput

from contact_toolkit import NonlinearDamper
from scenarios.parts import icosphere, write_obj
from systems import AddNonlinearDamperContact, ContactConfig, WitnessPairVisualizer

# %% [markdown]
# ## A ball and a plate
#
# This part is plain Drake. Any `.obj` file would do; here we generate one.

# %%
Path("runs").mkdir(exist_ok=True)
mesh = Mesh(str(write_obj(Path("runs/ball.obj"), icosphere(radius=0.05, frequency=12))))

builder = DiagramBuilder()
plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
body = plant.AddRigidBody("ball", CalcSpatialInertia(mesh, density=500.0))
plate = Box(0.4, 0.4, 0.02), RigidTransform([0, 0, -0.01])
for name, owner, (shape, X_BG), color in (
    ("ball", body, (mesh, RigidTransform()), [0.9, 0.45, 0.6, 0.5]),
    ("plate", plant.world_body(), plate, [0.8, 0.8, 0.8, 1.0]),
):
    plant.RegisterVisualGeometry(owner, X_BG, shape, name, color)
    plant.RegisterCollisionGeometry(owner, X_BG, shape, name, CoulombFriction(0, 0))
plant.Finalize()
plant.SetDefaultFloatingBaseBodyPose(body, RigidTransform([0, 0, 0.25]))

# %% [markdown]
# ## Ten lines to a bounce
#
# `AddNonlinearDamperContact` reads the collision geometry of the plant, takes the pairs away from
# Drake's own contact and connects ours: where two surfaces are closer than the `standoff`, each
# patch of them pushes like an elastic foundation of stiffness `k` [Pa/m], and `alpha` [s/m] says
# how much of the speed an impact takes.

# %%
config = ContactConfig(standoff=0.002, k=1e10, alpha=0.25)
contact = AddNonlinearDamperContact(builder, plant, scene_graph, config=config)
log = LogVectorOutput(plant.get_state_output_port(), builder, publish_period=1e-3)
meshcat = Meshcat(MeshcatParams(host="localhost"))
MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat)
WitnessPairVisualizer.AddToBuilder(builder, contact, meshcat, force_scale=0.001)
simulator = Simulator(builder.Build())
simulator.get_mutable_integrator().set_target_accuracy(1e-5)
meshcat.SetCameraPose([0.25, -0.25, 0.12], [0, 0, 0.08])
meshcat.StartRecording(frames_per_second=32)
simulator.AdvanceTo(1.2)
meshcat.PublishRecording()

# %% [markdown]
# The recording is one self-contained page. While ball and plate are within the standoff, lines join
# the points that witness it, and red arrows show the forces.

# %%
Path("runs/first_contact.html").write_text(meshcat.StaticHtml())
IFrame("runs/first_contact.html", width="100%", height=420)

# %% [markdown]
# ## Measured against the closed form
#
# In free flight the speed that the ball will have (or had) at the height where contact begins,
# $\sqrt{v^2 + 2 g (z - z_c)}$, is constant: a staircase, one step an impact.

# %%
samples = log.FindLog(simulator.get_context())
time, z, v = samples.sample_times(), samples.data()[6], samples.data()[12]
z_contact = 0.05 + config.standoff
flying = z > z_contact
touch_speed = np.sqrt(v**2 + 2 * 9.81 * (z - z_contact), where=flying, out=np.full_like(z, np.nan))
flights = np.split(touch_speed, np.flatnonzero(np.diff(flying)) + 1)
measured = np.array([np.mean(flight) for flight in flights if np.isfinite(flight[0])])

fig, (top, bottom) = plt.subplots(2, 1, sharex=True, figsize=(7, 4), layout="constrained")
top.plot(time, 1e3 * z)
top.set_ylabel("height [mm]")
bottom.plot(time, touch_speed)
bottom.set(xlabel="time [s]", ylabel="speed at contact [m/s]")
plt.show()

# %% [markdown]
# The restitution of a nonlinear damper depends on the impact speed and on $\alpha$ alone. Neither
# stiffness nor mass nor shape matter: with $D = \frac{3}{2} \alpha v$, the restitution $e$ solves
# $D (1 + e) = \ln \frac{1 + D}{1 - e D}$.

# %%
damper = NonlinearDamper(k=config.k, alpha=config.alpha)
print("impact at [m/s]   e measured   e closed form")
for before, after in pairwise(measured):
    print(f"{before:15.3f} {after / before:12.4f} {float(damper.restitution(before)):15.4f}")

# %% [markdown]
# Gravity, which the closed form leaves out, acts while the springs are loaded; it explains the
# difference, which grows as the impacts get slower.
