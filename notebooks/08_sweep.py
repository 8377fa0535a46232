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
# # A sweep and its report
#
# You will learn how to ask a scenario a question that one run cannot answer: how to write a study,
# run it on all cores, read where it succeeds and how sure that is, look at a single run again, and
# find a parameter from a measured series. It needs `pip install 'contact-toolkit[sweep]'`.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from IPython.display import IFrame, Image

import scenarios
from scenarios.sweep.charts import interval
from scenarios.sweep.fit import FreeParameter, fit
from scenarios.sweep.plan import Plan
from scenarios.sweep.report import Results, simulate_again, write_report
from scenarios.sweep.study import load_study
from scenarios.sweep.sweep import sweep

RUNS = Path("runs")
RUNS.mkdir(exist_ok=True)

# %% [markdown]
# ## A scenario
#
# A block, twice as high as wide, is put on a tilted plate. It stands, slides down or falls over;
# `acceptance` says that it shall stand.

# %%
SCENARIO = """
tall_block:
  description: A tall block on a tilted plate stands, slides down or falls over
  simulation_duration: 0.5
  record_period: 0.01
  plant_config: {time_step: 0.002}
  parts:
    plate:
      generator: box
      parameters: {size_x: 0.6, size_y: 0.3, size_z: 0.02}
      rgba: [0.8, 0.78, 0.7, 1]
    block:
      generator: box
      parameters: {size_x: 0.05, size_y: 0.05, size_z: 0.1}
      mass: 0.25
      rgba: [0.2, 0.5, 0.8, 1]
  directives:
  - add_model: {name: plate, file: package://parts/plate.urdf}
  - add_weld:
      parent: world
      child: plate::plate
      X_PC: {rotation: !Rpy {deg: [0, 15, 0]}}
  - add_model:
      name: block
      file: package://parts/block.urdf
      default_free_body_pose: {block: {base_frame: plate::plate, translation: [0, 0, 0.06]}}
  contact: {k: 1.0e+11, alpha: 0.5, resolution: 0.2, friction: {static: 0.4}}
  visualization: {camera: [0.1, -0.6, 0.25], target: [0.05, 0, 0]}
  acceptance:
    truth: stands if the slope tan θ is less than both μ and width over height, 0.5
    figures:
      moved [mm]: '1e3 * abs(end("block.x") - start("block.x"))'
      turned [deg]: '180 / pi * abs(end("block.tilt") - start("block.tilt"))'
    limits:
      turned [deg]: {at_most: 1.0}
      moved [mm]: {at_most: 1.0}
"""
(RUNS / "tall_block.yaml").write_text(SCENARIO)

TILT = "directives.1.add_weld.X_PC.rotation.deg.1"
for tilt, friction in ((15.0, 0.4), (25.0, 0.4), (29.0, 0.7)):
    inputs = {TILT: tilt, "contact.friction.static": friction}
    outcome = scenarios.rollout(str(RUNS / "tall_block.yaml"), inputs)
    figures = ", ".join(f"{name} {value:.3g}" for name, value in outcome.figures.items())
    print(f"{tilt:g}°, μ = {friction}: {outcome.verdict}; {figures}")

# %% [markdown]
# ## A study
#
# A study names the scenario and what varies in it: a parameter is a distribution and the keys that
# take its value, or a choice between settings. Here tilt and friction vary evenly, and the plate
# is one of two. Sobol's sequence spreads the runs.

# %%
STUDY = f"""
tilt_study:
  description: How far may the plate be tilted, how smooth and how soft may it be?
  scenario: tall_block.yaml
  runs: 64
  parameters:
    tilt [deg]: {{sets: [{TILT}], distribution: !Uniform {{min: 14, max: 32}}}}
    friction: {{sets: [contact.friction.static], distribution: !Uniform {{min: 0.2, max: 0.7}}}}
    plate: {{choices: {{steel: [contact.k=1.0e+11], rubber: [contact.k=1.0e+8]}}}}
  score: turned [deg]
  maps:
  - ['tilt [deg]', friction]
"""
(RUNS / "tilt_study.yaml").write_text(STUDY)
plan = Plan(*load_study(str(RUNS / "tilt_study.yaml")))
for planned in plan.runs()[:3]:
    print(planned.number, planned.inputs)

# %% [markdown]
# ## The sweep
#
# `contact-toolkit sweep runs/tilt_study.yaml` does the same. Every core gets a process, every run
# becomes a row of a Parquet dataset, whatever happens to it. With `resume`, runs whose rows are
# there already are not repeated, so this cell may be executed twice.

# %%
FOLDER = RUNS / "tilt_study"
tally = sweep(plan, FOLDER, resume=True)
print(f"{tally.passed} stood, {tally.failed} did not, {tally.without_figures} without figures")

# %% [markdown]
# ## What is sure
#
# A rate from a few runs is an estimate; Wilson's interval says what the true rate may be, with 95 %
# confidence. Where two intervals overlap, as here, more runs are needed to tell the two rates
# apart: `contact-toolkit sweep runs/tilt_study.yaml --resume --runs 512`.

# %%
results = Results.load(FOLDER)
tilt, friction = results.numbers("tilt [deg]"), results.numbers("friction")
plate = np.array(results.columns["plate"])
for name in ("steel", "rubber"):
    stood = results.passed[plate == name]
    low, high = interval(int(stood.sum()), len(stood))
    print(f"{name}: {stood.sum()} of {len(stood)} stood, the rate is {low:.0%} to {high:.0%}")

# %% [markdown]
# What the rates cannot tell, the places of the runs do. On paper the block stands left of both
# lines. On steel it does, to a fraction of a degree; rubber gives way under its lower edge, so that
# it falls sooner.

# %%
fig, panels = plt.subplots(1, 2, figsize=(9, 3.9), sharey=True, layout="constrained")
slope = np.linspace(14, 32, 100)
for ax, name in zip(panels, ("steel", "rubber"), strict=True):
    for stood, marker, said in ((True, "go", "stood"), (False, "rx", "did not")):
        which = (plate == name) & (results.passed == stood)
        ax.plot(tilt[which], friction[which], marker, markersize=5, label=said)
    ax.plot(slope, np.tan(np.radians(slope)), "k:", label=r"slides: $\mu = \tan\theta$")
    ax.axvline(np.degrees(np.arctan(0.5)), color="k", ls="--", label="falls: tan θ = 0.5")
    ax.set(title=name, xlabel="tilt [deg]", ylim=(0.18, 0.72))
panels[0].set_ylabel("friction μ")
fig.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
plt.show()
off = results.passed != (np.tan(np.radians(tilt)) < np.minimum(friction, 0.5))
for name in ("steel", "rubber"):
    odd = ", ".join(f"{degrees:.1f}°" for degrees in np.sort(tilt[off & (plate == name)]))
    print(f"otherwise than on paper, on {name}: {odd}")

# %% [markdown]
# ## The report
#
# `contact-toolkit report runs/tilt_study` writes one page that needs no network: rates by
# parameter, maps, scatter, histograms, the best and the worst runs.

# %%
page = write_report(FOLDER)
print(page)
(RUNS / "tilt_study.html").write_bytes(page.read_bytes())
IFrame("runs/tilt_study.html", width="100%", height=420)

# %% [markdown]
# Its first map is there as a picture too. Each cell says how many of its runs stood, and the
# interval of the rate.

# %%
Image(FOLDER / "success.png", width=560)

# %% [markdown]
# ## One run again
#
# A row holds all that its run was made of. This is the one that turned furthest:

# %%
row = results.named("worst")
summary = simulate_again(FOLDER, "worst")
print(f"{summary.verdict}: on {plate[row]}, {tilt[row]:.1f}°, friction {friction[row]:.2f}")
folder = FOLDER / "playbacks" / f"run-{results.columns['run'][row]}"
(RUNS / "worst.html").write_bytes((folder / "playback.html").read_bytes())
IFrame("runs/worst.html", width="100%", height=380)

# %% [markdown]
# ## A fit
#
# The other way round: how a block slid was measured, what is the friction? The measurement is made
# here, with $\mu = 0.31$ and 1 mm of noise. `fit` searches by least squares over rollouts; the
# interval comes from what remains. For series in CSV files there is `contact-toolkit fit`.


# %%
def slide(values):
    """Return where the block is on a plate of 22°, every 10 ms [m]."""
    inputs = {TILT: 22.0, "contact.friction.static": values["friction"]}
    record = scenarios.rollout(str(RUNS / "tall_block.yaml"), inputs, record=True).record
    return record["block.x"] - record["block.x"][0]


TRUE = 0.31
clean = slide({"friction": TRUE})
measured = clean + np.random.default_rng(1).normal(scale=1e-3, size=clean.shape)
free = FreeParameter(start=0.2, lower=0.05, upper=0.39, step=0.01)
found = fit(slide, measured, {"friction": free})
mu = found.estimates["friction"]
print(f"friction {mu.value:.4f}, {mu.lower:.4f} to {mu.upper:.4f}; it was {TRUE}")
print(f"{found.evaluations} rollouts, off by {1e3 * np.std(found.residuals):.2f} mm rms")

# %%
time = 0.01 * np.arange(len(measured))
fig, ax = plt.subplots(figsize=(7, 3), layout="constrained")
ax.plot(time, 1e3 * measured, ".", label="measured")
ax.plot(time, 1e3 * (measured + found.residuals), label=f"fitted, μ = {mu.value:.3f}")
ax.plot(time, 1e3 * slide({"friction": 0.2}), ":", label="where the search began, μ = 0.2")
ax.set(xlabel="time [s]", ylabel="slid [mm]")
ax.legend()
plt.show()
