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
# # Choosing parameters
#
# A model tagged for Drake runs as it is. This notebook is for when it runs too slowly, bounces too
# much or sinks too deep: what each setting of `ContactConfig` does, what it costs, and where to
# look when something is wrong. The example throughout: a cube of 1 kg and 10 cm on the ground.

# %%
import numpy as np
from pydrake.geometry import Box
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from contact_toolkit import (
    MATERIALS,
    AreaWeb,
    CollisionMesh,
    ContactGeometry,
    ContactModel,
    ContactPair,
    NonlinearDamper,
)
from scenarios.parts import box
from systems import AddNonlinearDamperContact, ContactConfig, FrictionConfig

MASS, SIDE, GRAVITY = 1.0, 0.1, 9.81


def drop_cube(config, height=0.0, duration=0.3):
    """Let the cube fall from a height [m] above the ground; return what there is to look at."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    cube = plant.AddRigidBody("cube", SpatialInertia.SolidBoxWithMass(MASS, SIDE, SIDE, SIDE))
    ground = Box(10, 10, 1), RigidTransform([0, 0, -0.5])
    for owner, (shape, X_BG) in (
        (cube, (Box(SIDE, SIDE, SIDE), RigidTransform())),
        (plant.world_body(), ground),
    ):
        plant.RegisterCollisionGeometry(owner, X_BG, shape, "shape", CoulombFriction(0.5, 0.5))
    plant.Finalize()
    contact = AddNonlinearDamperContact(builder, plant, scene_graph, config=config)
    simulator = Simulator(builder.Build())
    context = simulator.get_mutable_context()
    start = RigidTransform([0, 0, SIDE / 2 + height])
    plant.SetFreeBodyPose(plant.GetMyMutableContextFromRoot(context), cube, start)
    simulator.AdvanceTo(duration)
    z = plant.EvalBodyPoseInWorld(plant.GetMyContextFromRoot(context), cube).translation()[2]
    return simulator, contact, SIDE / 2 - z


# %% [markdown]
# ## Which web
#
# | | area web (default) | facet web |
# |---|---|---|
# | springs | an elastic foundation over the surface | one for each pair of near facets |
# | `k` | foundation stiffness [Pa/mⁿ] | spring constant [N/mⁿ] |
# | stiffness depends on the mesh | no | yes: twice the facets, twice the springs |
# | `standoff` | 0 unless set: contact starts at touch | must be set: the gap to keep |
# | flat faces on each other | yes | no: closest points leap between corners, steps get tiny |
# | what for | engineering | the published model, curved parts |
#
# ## Stiffness: from how deep it may sink
#
# A foundation of stiffness $k$ under an area $A$ that carries a load $F$ gives way by $F/(k A)$,
# as long as that is little beside its size: once the cube's walls sink in, they carry load too.
# So allow a depth and take $k = F/(A\,\text{depth})$. Less depth costs steps: the body swings at
# $\omega = \sqrt{k A/m}$ on its contact, and an explicit integrator's steps shrink with $1/\omega$.
# Hydroelastic moduli make hard contact: 10 MPa over the default skin of 1 % of this cube is
# $6\cdot 10^9$ Pa/m.

# %%
area = SIDE**2
print("k [Pa/m]   depth measured [m]   closed form [m]")
for k in (5e6, 1e7, 1e8, 1e9, 1e10):
    config = ContactConfig(k=k, alpha=1.0, resolution=0.1)
    *_, sunk = drop_cube(config, height=-MASS * GRAVITY / (k * area))
    print(f"{k:8.0e} {sunk:20.3e} {MASS * GRAVITY / (k * area):17.3e}")

# %% [markdown]
# Above, the cube started where it would come to rest. Dropped from a centimetre, it makes the
# integrator work:

# %%
print("k [Pa/m]   force evaluations in 0.3 s")
for k in (1e5, 1e6, 1e7, 1e8):
    simulator, *_ = drop_cube(ContactConfig(k=k, alpha=1.0, resolution=0.1), height=0.01)
    print(f"{k:8.0e} {simulator.get_integrator().get_num_derivative_evaluations():10d}")

# %% [markdown]
# ## Damping: from how it bounces
#
# `alpha` follows from one restitution at one speed; stiffness, mass and shape do not matter.
# What is unset comes from Drake: two thirds of its dissipation, which is 50 s/m unless the model
# says otherwise. That suits Drake's implicit solver and is nearly dead: bodies then part at no more
# than 1/50 m/s. Explicit integrators pay for it; say what you want instead.

# %%
for wanted, speed in ((0.9, 1.0), (0.5, 1.0), (0.2, 1.0)):
    alpha = NonlinearDamper.alpha_for(wanted, speed)
    damper = NonlinearDamper(k=1e7, alpha=alpha)
    at = ", ".join(f"{damper.restitution(v):.2f} at {v:g} m/s" for v in (0.1, 1.0, 3.0))
    print(f"e = {wanted} at {speed:g} m/s: alpha = {alpha:.3f} s/m; then {at}")
drakes = NonlinearDamper(k=1e7, alpha=2 / 3 * 50)
print(f"Drake's default: e = {drakes.restitution(1.0):.3f} at 1 m/s")

# %% [markdown]
# ## Friction, and materials by name
#
# Coefficients come from the geometries' `CoulombFriction`, combined as Drake does. `FrictionConfig`
# overrides them, `PairConfig` for one pair of bodies, `materials` sets everything about a body.
# What is held does not creep, so there is no stiction tolerance to choose.

# %%
ContactConfig(friction=FrictionConfig(static=0.6, dynamic=0.5), materials={"cube": "rubber"})
print("material      modulus [Pa]   alpha [s/m]   friction")
for name, material in MATERIALS.items():
    coefficients = f"{material.static_friction:g}, {material.dynamic_friction:g}"
    print(f"{name:12s} {material.modulus:13.2g} {material.alpha:13.2f}   {coefficients}")

# %% [markdown]
# ## Resolution: as coarse as the rim of the patch allows
#
# The smaller body carries nodes, `resolution` of the smaller body's diagonal apart and four times
# closer along its sharp edges; a step costs what there are nodes in contact. The deformation
# between nodes is integrated in closed form. So where the patch ends at edges of the body that
# carries them, as under our cube, any spacing will do; where it ends amid its facets, as when the
# cube stands on something smaller than itself, the force errs by the order of spacing over patch
# size. The cube pressed into a plate, with the nodes on the one and on the other:

# %%
cube, plate = (CollisionMesh(*box(x, x, 0.1)) for x in (SIDE, 4 * SIDE))
geometries = [ContactGeometry("plate", 0, plate), ContactGeometry("cube", 1, cube)]
k, depth = 1e7, 1e-4
X_FB = np.tile(np.eye(4), (2, 1, 1))
X_FB[1, :3, 3] = 0.013, 0.007, 0.1 - depth
print("resolution   on the cube: nodes, force / (k A depth)   on the plate")
for resolution in (0.2, 0.1, 0.05, 0.02, 0.01):
    row = f"{resolution:10g}"
    for sampled in ("b", "a"):
        web = AreaWeb(resolution=resolution, sampled=sampled)
        pair = ContactPair(0, 1, NonlinearDamper(k), web)
        model = ContactModel(["world", "cube"], geometries, [pair])
        forces = model.evaluate(X_FB, np.zeros((2, 6)))
        ratio = forces.body_wrenches[1, 5] / (k * area * depth)
        row += f"{len(forces.contacts):16d} {ratio:9.3f}"
    print(row)

# %% [markdown]
# ## Reading contacts
#
# The port `contacts` holds one row for each loaded spring, as arrays in the world frame
# (`help(contact_toolkit.ContactArrays)` lists them). Pairs are indices into the contact model's,
# which knows their names:

# %%
simulator, contact, _ = drop_cube(ContactConfig(k=1e7, alpha=1.0, resolution=0.1))
contacts = contact.get_contacts_output_port().Eval(
    contact.GetMyContextFromRoot(simulator.get_context())
)
force_on_a = contacts.normal_force[:, None] * contacts.normal_F + contacts.friction_force_F
for index in np.unique(contacts.pair):
    rows = contacts.pair == index
    a, b = contact.model.pair_names(index)
    print(f"{a} and {b}: {rows.sum()} springs, {contacts.anchored[rows].mean():.0%} stick")
    print(f"  force on the first [N]: {force_on_a[rows].sum(axis=0).round(3)}")
    print(f"  deepest [m]: {contacts.deformation[rows].max():.2e}")

# %% [markdown]
# `body_wrenches`, `energies` and `powers` are vectors, to be logged with `LogVectorOutput`. In the
# energies, `stored + lost` against what the bodies lost tells how accurate the integration is.
#
# ## When something is wrong
#
# - **A warning that one is deeper than half the other's thickness.** `contacts.status` and
#   `contacts.deformation` tell where. A stiffer `k` or a smaller `max_step` helps;
#   `when_deep="raise"` stops at once, with the context at hand.
# - **Parts shoot off at the start, or take forever to part.** They overlap: look at the deformation
#   at time 0, and move them apart.
# - **A bullet passes through a plate.** `SweptContactMonitor.AddToBuilder(builder, contact)` tells,
#   a smaller `max_step` helps.
# - **A warning that steps are too long for a contact.** Energy is made or lost in them. The message
#   has the accuracy to set, `simulator.get_mutable_integrator().set_target_accuracy(...)`, and the
#   `max_step` that would do as well.
# - **An error that contact chatters.** Flat faces lie on each other on the facet web, whose torque
#   leaps there. Take the area web, or a discrete plant; `when_chattering="warn"` goes on.
# - **The time step of a discrete plant is refused.** The message has the stable one. Softer contact
#   or a continuous plant, `time_step=0`, help.
# - **Many small steps.** A softer `k`, a smaller `alpha`, an accuracy of 1e-3 in
#   `SimulatorConfig`; for long rest, `radau3`.
# - **Each step is slow.** `len(contacts)` is too large: a coarser `resolution`, fewer `pairs`,
#   more `threads`.
# - **Nothing touches.** `contact.model.pairs` lists what may. SceneGraph filters bodies that a
#   joint joins; a pair named in `pairs` that cannot touch is an error that says why.
# - **It looks wrong.** `WitnessPairVisualizer.AddToBuilder(builder, contact, meshcat)` draws where
#   the springs are, with `force_scale` also their forces.
