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
# # The distance engine
#
# You will learn to ask two mesh files how far apart they are and where, which facets are near, when
# they meet along a motion, and which configurations of a part are free. There is no simulator here:
# `contact_toolkit` does not know Drake.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from contact_toolkit import (
    CollisionMesh,
    CSpaceModel,
    classify,
    distance,
    swept_distance,
    time_of_impact,
    witness_pairs,
)
from contact_toolkit.parts import doughnut, truncated_cone

# %% [markdown]
# ## Two files
#
# Any `.stl`, `.obj`, `.ply`, `.off`, `.gltf` or `.glb` will do; here we write two.

# %%
Path("runs").mkdir(exist_ok=True)
for name, surface in (
    ("cone", truncated_cone(bottom_radius=0.05, top_radius=0.02, height=0.25)),
    ("doughnut", doughnut(major_radius=0.05, minor_radius=0.02)),
):
    trimesh.Trimesh(*surface).export(f"runs/{name}.stl")

A = CollisionMesh.from_file("runs/cone.stl")
B = CollisionMesh.from_file("runs/doughnut.stl")
X_AB = np.eye(4)
X_AB[:3, 3] = 0.0005, 0.0, 0.18  # the pose of B in A [m]
closest = distance(A, B, X_AB)
print(f"{len(A.faces)} and {len(B.faces)} facets, {1e3 * closest.distance:.3f} mm apart")
print("between", closest.p_ACa.round(4), "and", closest.p_ACb.round(4), "[m]")

# %% [markdown]
# ## Every witness pair
#
# Not one closest point, but all facet pairs within a standoff: what contact on a ring needs. They
# stand in the order of a fixed rule, the same on any number of threads.

# %%
pairs = witness_pairs(A, B, X_AB, standoff=0.003)
around = np.degrees(np.arctan2(pairs.p_ACa[:, 1], pairs.p_ACa[:, 0]))
print(f"{len(pairs)} rows for {pairs.multiplicity.sum()} facet pairs")

fig, axis = plt.subplots(figsize=(7, 2.8), layout="constrained")
axis.plot(around, 1e3 * pairs.distance, ".", markersize=3)
axis.set(xlabel="around the cone [deg]", ylabel="distance [mm]")
plt.show()

# %% [markdown]
# In the browser: `Viewer` shows meshes, witness lines and hierarchies, on the `meshcat` package.
# Its address is for a browser of this machine.

# %%
from contact_toolkit.viewer import Viewer

with Viewer() as viewer:
    viewer.show("A", A, rgba=(0.95, 0.92, 0.85, 0.6))
    viewer.show("B", B, X_AB, rgba=(0.9, 0.45, 0.6, 0.4))
    viewer.show_witness_pairs("pairs", pairs)
    print(viewer.url)

# %% [markdown]
# ## Along a motion
#
# The doughnut is thrown past the cone. Its distance at the ends says nothing about the way between:
# the swept query does, and never misses.

# %%
X_start, X_end = X_AB.copy(), X_AB.copy()
X_start[:3, 3], X_end[:3, 3] = (-0.3, 0.0, 0.18), (0.3, 0.0, 0.18)
ends = [distance(A, B, X).distance for X in (X_start, X_end)]
print(f"at the ends: {ends[0]:.3f} m, {ends[1]:.3f} m")
print(f"on the way: {swept_distance(A, B, X_start, X_end).distance:.3f} m")
impact = time_of_impact(A, B, X_start, X_end)
print(f"they meet after {impact.time:.4f} of the way ({impact.status.name})")

# %% [markdown]
# ## A slice of the C-space
#
# Which places sideways and in tilt are free for the doughnut at this height? `classify` answers for
# a batch of configurations: free, within the standoff, or colliding.

# %%
x, tilt = np.linspace(-0.02, 0.02, 61), np.radians(np.linspace(-25, 25, 61))
across, turned = np.meshgrid(x, tilt)
X_FB = np.tile(np.eye(4), (across.size, 2, 1, 1))
X_FB[:, 1, :3, :3] = Rotation.from_rotvec(np.outer(turned.ravel(), [0, 1, 0])).as_matrix()
X_FB[:, 1, 0, 3], X_FB[:, 1, 2, 3] = across.ravel(), 0.21
model = CSpaceModel.from_shapes({"cone": A, "doughnut": B})
found = classify(model, X_FB, standoff=0.001)

fig, axis = plt.subplots(figsize=(5, 4), layout="constrained")
axis.pcolormesh(1e3 * x, np.degrees(tilt), found.kind.reshape(across.shape), cmap="Blues")
axis.set(xlabel="sideways [mm]", ylabel="tilt [deg]", title="free (light) to colliding (dark)")
plt.show()
