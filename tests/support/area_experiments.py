"""Experiments on the area web alone: two bodies, one of them held, no friction.

Each function measures one property and returns figures; the tests ask whether they are good enough,
`benchmarks/area_web_evidence.py` prints them. Forces in [N], lengths in [m].
"""

from collections.abc import Callable
from dataclasses import dataclass

import mesh_shapes
import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial import Delaunay
from scipy.spatial.transform import Rotation

from contact_toolkit import CollisionMesh, _core
from scenarios import parts

Array = NDArray[np.float64]


def pose(p: object = (0, 0, 0), R: object = None) -> Array:
    X = np.eye(4)
    X[:3, 3] = p
    if R is not None:
        X[:3, :3] = R
    return X


class Web:
    """An area web between two surfaces (vertices, faces) or meshes."""

    def __init__(self, A: object, B: object, stiffness: float, **options: object) -> None:
        meshes = [S if isinstance(S, CollisionMesh) else CollisionMesh(*S) for S in (A, B)]
        for name, kind in (("field", _core.AreaField), ("sampled", _core.AreaSide)):
            if name in options:
                options[name] = getattr(kind, options[name])
        bodies = [mesh._area_body() for mesh in meshes]
        self.native = _core.AreaWeb(*bodies, stiffness, **options)

    def find(self, X_AB: Array) -> dict:
        return self.native.find(np.ascontiguousarray(X_AB, dtype=float))

    def wrench(self, X_AB: Array, v_AB: Array | None = None, alpha: float = 0.0) -> "Wrench":
        """The force of B on A; v_AB (2, 3): angular velocity and velocity (at Ao) of A in B."""
        rows = self.find(X_AB)
        force = rows["elastic"]
        if v_AB is not None and alpha:
            v = v_AB[1] + np.cross(v_AB[0], rows["p_AC"])
            rate = -(rows["gradient_A"] * v).sum(axis=1)
            force = force * np.maximum(0, 1 + 1.5 * alpha * rate)
        F = force[:, None] * rows["gradient_A"]
        moment = np.cross(rows["p_AC"], F).sum(axis=0)
        return Wrench(F.sum(axis=0), moment, rows["energy"].sum(), rows)


@dataclass(frozen=True)
class Wrench:
    """Of B on A, in A, the moment about Ao."""

    force: Array
    moment: Array
    energy: float
    rows: dict


@dataclass(frozen=True)
class Motion:
    """Of a free body A over a held body B: poses of A in B."""

    time: Array
    p_BA: Array
    q_BA: Array  # [x y z w]
    v: Array  # of Ao, in B
    w_A: Array  # angular velocity, in A
    elastic: Array
    kinetic: Array
    potential: Array
    touch_downs: int

    @property
    def total(self) -> Array:
        return self.elastic + self.kinetic + self.potential


def fly(
    web: Web,
    X_BA: Array,
    *,
    mass: float,
    inertia: Array,
    duration: float,
    gravity: float = 9.81,
    alpha: float = 0.0,
    velocity: object = (0, 0, 0),
    tolerance: float = 1e-8,
    method: str = "DOP853",
    step: float = np.inf,
) -> Motion:
    """Integrate the rigid-body motion of A about its centre of mass Ao; `inertia` is diagonal."""
    inertia = np.asarray(inertia, dtype=float)

    def split(y: Array) -> tuple[Array, Array, Array, Array]:
        return y[:3], y[3:7] / np.linalg.norm(y[3:7]), y[7:10], y[10:13]

    def load(y: Array) -> tuple[Wrench, Array, Array]:
        p, q, v, w = split(y)
        R = Rotation.from_quat(q).as_matrix()
        X_AB = pose(-R.T @ p, R.T)
        return web.wrench(X_AB, np.stack([w, R.T @ v]), alpha), R, p

    def rate(_: float, y: Array) -> Array:
        _, q, v, w = split(y)
        wrench, R, _ = load(y)
        a = R @ wrench.force / mass - [0, 0, gravity]
        dw = (wrench.moment - np.cross(w, inertia * w)) / inertia
        x, y_, z, s = q
        dq = 0.5 * np.array(
            [
                s * w[0] + y_ * w[2] - z * w[1],
                s * w[1] + z * w[0] - x * w[2],
                s * w[2] + x * w[1] - y_ * w[0],
                -x * w[0] - y_ * w[1] - z * w[2],
            ]
        )
        return np.concatenate([v, dq, a, dw])

    start = np.concatenate(
        [X_BA[:3, 3], Rotation.from_matrix(X_BA[:3, :3]).as_quat(), velocity, np.zeros(3)]
    )
    found = solve_ivp(
        rate, (0, duration), start, method, rtol=tolerance, atol=tolerance * 1e-2, max_step=step
    )
    assert found.success, found.message
    p, q, v, w = found.y[:3].T, found.y[3:7].T, found.y[7:10].T, found.y[10:].T
    elastic = np.array([load(y)[0].energy for y in found.y.T])
    touching = elastic > 0
    return Motion(
        found.t,
        p,
        q,
        v,
        w,
        elastic,
        0.5 * mass * (v**2).sum(1) + 0.5 * (inertia * w**2).sum(1),
        mass * gravity * p[:, 2],
        int((touching[1:] & ~touching[:-1]).sum()),
    )


# --- the bodies ----------------------------------------------------------------------------------


def doughnut_and_cone(sections: int) -> tuple[parts.Surface, parts.Surface]:
    """The bodies of the Rock-N-Stack; they touch at z ≈ 0.168 m."""
    doughnut = parts.doughnut(major_sections=sections, minor_sections=sections // 2)
    return doughnut, parts.truncated_cone(sections=2 * sections, rings=sections * 5 // 8)


def doughnut_on_cone(sections: int = 64, **options: object) -> Web:
    """A is the doughnut, B the cone."""
    return Web(*doughnut_and_cone(sections), 1e8, **options)


DOUGHNUT = {"mass": 1.0, "inertia": (1.5e-3, 1.5e-3, 2.8e-3)}


def slab_of_scattered_facets(seed: int = 0) -> tuple[Array, NDArray[np.int32]]:
    """A closed slab, 1 m square and 0.2 m thick, its flat top (z = 0) triangulated irregularly."""
    rng = np.random.default_rng(seed)
    border = np.linspace(-0.5, 0.5, 9)
    rim = [(x, y) for x in border for y in border if max(abs(x), abs(y)) == 0.5]
    inner = rng.uniform(-0.49, 0.49, (400, 2))
    top = np.vstack([rim, inner])
    triangles = Delaunay(top).simplices
    a, b, c = (top[triangles[:, k]] for k in range(3))
    turn = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    triangles = triangles[turn != 0]
    turn = turn[turn != 0]
    triangles[turn < 0] = triangles[turn < 0][:, ::-1]
    n = len(top)
    vertices = np.vstack([np.c_[top, np.zeros(n)], np.c_[top, np.full(n, -0.2)]])
    edges = np.vstack([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    twice = {tuple(edge) for edge in edges.tolist()}
    outline = [edge for edge in edges.tolist() if (edge[1], edge[0]) not in twice]
    walls = [[[j, i, i + n], [j, i + n, j + n]] for i, j in outline]
    faces = np.vstack([triangles, triangles[:, ::-1] + n, np.array(walls).reshape(-1, 3)])
    return vertices, faces.astype(np.int32)


# --- P1, P2: continuity and conservation ---------------------------------------------------------


def path_over_cone(s: float) -> Array:
    """Pose of the cone in the doughnut on a closed tour, s in [0, 1], pressed in all the way."""
    turn = 2 * np.pi * s
    tilt = [0.02 * np.cos(turn), 0.02 * np.sin(2 * turn), 0.4 * np.sin(turn)]
    R = Rotation.from_rotvec(tilt).as_matrix()
    offset = np.array([1e-3 * np.sin(turn), 1e-3 * np.cos(turn), 1.5e-3 * np.cos(2 * turn)])
    return pose(offset - [0, 0, 0.1645], R)


def forces_along(web: Web, path: Callable[[float], Array], steps: int) -> Array:
    """The force at the ends of `steps` equal pieces of a path, (steps + 1, 3)."""
    return np.array([web.wrench(path(i / steps)).force for i in range(steps + 1)])


def largest_change(forces: Array, stride: int = 1) -> float:
    """Of the force over a step of `stride` pieces of a path, as a share of the largest force."""
    changes = np.linalg.norm(np.diff(forces[::stride], axis=0), axis=1)
    return float(changes.max() / np.linalg.norm(forces, axis=1).max())


def jump_left(web: Web, path: Callable[[float], Array], steps: int, halvings: int = 24) -> float:
    """The largest jump of the force at a point of a path, as a share of the largest force.

    Each of `steps` pieces is halved again and again, towards the half where the force changes more.
    """
    largest, jump = 0.0, 0.0
    for i in range(steps):
        a, b = i / steps, (i + 1) / steps
        at_a, at_b = web.wrench(path(a)).force, web.wrench(path(b)).force
        largest = max(largest, float(np.linalg.norm(at_a)))
        for _ in range(halvings):
            middle = 0.5 * (a + b)
            between = web.wrench(path(middle)).force
            if np.linalg.norm(between - at_a) > np.linalg.norm(at_b - between):
                b, at_b = middle, between
            else:
                a, at_a = middle, between
        jump = max(jump, float(np.linalg.norm(at_b - at_a)))
    return jump / largest


def closed_loop_work(web: Web, path: Callable[[float], Array], steps: int) -> float:
    """The work of the contact over a closed tour, as a share of the largest energy stored."""
    work, most = 0.0, 0.0
    h = 1e-6
    for i in range(steps):
        s = (i + 0.5) / steps
        wrench = web.wrench(path(s))
        X, before, after = path(s), path(s - h), path(s + h)
        # B moves in A: the force on B is the opposite, and its power is minus that on A.
        dp = (after[:3, 3] - before[:3, 3]) / (2 * h)
        turn = (after[:3, :3] - before[:3, :3]) / (2 * h) @ X[:3, :3].T
        w = 0.5 * np.array(
            [turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]
        )
        moment = wrench.moment - np.cross(X[:3, 3], wrench.force)  # about Bo
        work -= (wrench.force @ dp + moment @ w) / steps
        most = max(most, wrench.energy)
    return work / most


def gradient_error(web: Web, X_AB: Array, h: float = 1e-7) -> float:
    """How far the wrench is from the energy's derivative, as a share of the force."""
    wrench = web.wrench(X_AB)
    worst = 0.0
    for axis in np.eye(3):
        slope = (
            web.wrench(pose(h * axis) @ X_AB).energy - web.wrench(pose(-h * axis) @ X_AB).energy
        ) / (2 * h)
        worst = max(worst, abs(slope - wrench.force @ axis))
        turned = [
            web.wrench(pose(R=Rotation.from_rotvec(side * h * axis).as_matrix()) @ X_AB).energy
            for side in (1, -1)
        ]
        arm = np.linalg.norm(X_AB[:3, 3]) or 1.0
        worst = max(worst, abs((turned[0] - turned[1]) / (2 * h) - wrench.moment @ axis) / arm)
    return worst / np.linalg.norm(wrench.force)


def bouncing_drift(web: Web, duration: float = 1.5, **options: object) -> tuple[float, int]:
    """Energy lost or won by the doughnut bouncing on the cone, as a share of its drop."""
    X_BA = pose([4e-4, 0, 0.172], Rotation.from_rotvec([0.01, 0.02, 0]).as_matrix())
    motion = fly(web, X_BA, duration=duration, **DOUGHNUT, **options)
    drop = 9.81 * (0.172 - 0.1675)
    return float(np.abs(motion.total - motion.total[0]).max() / drop), motion.touch_downs


def work_of_release(**options: object) -> float:
    """Work of the force on a straight way out of 1 mm of overlap, over the energy stored, less one.

    By Gauss's rule over many short pieces, so that no integration of motion comes in.
    """
    web = Web(parts.doughnut(), parts.box(1, 1, 0.2), 1e8, **options)
    R_BA = Rotation.from_rotvec([0.02, 0.01, 0]).as_matrix()

    def at(z: float) -> Wrench:
        return web.wrench(pose(-R_BA.T @ [0.01, 0.02, z], R_BA.T))

    abscissas, weights = np.polynomial.legendre.leggauss(6)
    heights = np.linspace(0.119, 0.1225, 801)
    half = 0.5 * (heights[1] - heights[0])
    work = sum(
        half * weight * (R_BA @ at(low + half * (1 + x)).force)[2]
        for low in heights[:-1]
        for x, weight in zip(abscissas, weights, strict=True)
    )
    assert at(heights[-1]).energy == 0
    return float(work / at(heights[0]).energy - 1)


def release(tolerance: float = 1e-11, **options: object) -> float:
    """Kinetic energy of a doughnut out of 1 mm of overlap, over the energy stored, less one."""
    web = Web(parts.doughnut(), parts.box(1, 1, 0.2), 1e8, **options)
    X_BA = pose([0.01, 0.02, 0.12], Rotation.from_rotvec([0.02, 0.01, 0]).as_matrix())
    X_BA[2, 3] -= 1e-3
    motion = fly(web, X_BA, gravity=0.0, duration=0.1, tolerance=tolerance, **DOUGHNUT)
    assert motion.elastic[-1] == 0, "still touching: give it longer"
    return float(motion.kinetic[-1] / motion.elastic[0] - 1)


# --- P3, P4: the meshes do not show --------------------------------------------------------------


def box_on_plane(divisions: int, **options: object) -> float:
    """Force of a 0.1 m box pressed 50 µm into a slab, in the truth's 500 N (and 0.1 % of walls)."""
    web = Web(parts.box(divisions=divisions), parts.box(1, 1, 0.2), 1e9, **options)
    return float(web.wrench(pose([0.0123, 0.0077, -0.15 + 5e-5])).force[2])


def ball_on_ball(frequency: int, spacing: float, cuts: int = 0, **options: object) -> float:
    """Force of a faceted ball on a finely faceted one, over π K R_eff δ² of the exact balls.

    `spacing` of the nodes is in radii of the patch; the mean over directions is reported. Each of
    `cuts` cuts every facet of the first ball into four, which leaves its surface as it was.
    """
    R, depth = 0.05, 4e-4
    surface = parts.icosphere(radius=R, frequency=frequency)
    for _ in range(cuts):
        surface = mesh_shapes.subdivided(*surface)
    faceted = CollisionMesh(*surface)
    fine = CollisionMesh(*parts.icosphere(radius=R, frequency=128))
    patch = np.sqrt(2 * (R / 2) * depth)
    resolution = spacing * patch / min(faceted.diagonal, fine.diagonal)
    web = Web(faceted, fine, 1e9, resolution=resolution, sampled="a", **options)
    forces = []
    for direction in np.random.default_rng(0).normal(size=(16, 3)):
        X_AB = pose((2 * R - depth) * direction / np.linalg.norm(direction))
        forces.append(np.linalg.norm(web.wrench(X_AB).force))
    return float(np.mean(forces) / (np.pi * 1e9 * (R / 2) * depth**2))


def sideways(**options: object) -> float:
    """Force along the slab on a box sliding over its irregular facets, over the force across.

    The slab lies askew in its own frame, so that nothing is along an axis of a lattice.
    """
    askew = Rotation.from_rotvec([0.3, -0.5, 0.7]).as_matrix()
    vertices, faces = slab_of_scattered_facets()
    web = Web(parts.box(), (vertices @ askew.T, faces), 1e9, **options)
    worst = 0.0
    for x in np.linspace(-0.2, 0.2, 41):
        force = web.wrench(pose([x, 0.3 * x, -0.05 + 5e-5], askew.T)).force
        worst = max(worst, float(np.hypot(*force[:2]) / force[2]))
    return worst


# --- P6: deep contact ----------------------------------------------------------------------------


def block_through_plate(depths: Array, **options: object) -> Array:
    """Force up on a 40 mm block pressed into the middle of a 2 mm plate, over K A times 1 mm."""
    web = Web(parts.box(0.04, 0.04, 0.04), parts.box(0.2, 0.2, 0.002), 1e9, **options)
    forces = [web.wrench(pose([0.003, 0.002, -0.021 + d])).force[2] for d in depths]
    return np.array(forces) / (1e9 * 0.04**2 * 1e-3)


# --- P7: crossing edges --------------------------------------------------------------------------


def crossed_edges_pose(depth: float, x: float, y: float) -> Array:
    """Of box B in box A, both 0.1 m: an edge of A above an edge of B, overlapping, at x, y in B."""
    edge_up = Rotation.from_euler("y", 45, degrees=True).as_matrix()
    edge_down = Rotation.from_euler("x", 45, degrees=True).as_matrix()
    return np.linalg.inv(pose([x, y, 0.1 * np.sqrt(2) - depth], edge_down)) @ pose(R=edge_up)


def crossed_edges(web: Web, depth: float, x: float, y: float) -> Wrench:
    return web.wrench(crossed_edges_pose(depth, x, y))


# --- coming to rest ------------------------------------------------------------------------------


def rocking(
    times: tuple[float, ...], window: float = 0.5, **options: object
) -> tuple[list[float], float]:
    """How far the damped, frictionless doughnut still moves sideways; its last force over m g.

    Dropped askew and left alone; the motions are those in a `window` [s] before each of `times`.
    """
    # Forces that jump want short steps of low order, and get no accuracy from small tolerances.
    jumps = options.get("field") == "exact"
    steps = {"method": "RK23", "tolerance": 1e-4} if jumps else {"tolerance": 1e-6}
    web = doughnut_on_cone(**options)
    X_BA = pose([0, 0, 0.1685], Rotation.from_rotvec([0.02, 0.01, 0]).as_matrix())
    motion = fly(web, X_BA, duration=times[-1], alpha=2.0, **steps, **DOUGHNUT)
    X_BA = pose(motion.p_BA[-1], Rotation.from_quat(motion.q_BA[-1]).as_matrix())
    force = X_BA[:3, :3] @ web.wrench(np.linalg.inv(X_BA)).force
    moved = []
    for time in times:
        near = (motion.time > time - window) & (motion.time <= time)
        moved.append(float(np.linalg.norm(np.ptp(motion.p_BA[near, :2], axis=0))))
    return moved, float(force[2] / (DOUGHNUT["mass"] * 9.81))
