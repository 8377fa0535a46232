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
# # A robot arm
#
# An arm with a gripper takes a mug by its wall, one finger within, and sets it down elsewhere. You
# will learn how contact goes together with joints, actuators and Drake's own controllers, how to
# read the force between two bodies, and that a mesh is its facets: a convex hull of the mug would
# have a lid.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from IPython.display import IFrame
from pydrake.geometry import Box, Mesh, Meshcat, MeshcatParams, MeshcatVisualizer
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    PdControllerGains,
    PrismaticJoint,
    RevoluteJoint,
    SpatialInertia,
    default_model_instance,
)
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from contact_toolkit.drake import AddNonlinearDamperContact, ContactConfig, PairWrenches
from contact_toolkit.parts import mug, write_obj

# %% [markdown]
# ## An arm of three joints, and a gripper
#
# Shoulder, elbow and wrist turn about y; two fingers slide along x. All of this is plain Drake, and
# a model file of your robot (`Parser(plant).AddModels`) would do as well. The joints are held by
# the controllers that Drake's actuators bring along.

# %%
UPPER, FORE, HAND = 0.35, 0.3, 0.12  # [m] between the joints, and down to the finger tips
SHOULDER = [0.0, 0.0, 0.45]
GRAY, BLUE, WHITE = [0.35, 0.37, 0.42, 1], [0.2, 0.4, 0.7, 1], [0.9, 0.9, 0.92, 0.6]
FINGER = Box(0.012, 0.02, 0.06)
rubber = CoulombFriction(0.8, 0.8)

builder = DiagramBuilder()
plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.002)
arm = plant.AddModelInstance("arm")
plant.set_gravity_enabled(arm, False)  # as robots compensate theirs


def add_link(name, size, mass, p_BG, color):
    """Add a body of the arm with a box to be seen."""
    inertia = SpatialInertia.SolidBoxWithMass(mass, *size)
    body = plant.AddRigidBody(name, arm, inertia.Shift(-np.array(p_BG)))
    plant.RegisterVisualGeometry(body, RigidTransform(p_BG), Box(*size), name, color)
    return body


def actuate(kind, parent, p_PJ, body, axis, stiffness, damping):
    """Join a body to its parent, by an actuator that follows a desired position."""
    where = FixedOffsetFrame(f"{body.name()}_root", parent.body_frame(), RigidTransform(p_PJ))
    joint = plant.AddJoint(kind(body.name(), plant.AddFrame(where), body.body_frame(), axis))
    actuator = plant.AddJointActuator(body.name(), joint)
    actuator.set_controller_gains(PdControllerGains(p=stiffness, d=damping))


parent, p_PJ = plant.world_body(), SHOULDER
for name, length in (("upper", UPPER), ("fore", FORE)):
    body = add_link(name, (length, 0.05, 0.06), 1.5, [length / 2, 0, 0], GRAY)
    actuate(RevoluteJoint, parent, p_PJ, body, [0, 1, 0], 3000, 120)
    parent, p_PJ = body, [length, 0, 0]
hand = add_link("hand", (0.08, 0.05, 0.04), 0.4, [0, 0, -0.03], BLUE)
actuate(RevoluteJoint, parent, p_PJ, hand, [0, 1, 0], 1000, 40)
for name, side in (("outer", 1), ("inner", -1)):
    finger = add_link(name, FINGER.size(), 0.1, [0, 0, 0], BLUE)
    plant.RegisterCollisionGeometry(finger, RigidTransform(), FINGER, name, rubber)
    closed = [-side * FINGER.width() / 2, 0, FINGER.height() / 2 - HAND]
    actuate(PrismaticJoint, hand, closed, finger, [side, 0, 0], 4000, 60)

# %% [markdown]
# ## A mug on a table

# %%
Path("runs").mkdir(exist_ok=True)
MUG = Mesh(str(write_obj(Path("runs/mug.obj"), mug(sections=24))))
RADIUS, TALL, WALL, MASS = 0.04, 0.095, 0.004, 0.25
START, GOAL = 0.40, 0.48  # [m] along x
about_middle = SpatialInertia.SolidCylinderWithMass(MASS, RADIUS, TALL, [0, 0, 1])
cup = plant.AddRigidBody("mug", default_model_instance(), about_middle.Shift([0, 0, -TALL / 2]))
table = Box(0.5, 0.3, 0.02), RigidTransform([0.42, 0, -0.01])
for body, (shape, X_BG), color in (
    (cup, (MUG, RigidTransform()), WHITE),
    (plant.world_body(), table, [0.7, 0.6, 0.45, 1]),
):
    plant.RegisterVisualGeometry(body, X_BG, shape, "shape", color)
    plant.RegisterCollisionGeometry(body, X_BG, shape, "shape", rubber)
plant.Finalize()
plant.SetDefaultFloatingBaseBodyPose(cup, RigidTransform([START, 0, 0]))

# %% [markdown]
# ## Where the hand goes
#
# Waypoints of the finger tips, and whether the fingers close; the joint angles of a planar arm of
# two links follow in closed form. The fingers close on the near wall of the mug, 35 mm deep.


# %%
def joints(x, z, grip):
    """Angles [rad] of shoulder, elbow and wrist with the tips at (x, z), and the fingers' ways."""
    ahead, down = x - SHOULDER[0], SHOULDER[2] - z - HAND
    cosine = (ahead**2 + down**2 - UPPER**2 - FORE**2) / (2 * UPPER * FORE)
    elbow = np.arccos(cosine)
    bend = np.arctan2(FORE * np.sin(elbow), UPPER + FORE * np.cos(elbow))
    shoulder = np.arctan2(down, ahead) - bend
    return [shoulder, elbow, -shoulder - elbow, grip, grip]


OPEN, CLOSED = -0.012, WALL / -2 + 0.004  # [m]; the controllers pull 4 mm beyond the wall
wall = START - RADIUS + WALL / 2
far = wall + GOAL - START
waypoints = [
    (0.0, wall, TALL + 0.02, OPEN),
    (0.4, wall, TALL - 0.035, OPEN),
    (0.6, wall, TALL - 0.035, CLOSED),
    (1.0, wall, TALL + 0.065, CLOSED),
    (1.4, far, TALL + 0.065, CLOSED),
    (1.9, far, TALL - 0.035, CLOSED),
    (2.1, far, TALL - 0.035, OPEN),
    (2.5, far, TALL + 0.02, OPEN),
]
fine = np.arange(0, 2.5001, 0.05)  # straight lines of the tips, not of the joints
x, z, grip = (np.interp(fine, *np.array(waypoints)[:, [0, i]].T) for i in (1, 2, 3))
angles = np.array([joints(*row) for row in zip(x, z, grip, strict=True)]).T
path = PiecewisePolynomial.CubicShapePreserving(fine, angles, zero_end_point_derivatives=True)
desired = builder.AddSystem(TrajectorySource(path, output_derivative_order=1))
builder.Connect(desired.get_output_port(), plant.get_desired_state_input_port(arm))

# %% [markdown]
# ## Contact, and go
#
# Joints that are controlled need nothing special: contact is solved with the plant's own step,
# controllers included. `PairWrenches` puts out what one body does to another.

# %%
config = ContactConfig(k=1e9, resolution=0.1)
contact = AddNonlinearDamperContact(builder, plant, scene_graph, config=config)
PAIRS = [("mug", "inner"), ("mug", "outer"), ("mug", "world")]
between = PairWrenches.AddToBuilder(builder, contact, PAIRS)
state = LogVectorOutput(plant.get_state_output_port(), builder, publish_period=0.01)
wrenches = LogVectorOutput(between.get_output_port(), builder, publish_period=0.01)
meshcat = Meshcat(MeshcatParams(host="localhost"))
MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat)
simulator = Simulator(builder.Build())
root = simulator.get_mutable_context()
plant.SetPositions(plant.GetMyMutableContextFromRoot(root), arm, angles[:, 0])
meshcat.SetCameraPose([0.55, -0.75, 0.4], [0.35, 0, 0.15])
meshcat.StartRecording(frames_per_second=32)
simulator.AdvanceTo(2.5)
meshcat.PublishRecording()

# %%
Path("runs/robot_arm.html").write_text(meshcat.StaticHtml())
IFrame("runs/robot_arm.html", width="100%", height=420)

# %% [markdown]
# ## What happened
#
# While the mug hangs in the air, the fingers carry its weight, by friction alone; the pinch is what
# the controllers pull for. Before and after, the table carries it.

# %%
time = state.FindLog(root).sample_times()
position = state.FindLog(root).data()[cup.floating_positions_start() + np.array([4, 5, 6])]
force = wrenches.FindLog(root).data().reshape(3, 6, -1)[:, 3:]  # [N], pair by pair
weight = MASS * 9.81

fig, axes = plt.subplots(3, 1, sharex=True, figsize=(7, 6), layout="constrained")
axes[0].plot(time, 1e3 * (position - position[:, :1]).T, label=["x", "y", "z"])
axes[0].set_ylabel("mug moved [mm]")
axes[1].plot(time, force[:2, 0].T, label=["finger within", "finger without"])
axes[1].set_ylabel("pinch, along x [N]")
axes[2].plot(time, force[:2, 2].sum(axis=0), label="fingers")
axes[2].plot(time, force[2, 2], label="table")
axes[2].axhline(weight, color="k", linestyle=":", label="weight")
axes[2].set(xlabel="time [s]", ylabel="upwards [N]", ylim=(-2, 3 * weight))
for ax in axes:
    ax.legend(loc="upper left")
plt.show()

# %%
carried = (time > 1.05) & (time < 1.35)  # along x, at one height
lifted = np.mean(position[2][carried])
mean = np.mean(force[:2, 2].sum(axis=0)[carried])
moved = position[0][-1] - position[0][0]
print(f"lifted by {1e3 * lifted:.1f} mm; the fingers carry {mean / weight:.3f} of the weight")
print(f"set down {1e3 * moved:.1f} mm further, meant: {1e3 * (GOAL - START):.0f} mm")
assert abs(mean / weight - 1) < 0.02
assert abs(lifted - 0.1) < 0.01
assert abs(moved - (GOAL - START)) < 0.01
