"""Beside row 24: the doughnut on the cone with friction on the area web."""

from __future__ import annotations

import time

import numpy as np
import pytest
from pydrake.geometry import Mesh
from pydrake.multibody.tree import CalcSpatialInertia
from validation_scenes import GRAVITY, Scene, area_web, check, judge

from scenarios.parts import doughnut, truncated_cone, write_obj

K = 2e9  # [Pa/m]
TAN_HALF_ANGLE = 0.03 / 0.25
PRESS = 20.0  # [N]

# The program: dropped, pressed, left alone, pulled.
LANDED, PRESSED, RELEASED, END = 0.8, 1.2, 1.6, 2.0


class Doughnut:
    def __init__(self, folder, mu: float) -> None:
        scene = Scene()
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

        contact = area_web(K, alpha=10.0, mu=mu, resolution=0.01)
        self.run = scene.build(contact, push, step=4e-4)
        self.run.place(self.body, p=(2e-4, 1e-4, 0.171))

    def height(self, at: float) -> float:
        self.run.advance_to(at)
        return self.run.point(self.body)[2]


@pytest.mark.slow
def test_a_doughnut_wedges_on_a_cone_by_friction_alone(record_property, tmp_path):
    """It springs back after being pressed, and lifts off, iff μ < tan of the half-angle."""
    free = Doughnut(tmp_path, 0.0).height(LANDED)
    for share in (0.1, 2.5):
        start = time.process_time()
        stack = Doughnut(tmp_path, share * TAN_HALF_ANGLE)
        landed, pressed, released, pulled = map(stack.height, (LANDED, PRESSED, RELEASED, END))
        name = f"doughnut on cone, μ = {share:g} tan β"
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
        speed = END / (time.process_time() - start)
        record_property("validation", (24, f"{name}: real-time factor", "", speed, "", ""))
