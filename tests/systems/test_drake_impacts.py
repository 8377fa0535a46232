"""Closed forms of an impact, through the whole Drake diagram: mesh, port, force, integrator.

The ball is a tetrahedron on its tip, the ground one flat triangle. The tip belongs to three facets,
so exactly three witness pairs merge into one contact of multiplicity three, right below the centre
of mass: the springs are countable and the motion is one-dimensional.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from pydrake.geometry import Mesh
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder, EventStatus
from scipy.interpolate import CubicHermiteSpline
from validation_scenes import check

from contact_toolkit import NonlinearDamper
from systems import AddNonlinearDamperContact, ContactConfig

SPRINGS = 3
MASS = 0.7
STANDOFF = 0.02
GRAVITY = 9.81

TIP_DOWN = "v 0 0 0\nv .1 0 .1\nv -.05 .08 .1\nv -.05 -.08 .1\nf 1 3 2\nf 1 4 3\nf 1 2 4\nf 2 3 4\n"
TRIANGLE = "v 1 0 0\nv -1 1 0\nv -1 -1 0\nf 1 2 3\n"


@dataclass(frozen=True)
class Flight:
    """What was seen after every step: height and velocity of the tip, energies, contact force."""

    time: np.ndarray
    height: np.ndarray
    velocity: np.ndarray
    energies: np.ndarray
    force: np.ndarray

    def peak_deformation(self) -> float:
        """Return the largest deformation, between steps as well."""
        deformation = CubicHermiteSpline(self.time, STANDOFF - self.height, -self.velocity)
        return float(np.max(deformation(deformation.derivative().roots(extrapolate=False))))

    def impact_time(self) -> float:
        """Return the time between first and last touch; before and after, flight is uniform."""
        start = (self.height[0] - STANDOFF) / -self.velocity[0]
        end = self.time[-1] - (self.height[-1] - STANDOFF) / self.velocity[-1]
        return end - start


class Ball:
    def __init__(
        self,
        folder: Path,
        damper: NonlinearDamper,
        *,
        gravity: float = 0.0,
        weighting: str = "multiplicity",
    ) -> None:
        builder = DiagramBuilder()
        self.plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
        inertia = SpatialInertia.MakeFromCentralInertia(
            MASS,
            [0, 0, 0.075],
            SpatialInertia.SolidSphereWithMass(MASS, 0.05).CalcRotationalInertia(),
        )
        self.ball = self.plant.AddRigidBody("ball", inertia)
        for body, text in ((self.ball, TIP_DOWN), (self.plant.world_body(), TRIANGLE)):
            path = folder / f"{body.name()}.obj"
            path.write_text(text)
            self.plant.RegisterCollisionGeometry(
                body, RigidTransform(), Mesh(path), "mesh", CoulombFriction(0, 0)
            )
        self.plant.mutable_gravity_field().set_gravity_vector([0, 0, -gravity])
        self.plant.Finalize()
        config = ContactConfig(
            web="facet",
            standoff=STANDOFF,
            k=damper.k,
            alpha=damper.alpha,
            n=damper.n,
            weighting=weighting,
        )
        self.contact = AddNonlinearDamperContact(builder, self.plant, scene_graph, config=config)
        self.diagram = builder.Build()

    def fly(
        self,
        height: float,
        velocity: float,
        duration: float,
        *,
        accuracy: float = 1e-9,
        max_step: float = 1.0,
    ) -> Flight:
        simulator = Simulator(self.diagram)
        context = simulator.get_mutable_context()
        plant_context = self.plant.GetMyContextFromRoot(context)
        contact_context = self.contact.GetMyContextFromRoot(context)
        self.plant.SetPositions(plant_context, [1, 0, 0, 0, 0, 0, height])
        self.plant.SetVelocities(plant_context, [0, 0, 0, 0, 0, velocity])
        rows = []

        def watch(root: Context) -> EventStatus:
            state = self.plant.GetPositionsAndVelocities(plant_context)
            energies = self.contact.get_energies_output_port().Eval(contact_context)
            wrenches = self.contact.get_body_wrenches_output_port().Eval(contact_context)
            rows.append([root.get_time(), state[6], state[12], wrenches[-1], *energies])
            return EventStatus.DidNothing()

        simulator.set_monitor(watch)
        integrator = simulator.get_mutable_integrator()
        integrator.set_target_accuracy(accuracy)
        integrator.set_maximum_step_size(max_step)
        integrator.request_initial_step_size_target(max_step)
        simulator.AdvanceTo(duration)
        array = np.array(rows)
        return Flight(
            time=array[:, 0],
            height=array[:, 1],
            velocity=array[:, 2],
            force=array[:, 3],
            energies=array[:, 4:],
        )


def hit(folder: Path, damper: NonlinearDamper, velocity: float, **settings) -> Flight:
    """Hit once without gravity, from just outside the standoff, and fly off."""
    together = replace(damper, k=SPRINGS * damper.k)
    elastic_time = together.elastic_impact_time(MASS, velocity)
    away = 0.1 * elastic_time * velocity
    duration = 3 * elastic_time / damper.restitution(velocity)
    ball = Ball(folder, damper, **settings)
    return ball.fly(STANDOFF + away, -velocity, duration, max_step=elastic_time / 150)


# D = 3/2 α v and the restitution it gives.
RESTITUTION = {0.1: 0.937476, 0.5: 0.748435, 1.0: 0.593624, 2.0: 0.410720, 5.0: 0.196980}


@pytest.mark.parametrize("n", [1.0, 1.5])
@pytest.mark.parametrize("D", RESTITUTION)
def test_restitution(record_property, tmp_path, n, D):
    """Row 1: D (1 + e) = ln[(1 + D) / (1 − e D)], whatever n."""
    velocity = 0.8
    flight = hit(tmp_path, NonlinearDamper(4e4, alpha=D / 1.5 / velocity, n=n), velocity)
    row = (1, "restitution, n = 1 and 1.5, 3/2 α v = 0.1 to 5")
    got = flight.velocity[-1] / velocity
    check(record_property, row, RESTITUTION[D], got, 1e-5, relative=False)


def test_restitution_depends_neither_on_stiffness_nor_on_the_number_of_springs(tmp_path):
    """Row 1 again: a unit-weighted contact is one spring instead of three."""
    velocity, alpha = 0.8, 1.0
    for settings in ({"weighting": "unit"}, {}):
        for k in (4e3, 4e6):
            flight = hit(tmp_path, NonlinearDamper(k, alpha=alpha), velocity, **settings)
            e = NonlinearDamper(k, alpha=alpha).restitution(velocity)
            assert flight.velocity[-1] / velocity == pytest.approx(e, abs=1e-5)


@pytest.mark.parametrize("n", [1.0, 1.5])
def test_restitution_falls_by_alpha_v_at_small_velocities(record_property, tmp_path, n):
    """Row 2: the slope of e at v = 0 is −α."""
    alpha, velocity = 0.3, 0.02
    flight = hit(tmp_path, NonlinearDamper(4e4, alpha=alpha, n=n), velocity)
    e = flight.velocity[-1] / velocity
    row = (2, f"slope of restitution, n = {n:g} [s/m]")
    check(record_property, row, alpha, (1 - e) / velocity, 0.01)


@pytest.mark.parametrize("n", [1.0, 1.5])
@pytest.mark.parametrize("alpha", [0.0, 0.1, 1.5])
def test_peak_deformation(record_property, tmp_path, n, alpha):
    """Row 3: δ^(n+1) = (n+1) (m/k) [v/a − ln(1 + a v)/a²], a = 3/2 α."""
    velocity = 0.8
    flight = hit(tmp_path, NonlinearDamper(4e4, alpha=alpha, n=n), velocity)
    a, k = 1.5 * alpha, SPRINGS * 4e4
    work = velocity / a - math.log1p(a * velocity) / a**2 if alpha else velocity**2 / 2
    peak = ((n + 1) * MASS / k * work) ** (1 / (n + 1))
    row = (3, "peak deformation, n = 1 and 1.5, α = 0 to 1.5 s/m [m]")
    check(record_property, row, peak, flight.peak_deformation(), 1e-5)


def test_linear_impact_takes_half_a_period(record_property, tmp_path):
    """Row 5: T = π √(m/k), F_max = v √(k m)."""
    velocity, k = 0.8, SPRINGS * 4e4
    flight = hit(tmp_path, NonlinearDamper(4e4), velocity)
    duration, peak = math.pi * math.sqrt(MASS / k), velocity * math.sqrt(k * MASS)
    check(record_property, (5, "linear impact: T [s]"), duration, flight.impact_time(), 1e-4)
    check(record_property, (5, "linear impact: F_max [N]"), peak, flight.force.max(), 1e-4)


def test_hertz_impact_time(record_property, tmp_path):
    """Row 6: T = 2.943 δ_m / v, δ_m = (5 m v² / 4 k)^(2/5)."""
    velocity, k = 0.8, SPRINGS * 4e4
    flight = hit(tmp_path, NonlinearDamper(4e4, n=1.5), velocity)
    peak = (5 * MASS * velocity**2 / (4 * k)) ** 0.4
    assert flight.peak_deformation() == pytest.approx(peak, rel=1e-3)
    expected = 2.943 * peak / velocity
    check(record_property, (6, "Hertz impact: T [s]"), expected, flight.impact_time(), 1e-3)


@pytest.mark.parametrize("n", [1.0, 1.5])
def test_bouncing_ball(record_property, tmp_path, n):
    """Row 4: v_(j+1) = e(v_j) v_j at touch, and no energy appears or vanishes."""
    # So stiff that gravity, which the closed form leaves out, does next to nothing in an impact.
    damper = NonlinearDamper(4e6 if n == 1 else 4e7, alpha=0.1, n=n)
    drop = 0.3
    flight = Ball(tmp_path, damper, gravity=GRAVITY).fly(STANDOFF + drop, 0.0, 1.2, max_step=2e-3)
    mechanical = MASS * (flight.velocity**2 / 2 + GRAVITY * flight.height)
    total = mechanical + flight.energies.sum(axis=1)
    drift = np.abs(total - total[0]).max() / (MASS * GRAVITY * drop)
    row = (4, f"bouncing, n = {n:g}: energy drift, share of the start")
    check(record_property, row, 0.0, drift, 1e-4, relative=False)
    touching = flight.height < STANDOFF
    starts = np.flatnonzero(~touching[:-1] & touching[1:])
    lift_offs = np.flatnonzero(touching[:-1] & ~touching[1:]) + 1
    assert len(starts) >= 3
    for start, end in zip(starts, lift_offs, strict=False):
        # In flight, velocity at the standoff follows from height and velocity anywhere.
        down, up = (
            math.sqrt(flight.velocity[i] ** 2 + 2 * GRAVITY * (flight.height[i] - STANDOFF))
            for i in (start, end)
        )
        assert up / down == pytest.approx(damper.restitution(down), abs=1e-3)


@pytest.mark.parametrize("n", [1.0, 1.5])
def test_settling(tmp_path, n):
    """Row 7: rests at (m g / k)^(1/n); for n = 1 swings about it with ζ = (a g / 2) √(m/k)."""
    damper = NonlinearDamper(4e4, alpha=0.6, n=n)
    k = SPRINGS * damper.k
    equilibrium = (MASS * GRAVITY / k) ** (1 / n)
    ball = Ball(tmp_path, damper, gravity=GRAVITY)
    # Let go a little above the equilibrium: small swings, never out of contact.
    flight = ball.fly(STANDOFF - 0.98 * equilibrium, 0.0, 0.4, max_step=1e-3)
    assert flight.height[-1] == pytest.approx(STANDOFF - equilibrium, abs=0.01 * equilibrium)
    if n == 1:
        swing = CubicHermiteSpline(
            flight.time, flight.height - (STANDOFF - equilibrium), flight.velocity
        )
        turns = swing(swing.derivative().roots(extrapolate=False))[1:8]
        decrement = np.log(-turns[:-1] / turns[1:]).mean()
        zeta = decrement / math.hypot(decrement, math.pi)
        expected = 1.5 * damper.alpha * GRAVITY / 2 * math.sqrt(MASS / k)
        assert zeta == pytest.approx(expected, rel=0.01)
