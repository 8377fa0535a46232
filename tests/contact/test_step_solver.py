"""Steps of floating bodies without a simulator: random impacts and pile-ups.

Truths: the balance of momentum, worked out in numpy from what ContactModel says of the forces at
the end; that backward Euler makes no energy; that Newton's method converges quadratically.
"""

import mesh_shapes
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from contact_toolkit import (
    AreaWeb,
    CollisionMesh,
    ContactGeometry,
    ContactModel,
    ContactPair,
    Friction,
    NonlinearDamper,
    StepSolution,
    StepSolver,
    distance,
)
from contact_toolkit.shapes.primitives import box

pytestmark = pytest.mark.engine

Floats = np.ndarray
DENSITY = 1000.0  # [kg/m³]
GRAVITY = np.array([0, 0, -9.81])
FLOOR = CollisionMesh(*box([1.0, 1.0, 0.2]))
BALL = CollisionMesh(*mesh_shapes.ball(3, radius=0.03))
SHAPES = [
    CollisionMesh(*box([0.06, 0.05, 0.04])),
    BALL,
    CollisionMesh(*mesh_shapes.doughnut(major=0.03, minor=0.012)),
]


class Scene:
    """Bodies over a floor, each a tree of its own, about to meet."""

    def __init__(self, rng: np.random.Generator, meshes: list[CollisionMesh], mu: float) -> None:
        count = len(meshes)
        names = ["floor", *(f"body {i}" for i in range(count))]
        # Off the bodies' origins, so that arms turn.
        self.X_BG = np.tile(np.eye(4), (count + 1, 1, 1))
        self.X_BG[1:, :3, 3] = 0.03 * rng.normal(size=(count, 3))
        geometries = [
            ContactGeometry(name, i, mesh, self.X_BG[i])
            for i, (name, mesh) in enumerate(zip(names, [FLOOR, *meshes], strict=True))
        ]
        damper = NonlinearDamper(k=10 ** rng.uniform(7, 10), alpha=rng.uniform(0, 20))
        pairs = [
            ContactPair(j, i, damper, AreaWeb(resolution=0.1), Friction(mu))
            for i in range(count + 1)
            for j in range(i + 1, count + 1)
        ]
        self.model = ContactModel(names, geometries, pairs)
        masses = [DENSITY * mesh.volume for mesh in meshes]
        gyrations = [0.3 * np.ptp(mesh.vertices, axis=0).max() for mesh in meshes]
        # About the origin and as a ball's: in F the same.
        self.inertia = np.array(
            [np.diag([m * r**2] * 3 + [m] * 3) for m, r in zip(masses, gyrations, strict=True)]
        )
        unit = np.tile(np.eye(4), (count + 1, 1, 1))
        self.X_FB = unit.copy()
        self.X_FB[0, 2, 3] = -0.1  # its top is the plane z = 0
        self.solver = StepSolver(
            self.model,
            num_positions=7 * count,
            num_velocities=6 * count,
            v_start=range(0, 6 * count, 6),
            nv=[6] * count,
            q_start=range(0, 7 * count, 7),
            inertia_R=self.inertia,
            tree=[-1, *range(count)],
            X_RB=unit,
        )
        self.step = 10 ** rng.uniform(-3.5, -2.3)
        self.q, self.v = np.tile(np.eye(7)[0], (count, 1)), np.empty((count, 6))
        for i, mesh in enumerate(meshes):
            self.v[i, :3], self.v[i, 3:] = 10 * rng.normal(size=3), rng.normal(size=3)
            turn = Rotation.random(random_state=rng)
            self.q[i, :4] = turn.as_quat()[[3, 0, 1, 2]]
            middle = turn.apply(self.X_BG[i + 1, :3, 3])
            lowest = (mesh.vertices @ turn.as_matrix().T)[:, 2].min()
            place = [*(0.005 * rng.normal(size=2)), rng.uniform(0, 0.003) - lowest]
            self.q[i, 4:] = place - middle
            # Upwards, until it is clear of those before.
            while any(self.gap(meshes, i, j) < 1e-4 for j in range(i)):
                self.q[i, 6] += 0.002

    def gap(self, meshes: list[CollisionMesh], i: int, j: int) -> float:
        X_FG = self.poses(self.q) @ self.X_BG
        return distance(meshes[j], meshes[i], np.linalg.inv(X_FG[j + 1]) @ X_FG[i + 1]).distance

    def poses(self, q: Floats) -> Floats:
        X_FB = self.X_FB.copy()
        for i, row in enumerate(q.reshape(-1, 7)):
            X_FB[i + 1, :3, :3] = Rotation.from_quat(row[[1, 2, 3, 0]]).as_matrix()
            X_FB[i + 1, :3, 3] = row[4:]
        return X_FB

    def solve(self) -> StepSolution:
        begin = self.model.initial_state()
        q, v = self.q.ravel(), self.v.ravel()
        return self.solver.solve_under_gravity(begin, 0.0, self.step, q, v, GRAVITY, self.X_FB)

    def after(self, v: Floats) -> tuple[Floats, Floats]:
        """Return (nb, 4, 4) poses and (nb, 6) velocities at the end of a step at v."""
        q = self.q.copy()
        for row, V in zip(q, v.reshape(-1, 6), strict=True):
            w = 0.5 * self.step * V[:3]
            spin = np.array([-(w @ row[1:4]), *(row[0] * w + np.cross(w, row[1:4]))])
            row[:4] = (row[:4] + spin) / np.linalg.norm(row[:4] + spin)
            row[4:] += self.step * V[3:]
        return self.poses(q), np.vstack([np.zeros(6), v.reshape(-1, 6)])

    def kinetic(self, v: Floats) -> float:
        return sum(0.5 * V @ M @ V for V, M in zip(v.reshape(-1, 6), self.inertia, strict=True))

    @property
    def free(self) -> Floats:
        return self.solver.free_motion(self.q.ravel(), self.v.ravel(), self.step, GRAVITY)


def random_scene(rng: np.random.Generator) -> Scene:
    kinds = rng.integers(len(SHAPES), size=rng.integers(1, 4))
    return Scene(rng, [SHAPES[kind] for kind in kinds], mu=rng.choice([0.0, 0.3, 1.0]))


def require_balance(scene: Scene, solved: StepSolution) -> None:
    X_FB, V_FB = scene.after(solved.v)
    state = scene.model.initial_state()
    forces = scene.model.evaluate(X_FB, V_FB, state)
    impulse = scene.step * forces.body_wrenches[1:]
    change = np.einsum("bij,bj->bi", scene.inertia, (solved.v - scene.free).reshape(-1, 6))
    scale = np.abs(change).max() + 1e-6
    np.testing.assert_allclose(change, impulse, rtol=0, atol=1e-6 * scale)


def test_momentum_is_balanced():
    """A step would end where its forces are not those of its end."""
    rng, converged = np.random.default_rng(1), 0
    for _ in range(100):
        scene = random_scene(rng)
        solved = scene.solve()
        if solved.status == 0:
            require_balance(scene, solved)
            converged += len(solved.forces.contacts) > 0
    assert converged > 30


@pytest.mark.parametrize("seed", [126, 267, 318, 336])
def test_newtons_method_converges_quadratically_near_the_solution(seed):
    """Newton's matrix would lack a term: r₁ ≤ C r₀² and r₂ ≤ C r₁² make r₂ go as r₀⁴, not as r₀.

    A body that hits the floor turning and sliding, solved again from velocities ever closer to the
    solution; two iterations are then enough, and tell what they left.
    """
    rng = np.random.default_rng(seed)
    scene = Scene(rng, [SHAPES[seed % 3]], mu=0.3)
    solved = scene.solve()
    touched = scene.model.advance_implicitly(scene.model.initial_state(), 0.0, solved.forces)

    def solve_from(v: Floats) -> StepSolution:
        return scene.solver.solve(
            touched,
            time=0.0,
            step=scene.step,
            q0=scene.q.ravel(),
            v0=v,
            v_free=scene.free,
            X_FB=scene.X_FB,
            inertia=np.zeros((0, 0)),
            jacobian=np.zeros((2, 6, 0)),
            v_reference=v,
        )

    exact = solve_from(solved.v)
    away = rng.normal(size=6)
    away *= np.linalg.norm(scene.free) / np.linalg.norm(away)
    offsets = np.geomspace(1e-5, 1e-4, 9)
    trials = [solve_from(exact.v + offset * away) for offset in offsets]
    twice = np.array([t.iterations == 2 and t.residual > 1e-12 for t in trials])
    assert twice.sum() >= 3
    residuals = np.array([t.residual for t in trials])
    order, _ = np.polyfit(np.log(offsets[twice]), np.log(residuals[twice]), 1)
    assert order > 3


def impacts(seed: int, count: int) -> tuple[Floats, Floats, Floats]:
    """Return statuses, Newton iterations and gains of energy [-] of single random steps."""
    rng, rows = np.random.default_rng(seed), []
    for _ in range(count):
        scene = random_scene(rng)
        solved = scene.solve()
        before = scene.kinetic(scene.free)
        after = scene.kinetic(solved.v) + solved.forces.stored
        rows.append((solved.status, solved.iterations, after / before - 1))
    statuses, iterations, gains = np.array(rows).T
    return statuses, iterations, gains


@pytest.mark.parametrize("count", [600, pytest.param(10_000, marks=pytest.mark.slow)])
def test_random_impacts_are_solved_quickly_and_make_no_energy(count):
    """Newton's matrix would lack a term: without those of arms that turn, half take a step more."""
    statuses, iterations, gains = impacts(1, count)
    solved = statuses < 2
    assert np.mean(~solved) < 5e-4  # at metres a second, by a tenth of a body in a step
    assert gains[solved].max() < 1e-12
    searched = iterations[iterations > 0]
    assert np.median(searched) <= 5
    assert np.quantile(searched, 0.9) <= 10
