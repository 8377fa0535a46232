"""Capsules and cylinders on flat ground, sampled on a lattice of their own."""

from __future__ import annotations

import math

import numpy as np
import pytest
from area_experiments import Web, pose
from scipy.spatial.transform import Rotation

from contact_toolkit import CollisionMesh
from contact_toolkit.shapes import primitives
from contact_toolkit.shapes.primitives import Primitive

pytestmark = pytest.mark.engine

K, RADIUS, LENGTH = 1e9, 0.06, 0.4  # [Pa/m], [m]
DEPTH = 1e-4  # [m]
GROUND = {
    "box": (Primitive("box", (2.0, 2.0, 0.2)), 0.1),
    "half_space": (Primitive("half_space", (100.0,)), 0.0),
}
LYING = Rotation.from_euler("y", 90, degrees=True)


def line_force(length: float) -> float:
    """K ∫ d dA over the lateral surface, d = R cos θ - (R - δ)."""
    half = math.acos(1 - DEPTH / RADIUS)
    return 2 * K * length * RADIUS * (RADIUS * math.sin(half) - (RADIUS - DEPTH) * half)


def rod(kind: str) -> CollisionMesh:
    return CollisionMesh.from_primitive(Primitive(kind, (RADIUS, LENGTH)))


def facets(kind: str) -> CollisionMesh:
    """The same as nothing but facets, twenty times closer to it than it is pressed in."""
    return CollisionMesh(*getattr(primitives, kind)(RADIUS, LENGTH, 0.05 * DEPTH / RADIUS))


def found(kind: str, roll: float, **options: object):
    """Return the wrench on a rod that lies on the ground, turned about its axis, and the height."""
    primitive, top = GROUND[kind]
    web = Web(rod("cylinder"), CollisionMesh.from_primitive(primitive), K, **options)
    R = (LYING * Rotation.from_euler("z", roll)).as_matrix()
    X_GR = pose([0.03, 0.02, top + RADIUS - DEPTH], R)
    return web.wrench(np.linalg.inv(X_GR)), R


@pytest.mark.parametrize("ground", GROUND)
def test_a_rod_lies_on_few_springs(ground):
    """A robot on capsules would carry ten thousand, or too few to bear it evenly as it rolls."""
    force = line_force(LENGTH)
    bore = []
    for roll in np.linspace(0, 0.1, 40):
        wrench, R = found(ground, roll, nominal_force=force)
        assert len(wrench.rows["key"]) < 250
        bore.append(R @ wrench.force)
        # It rolls freely: nothing turns it about its axis.
        assert abs(wrench.moment[2]) < 4e-4 * force * RADIUS
    np.testing.assert_allclose(np.array(bore)[:, 2], force, rtol=1.5e-2)
    assert np.mean(bore, axis=0)[2] == pytest.approx(force, rel=3e-3)
    np.testing.assert_allclose(np.array(bore)[:, :2], 0, atol=1e-9 * force)


def test_a_rod_lies_as_well_on_finer_nodes():
    """Nodes would stand where their spacing is, not where the body is (broken: chords)."""
    wrench, R = found("box", 0.02, nominal_force=line_force(LENGTH), resolution=1e-3)
    assert (R @ wrench.force)[2] == pytest.approx(line_force(LENGTH), rel=1e-3)


@pytest.mark.parametrize("kind", ["capsule", "cylinder"])
def test_a_rod_over_a_rim_feels_it(kind):
    """Between nodes far apart along a rod, the ground's edge would sink into it unnoticed."""
    box = CollisionMesh.from_primitive(Primitive("box", (0.3, 0.3, 0.2)))
    rng = np.random.default_rng(3)
    for _ in range(4):
        R = (Rotation.from_rotvec(0.03 * rng.normal(size=3)) * LYING).as_matrix()
        X_GR = pose([0.15 + 0.05 * rng.normal(), 0.0, 0.12 + RADIUS], R)
        coarse = Web(rod(kind), box, K, nominal_force=line_force(LENGTH))
        fine = Web(facets(kind), box, K, sampled="a", resolution=4e-3)
        assert coarse.native.samples_a
        # Down to where it bears about as much as it lies on.
        while (R @ coarse.wrench(np.linalg.inv(X_GR)).force)[2] < line_force(LENGTH):
            X_GR[2, 3] -= 2e-5
        one, other = (web.wrench(np.linalg.inv(X_GR)) for web in (coarse, fine))
        size = np.linalg.norm(other.force)
        np.testing.assert_allclose(one.force, other.force, atol=0.03 * size)
        np.testing.assert_allclose(one.moment, other.moment, atol=0.03 * size * LENGTH / 2)
