"""Two-body scenes for tests of the contact core: body 0 is the ground, body 1 moves."""

from dataclasses import dataclass

import mesh_shapes
import numpy as np
from numpy.typing import NDArray
from scipy.integrate import RK23

from contact_toolkit import (
    AreaWeb,
    CollisionMesh,
    ContactGeometry,
    ContactModel,
    ContactPair,
    ContactState,
    FacetWeb,
    Friction,
    NonlinearDamper,
)

GRAVITY = 9.81
Floats = NDArray[np.float64]


def stool(feet: tuple[tuple[float, float], ...] = ((0.0, 0.0),)) -> CollisionMesh:
    """Pointed feet on the plane z = 0 at these (x, y); each tip touches a plane in three facets."""
    vertices, faces = [], []
    for x, y in feet:
        tip = len(vertices)
        vertices += [[x, y, 0], [x + 0.02, y, 0.05], [x - 0.01, y + 0.02, 0.05]]
        vertices += [[x - 0.01, y - 0.02, 0.05]]
        faces += [[tip, tip + 2, tip + 1], [tip, tip + 3, tip + 2], [tip, tip + 1, tip + 3]]
        faces += [[tip + 1, tip + 2, tip + 3]]
    return CollisionMesh(vertices, faces)


def plane(cells: int = 1, size: float = 4.0) -> CollisionMesh:
    """The plane z = 0, facing up."""
    return CollisionMesh(*mesh_shapes.sheet(cells, size=size, wave=0.0))


def facet_model(
    body: CollisionMesh,
    ground: CollisionMesh,
    damper: NonlinearDamper,
    *,
    standoff: float = 1e-3,
    friction: Friction | None = None,
    weighting: str = "multiplicity",
    threads: int = 1,
) -> ContactModel:
    return model(
        body,
        ground,
        damper,
        threads=threads,
        web=FacetWeb(standoff, weighting),
        friction=friction,
    )


def model(
    body: CollisionMesh,
    ground: CollisionMesh,
    damper: NonlinearDamper,
    *,
    threads: int = 1,
    web: AreaWeb | FacetWeb,
    friction: Friction | None = None,
) -> ContactModel:
    """The body's mesh is A."""
    geometries = [ContactGeometry("ground", 0, ground), ContactGeometry("body", 1, body)]
    pair = ContactPair(1, 0, damper, web, friction)
    return ContactModel(["world", "body"], geometries, [pair], threads=threads)


def poses(p: Floats | tuple[float, ...], R: Floats | None = None) -> Floats:
    """The ground at the origin, the body at `p`."""
    X_FB = np.tile(np.eye(4), (2, 1, 1))
    X_FB[1, :3, 3] = p
    if R is not None:
        X_FB[1, :3, :3] = R
    return X_FB


def velocities(
    v: Floats | tuple[float, ...] = (0, 0, 0), w: tuple[float, ...] = (0, 0, 0)
) -> Floats:
    """The ground at rest, the body's origin at velocity `v`."""
    return np.array([[0.0] * 6, [*w, *v]])


@dataclass
class Slider:
    """The body as a particle that cannot turn, driven by its contact and a constant force [N].

    One accepted step of an error-controlled integrator at a time, as a simulator would.
    """

    model: ContactModel
    mass: float
    p: Floats
    v: Floats
    force: Floats
    accuracy: float = 1e-8

    def __post_init__(self) -> None:
        self.time = 0.0
        self.state = np.concatenate([np.asarray(self.p, float), np.asarray(self.v, float)])
        self.contact_state: ContactState = self.model.initial_state()
        self._step: float | None = None
        self._advance()

    def advance_to(self, end: float) -> None:
        while self.time < end:
            first = None if self._step is None else min(self._step, end - self.time)
            solver = RK23(
                self._derivatives,
                self.time,
                self.state,
                end,
                rtol=self.accuracy,
                atol=1e-3 * self.accuracy,
                first_step=first,
            )
            message = solver.step()
            assert solver.status != "failed", message
            self.time, self.state = float(solver.t), solver.y
            self._step = solver.h_abs
            self._advance()

    def forces(self, state: Floats | None = None):
        p, v = np.split(self.state if state is None else state, 2)
        return self.model.evaluate(poses(p), velocities(v), self.contact_state)

    def energy(self) -> float:
        """Kinetic, potential, stored and lost [J]."""
        p, v = np.split(self.state, 2)
        mechanical = 0.5 * self.mass * v @ v - np.asarray(self.force) @ p
        return float(mechanical + self.forces().energies.sum() + self.contact_state.losses.sum())

    def _derivatives(self, _time: float, state: Floats) -> Floats:
        total = self.forces(state).body_wrenches[1, 3:] + self.force
        return np.concatenate([state[3:], total / self.mass])

    def _advance(self) -> None:
        self.contact_state = self.model.advance(self.contact_state, self.time, self.forces())
