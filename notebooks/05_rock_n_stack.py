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
# # Rock-N-Stack
#
# A doughnut falls on a cone and comes to rest on a web of some two thousand springs. You will learn
# how to run a scenario from Python, what its folder holds, how to read its record, and why the
# weights of the springs decide whether the doughnut ever rests.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from IPython.display import IFrame, Image, display

from scenarios.format.loading import load
from scenarios.runner import run
from scenarios.simulation.record import Record

# %% [markdown]
# ## Run it
#
# The same as `contact-toolkit run rock_n_stack --out runs/rock_n_stack`. The scenario is a YAML
# file: parts, directives in Drake's own form, contact, and what it is judged by.

# %%
FOLDER = Path("runs/rock_n_stack")
summary = run(*load("rock_n_stack"), FOLDER, replace=True)
print(summary.truth)
for check in summary.checks:
    print(f"{check.figure:20s} {check.value:10.4g}   accepted: {check.limit}")
print("acceptance:", summary.verdict)

# %% [markdown]
# The first line says what it is held against: the springs' forces are added up once more from the
# last pose alone, by testing every facet of the one against every facet of the other.
#
# The playback is one page that needs no network. Lines join the witness points of every spring:

# %%
Path("runs/rock_n_stack.html").write_bytes((FOLDER / "playback.html").read_bytes())
IFrame("runs/rock_n_stack.html", width="100%", height=420)

# %% [markdown]
# ## Its figures
#
# Every run draws them: how it bounces and what force it feels, how it turns and tilts, how many
# springs are loaded, where the energy went.

# %%
for name in ("doughnut_height", "doughnut_attitude", "springs", "energy", "web"):
    display(Image(FOLDER / "figures" / f"{name}.png", width=640))

# %% [markdown]
# ## Its record
#
# `series.parquet` holds the columns behind them, which any tool reads. Its ledger should be a
# straight line: what the doughnut had is stored in springs or lost in damping, nothing else.

# %%
record = Record.load(FOLDER / "series.parquet")
held = ("kinetic_energy", "gravitational_energy", "elastic_energy", "damping_loss", "friction_loss")
total = sum(record[name] for name in held)
fallen = np.ptp(record["gravitational_energy"])
print(f"{len(record.columns)} columns of {len(total)} samples")
print(f"energy not accounted for: {np.ptp(total) / fallen:.2%} of what it fell through")

# %% [markdown]
# ## Why weights
#
# Many facet pairs have the same two closest points, at a vertex or an edge that they share, and are
# merged into one witness pair. As published, each such pair is one spring. Then the force is no
# gradient of a potential: as the pose changes by a hair, pairs merge and part, and springs come and
# go. With `weighting: multiplicity`, the default, a merged pair counts as often as there are facet
# pairs behind it, and what is left is smooth.

# %%
unit = Path("runs/rock_n_stack_unit")
run(*load("rock_n_stack_unit", ["simulation_duration=3.5"]), unit, replace=True)
fig, axes = plt.subplots(2, 1, sharex=True, figsize=(7, 4), layout="constrained")
for label, folder in (("unit, as published", unit), ("multiplicity", FOLDER)):
    record = Record.load(folder / "series.parquet")
    late = (record["time"] > 2.0) & (record["time"] < 3.5)
    height = 1e3 * record["doughnut.z"][late]
    axes[0].plot(record["time"][late], height - height.mean(), label=label)
    axes[1].plot(record["time"][late], record["doughnut.wz"][late], label=label)
    end = (record["time"] > 3.0) & (record["time"] < 3.5)
    jitter, spin = np.std(1e3 * record["doughnut.z"][end]), abs(record["doughnut.wz"][end]).max()
    print(f"{label:20s} jitter {jitter:.4f} mm rms, spin up to {spin:.4f} rad/s")
axes[0].set_ylabel("height less\nits mean [mm]")
axes[1].set(xlabel="time [s]", ylabel="spin [rad/s]")
axes[0].legend()
plt.show()
