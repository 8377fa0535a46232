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
# # The contact law against its closed forms
#
# You will learn what the contact law says, which of its consequences are known on paper, and how
# near a simulation comes to them: the restitution of an impact, its depth and duration, how deep a
# body rests, and how fast it slides. No figure here is fitted.

# %%
import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import solve_ivp

from contact_toolkit import CollisionMesh, NonlinearDamper
from contact_toolkit.parts import box
from contact_toolkit.testbed import MovingBody, Testbed

# %% [markdown]
# ## The law
#
# A spring that is deformed by $\delta > 0$, at the rate $\dot\delta$ (positive while approaching),
# pushes with
#
# $$F = k\,\delta^n \left(1 + \tfrac{3}{2} \alpha \dot\delta\right),$$
#
# but never pulls. It is zero at touch, whatever the speed. An impact runs through a loop; the area
# within is what the impact costs.


# %%
def impact(damper, mass, speed):
    """One mass on one spring, by scipy: time [s], deformation [m] and its rate [m/s]."""

    def motion(_, state):
        return state[1], -float(damper.force(*state)) / mass

    def parted(_, state):
        return state[0]

    parted.terminal, parted.direction = True, -1
    longest = 20 * damper.elastic_impact_time(mass, speed)
    solution = solve_ivp(
        motion, (0, longest), (0.0, speed), "DOP853", events=parted, rtol=1e-10, atol=1e-14
    )
    return solution.t, *solution.y


fig, ax = plt.subplots(figsize=(7, 3), layout="constrained")
for alpha in (0.0, 0.2, 0.5, 1.0):
    damper = NonlinearDamper(k=1e5, alpha=alpha)
    _, depth, rate = impact(damper, mass=0.1, speed=1.0)
    ax.plot(1e3 * depth, damper.force(depth, rate), label=rf"$\alpha$ = {alpha:g} s/m")
ax.set(xlabel="deformation [mm]", ylabel="force [N]")
ax.legend()
plt.show()

# %% [markdown]
# ## Restitution
#
# With $D = \frac{3}{2} \alpha v$, a body that hits at $v$ leaves at $e v$, where
# $D (1 + e) = \ln\frac{1 + D}{1 - e D}$: neither mass, nor stiffness, nor the exponent $n$ matter.
# Each row below is another mass, stiffness and exponent.

# %%
rng = np.random.default_rng(0)
print("impact at [m/s]   e measured   e closed form")
for speed in (0.01, 0.1, 0.5, 1.0, 3.0, 10.0):
    k, mass, n = 10 ** rng.uniform(3, 7), 10 ** rng.uniform(-2, 1), rng.choice([1.0, 1.5])
    damper = NonlinearDamper(k=k, alpha=0.3, n=n)
    rate = impact(damper, mass, speed)[2]
    print(f"{speed:15.2f} {-rate[-1] / speed:12.6f} {damper.restitution(speed):15.6f}")

# %% [markdown]
# `alpha_for` goes the other way: from one restitution at one speed to $\alpha$. Slower impacts then
# cost less: $e \approx 1 - \alpha v$.

# %%
speeds = np.geomspace(0.01, 20, 200)
fig, ax = plt.subplots(figsize=(7, 3), layout="constrained")
for wanted in (0.9, 0.7, 0.5, 0.2):
    damper = NonlinearDamper(k=1.0, alpha=NonlinearDamper.alpha_for(wanted, 1.0))
    ax.semilogx(speeds, [damper.restitution(v) for v in speeds], label=f"e = {wanted} at 1 m/s")
    ax.plot(1.0, wanted, "k.")
ax.set(xlabel="impact at [m/s]", ylabel="restitution", ylim=(0, 1.02))
ax.legend()
plt.show()

# %% [markdown]
# ## Depth and duration
#
# How deep an impact goes and, without damping, how long it lasts are closed forms too. Here one of
# each for springs from linear to Hertz's. (The deepest is that of the integrator's steps, none of
# which is the turning point itself.)

# %%
print("n   deepest measured [mm]   deepest closed form [mm]")
for n in (1.0, 1.125, 1.25, 1.375, 1.5):
    damper = NonlinearDamper(k=1e6, alpha=0.3, n=n)
    depth = impact(damper, mass=0.5, speed=1.0)[1]
    print(f"{n:5.3f} {1e3 * depth.max():18.4f} {1e3 * damper.peak_deformation(0.5, 1.0):18.4f}")

# %%
print("n   lasts, measured [ms]   closed form [ms]")
for n in (1.0, 1.125, 1.25, 1.375, 1.5):
    damper = NonlinearDamper(k=1e6, n=n)
    time = impact(damper, mass=0.5, speed=1.0)[0]
    print(f"{n:5.3f} {1e3 * time[-1]:18.4f} {1e3 * damper.elastic_impact_time(0.5, 1.0):18.4f}")

# %% [markdown]
# ## The same, between meshes
#
# Between bodies, the springs are spread over the surface: the area web is a foundation of $k$
# pascals a metre. A cube that lands flat is one spring of $k A$, so the closed forms hold for it as
# well. The `Testbed` writes out the equations of motion by itself; neither Drake nor its integrator
# has a part in this.

# %%
MASS, SIDE, GRAVITY = 1.0, 0.1, 9.81
cube, plate = CollisionMesh(*box(SIDE, SIDE, SIDE)), CollisionMesh(*box(0.5, 0.5, 0.1))
FOUNDATION = 1e9  # [Pa/m]


def landing(damper, speed, duration, gravity=0.0):
    """Let the cube arrive at a speed [m/s], face to face with the plate; return its motion."""
    start = np.eye(4)
    start[2, 3] = 0.05 + SIDE / 2
    body = MovingBody.from_density("cube", cube, MASS / SIDE**3, start, [0, 0, 0, 0, 0, -speed])
    testbed = Testbed([body], plate, damper, gravity=[0, 0, -gravity])
    return testbed.run(duration)


print("impact at [m/s]   e measured   e closed form")
for speed in (0.05, 0.1, 0.2, 0.5, 1.0):
    damper = NonlinearDamper(k=FOUNDATION, alpha=0.3)
    moved = landing(damper, speed, duration=0.01)
    print(f"{speed:15.2f} {moved.V_FB[-1, 0, 5] / speed:12.4f} {damper.restitution(speed):15.4f}")

# %% [markdown]
# At rest it carries its weight at the depth $m g / (k A)$. With gravity, it arrives as softly as
# if it were let go at touch:

# %%
damper = NonlinearDamper(k=1e7, alpha=20.0)
moved = landing(damper, 0.0, duration=0.4, gravity=GRAVITY)
sunk = 0.05 + SIDE / 2 - moved.X_FB[:, 0, 2, 3]
rests_at = MASS * GRAVITY / (damper.k * SIDE**2)
print(f"sunk in by {1e6 * sunk[-1]:.2f} µm, on paper {1e6 * rests_at:.2f} µm")
fig, ax = plt.subplots(figsize=(7, 3), layout="constrained")
ax.plot(1e3 * moved.time, 1e6 * sunk, label="simulated")
ax.axhline(1e6 * rests_at, color="k", linestyle=":", label="$m g / (k A)$")
ax.set(xlabel="time [ms]", ylabel="depth [µm]")
ax.legend()
plt.show()

# %% [markdown]
# The settling is slow, because the damping of this law is proportional to the load: it is made for
# impacts. In a diagram, `ContactConfig.settling` lets what is slow come to rest sooner.
