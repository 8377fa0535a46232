"""Beside row 24: the doughnut on the cone with friction on the area web."""

from __future__ import annotations

import time

import numpy as np
import pytest
from pydrake.geometry import Mesh
from pydrake.multibody.tree import CalcSpatialInertia
from scipy.optimize import brentq
from validation_scenes import GRAVITY, ON_BOTH_PLANTS, Scene, area_web, check, judge, on

from scenarios.parts import doughnut, truncated_cone, write_obj

K = 2e9  # [Pa/m]
TAN_HALF_ANGLE = 0.03 / 0.25
PRESS = 20.0  # [N]

# The program: dropped, pressed, left alone, pulled.
LANDED, PRESSED, RELEASED, END = 0.8, 1.2, 1.6, 2.0


class Doughnut:
    def __init__(self, folder, mu: float, time_step: float) -> None:
        scene = Scene(time_step=time_step)
        shapes = {
            name: Mesh(write_obj(folder / f"{name}.obj", part()))
            for name, part in (("cone", truncated_cone), ("doughnut", doughnut))
        }
        scene.shape(scene.plant.world_body(), shapes["cone"])
        inertia = CalcSpatialInertia(shapes["doughnut"], 450.0)
        self.body = scene.plant.AddRigidBody("doughnut", inertia)
        scene.shape(self.body, shapes["doughnut"])
        self.weight = inertia.get_mass() * GRAVITY

        def push(t: float):
            down = np.interp(t, [LANDED, LANDED + 0.2, PRESSED, PRESSED + 0.2], [0, 1, 1, 0])
            up = np.interp(t, [RELEASED, RELEASED + 0.2], [0, 1])
            return np.array([0, 0, 0, 0, 0, 1.5 * self.weight * up - PRESS * down])

        self.run = scene.build(area_web(K, alpha=10.0, mu=mu), push, step=None)
        self.run.place(self.body, p=(2e-4, 1e-4, 0.171))

    def height(self, at: float) -> float:
        self.run.advance_to(at)
        return self.run.point(self.body)[2]


def height_without_friction(weight: float, cuts: int = 16) -> float:
    """Where K times the depth, summed over the doughnut's facets, bears the weight; no engine.

    The cone is convex: a point within is as deep as the closest of the planes of its facets. Each
    facet of the doughnut that may touch is cut into `cuts`² triangles, whose middles are sampled.
    """
    points, faces = truncated_cone()
    a, b, c = (points[faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    planes = np.unique(np.c_[normals, (normals * a).sum(axis=1)].round(12), axis=0)

    points, faces = doughnut()
    corners = points[faces]
    corners = corners[np.linalg.norm(corners[..., :2], axis=2).min(axis=1) < 0.034]  # inner rim
    areas = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    ) / (2 * cuts**2)
    i, j, up = (index.ravel() for index in np.mgrid[:cuts, :cuts, :2])
    inside = i + j + up < cuts
    middles = (np.c_[i, j] + (1 + up[:, None]) / 3)[inside] / cuts
    middles = np.c_[middles, 1 - middles.sum(axis=1)]

    def excess(height: float) -> float:
        force = 0.0
        for triangle, area in zip(corners, areas, strict=True):
            above = (middles @ triangle + [0, 0, height]) @ planes[:, :3].T - planes[:, 3]
            depth = np.maximum(0, -above.max(axis=1))
            force += K * area * depth @ planes[above.argmax(axis=1), 2]
        return force - weight

    return brentq(excess, 0.165, 0.169, xtol=1e-7)


@pytest.mark.slow
@ON_BOTH_PLANTS
def test_a_doughnut_wedges_on_a_cone_by_friction_alone(record_property, tmp_path, time_step):
    """It springs back after being pressed, and lifts off, iff μ < tan of the half-angle."""
    free = None
    for share in (0.1, 2.5):
        start = time.process_time()
        stack = Doughnut(tmp_path, share * TAN_HALF_ANGLE, time_step)
        landed, pressed, released, pulled = map(stack.height, (LANDED, PRESSED, RELEASED, END))
        speed = END / (time.process_time() - start)
        free = free or height_without_friction(stack.weight)
        name = f"doughnut on cone, μ = {share:g} tan β" + on(time_step)
        if share < 1:
            for when, height in (("landed", landed), ("pressed and released", released)):
                row = (24, f"{name}: height [mm], {when}")
                check(record_property, row, 1e3 * free, 1e3 * height, 0.2, relative=False)
            verdict = "lifts off" if pulled > released + 0.01 else "holds"
            judge(record_property, (24, f"{name}: pressed, pulled"), "lifts off", verdict)
        else:
            kept = (free - released) / (free - pressed)
            wedged = kept > 0.8 and pulled - released < 1e-5
            verdict = "wedged" if wedged else "let go"
            judge(record_property, (24, f"{name}: pressed, pulled"), "wedged", verdict)
        record_property("validation", (24, f"{name}: real-time factor", "", speed, "", ""))
