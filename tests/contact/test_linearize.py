"""ContactModel.linearize against central differences of the forces that evaluate computes.

A derivative that lacks a term makes Newton's method converge slowly or not at all: each case below
loads other terms. Poses are generic, so that nothing vanishes by symmetry, and body b, which the
motion is relative to, moves too.
"""

from dataclasses import dataclass, field
from typing import Any

import contact_scenes as scenes
import mesh_shapes
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from contact_toolkit import (
    AreaWeb,
    CollisionMesh,
    ContactGeometry,
    ContactModel,
    ContactPair,
    ContactState,
    FacetWeb,
    Friction,
    Linearization,
    NonlinearDamper,
)

pytestmark = pytest.mark.engine

Floats = np.ndarray
FIXED, MOVING = 0, 1  # bodies
RADIUS = 0.05  # [m] of the bodies, which makes rotations comparable with translations
STEP = 1e-8  # [m], and per radius [rad]: forces curve over 1e-5 m or more, and round at 1e-16
VELOCITY_STEP = 1e-6  # [m/s]: forces are linear in velocities but for the cone and the clamp
# Of the largest entry: (1e-8/1e-5)² of curvature, 1e-16 · 1e-5/1e-8 of rounding, and the kinks of
# third derivatives where a corner of a triangle passes zero deformation.
TOLERANCE = 1e-5
UNITS = np.repeat([RADIUS, 1.0], 3)


def turned(rotation: Floats) -> Floats:
    return Rotation.from_rotvec(rotation).as_matrix()


def pose(rotation: Any, p: Any) -> Floats:
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = turned(rotation), p
    return X


def displaced(X_FB: Floats, xi: Floats) -> Floats:
    X_FB = X_FB.copy()
    X_FB[MOVING, :3, :3] = turned(xi[:3]) @ X_FB[MOVING, :3, :3]
    X_FB[MOVING, :3, 3] += xi[3:]
    return X_FB


X_MG = pose([1.0, 0.2, 0.3], [0.03, -0.02, 0.04])  # of the geometries in their bodies
X_FG = pose([0.2, 0.1, 0.3], [0.01, 0.02, 0.03])


@dataclass
class Meeting:
    """A model of two bodies in contact, where they are, and what was accepted before."""

    model: ContactModel
    X_FB: Floats
    V_FB: Floats
    state: ContactState | None = None

    def after_steps(self, count: int, drift: Floats) -> "Meeting":
        """The same after accepted steps that leave anchors behind."""
        state, X_FB = self.model.initial_state(), self.X_FB
        for step in range(count):
            forces = self.model.evaluate(X_FB, self.V_FB, state)
            state = self.model.advance(state, 1e-3 * step, forces)
            X_FB = displaced(X_FB, drift)
        return Meeting(self.model, X_FB, self.V_FB, state)

    def linearize(self, **options: Any) -> Linearization:
        return self.model.linearize(self.X_FB, self.V_FB, self.state, **options)

    def wrench(self, xi: Floats | None = None, dV: Floats | None = None) -> Floats:
        X_FB = self.X_FB if xi is None else displaced(self.X_FB, xi)
        V_FB = self.V_FB.copy()
        if dV is not None:
            V_FB[MOVING] += dV
        if xi is not None:  # the velocity relative to the turning body b is held
            V_FB[MOVING, 3:] += np.cross(self.V_FB[FIXED, :3], xi[3:])
        return self.model.evaluate(X_FB, V_FB, self.state).body_wrenches[MOVING]

    def differences(self) -> tuple[Floats, Floats]:
        stiffness, damping = np.empty((6, 6)), np.empty((6, 6))
        for k, axis in enumerate(np.eye(6)):
            xi, dV = STEP / UNITS * axis, VELOCITY_STEP / UNITS * axis
            ahead, behind = self.wrench(xi), self.wrench(-xi)
            stiffness[:, k] = (behind - ahead) / (2 * xi[k])
            ahead, behind = self.wrench(dV=dV), self.wrench(dV=-dV)
            damping[:, k] = (behind - ahead) / (2 * dV[k])
        return stiffness, damping


def require_derivative(meeting: Meeting) -> None:
    found = meeting.linearize()
    assert_array_equal(found.pair, [0])
    assert_array_equal(found.bodies, [[MOVING, FIXED]])
    assert_allclose(found.wrench[0], meeting.wrench(), rtol=1e-12)
    units = 1 / np.outer(UNITS, UNITS)
    for name, differences in zip(("stiffness", "damping"), meeting.differences(), strict=True):
        scale = np.abs(differences * units).max()
        values = getattr(found, name)[0]
        assert_allclose(
            values * units, differences * units, rtol=0, atol=TOLERANCE * scale, err_msg=name
        )


@dataclass(frozen=True)
class Case:
    """What bears load, by what law."""

    web: AreaWeb | FacetWeb
    damper: dict[str, Any] = field(default_factory=dict)
    friction: Friction | None = None
    steps: int = 0

    def meeting(self, seed: int) -> Meeting:
        """A ball just within the face of a block, all generic."""
        rng = np.random.default_rng(seed)
        facet = isinstance(self.web, FacetWeb)
        depth = -0.003 if facet else 0.0015
        X_GH = pose(rng.normal(size=3), [0.02, 0.01, 0.1 + RADIUS - depth])
        meshes = CollisionMesh(*mesh_shapes.ball(3, radius=RADIUS)), block(0.2)
        damper = NonlinearDamper(**{"k": 1e4 if facet else 1e7} | self.damper)
        return meet(meshes, X_GH, rng, damper, self.web, self.friction).after_steps(
            self.steps, np.array([1e-3, 2e-3, -1e-3, 2e-5, -1e-5, 1e-5])
        )


def block(size: float) -> CollisionMesh:
    return CollisionMesh(*mesh_shapes.cube(size))


def meet(
    meshes: tuple[CollisionMesh, CollisionMesh],
    X_GH: Floats,
    rng: np.random.Generator,
    damper: NonlinearDamper,
    *law: Any,  # web and friction
) -> Meeting:
    """A, fixed to the moving body, at X_GH from B, fixed to the other."""
    geometries = [
        ContactGeometry("b", FIXED, meshes[1], X_FG),
        ContactGeometry("a", MOVING, meshes[0], X_MG),
    ]
    pair = ContactPair(1, 0, damper, *law)
    X_F = pose(rng.normal(size=3), 0.1 * rng.normal(size=3))
    X_FB = np.stack([X_F, X_F @ X_FG @ X_GH @ np.linalg.inv(X_MG)])
    model = ContactModel(["fixed", "moving"], geometries, [pair])
    return Meeting(model, X_FB, 0.2 * rng.normal(size=(2, 6)))


WEBS = {
    "smooth-a": AreaWeb(sampled="a", resolution=0.1),
    "smooth-b": AreaWeb(sampled="b", resolution=0.1),
    "exact-a": AreaWeb(field="exact", sampled="a", resolution=0.1),
    "exact-b": AreaWeb(field="exact", sampled="b", resolution=0.1),
    "standoff": AreaWeb(0.002, resolution=0.1),
    "default": AreaWeb(),
    "facet": FacetWeb(0.01),
}
DAMPERS = {
    "elastic": {},
    "hertz": {"n": 1.5},
    "damped": {"alpha": 0.5},
    "hertz-damped": {"n": 1.5, "alpha": 0.5},
    "adhesive": {"alpha": 4.9, "adhesion": True},
    "clamped": {"alpha": 4.9},
    "settling": {"alpha": 0.5, "settling": 0.2, "smallest": 0.05},
}
FRICTIONS = {
    "stick": Friction(50.0),
    "slip": Friction(0.3, 0.2),
    "damped": Friction(0.3, damping=1e-4),
    "viscous": Friction(50.0, stiffness_ratio=0, damping=1e-3),
    "viscous-slip": Friction(0.3, stiffness_ratio=0, damping=1e-3),
}


@pytest.mark.parametrize("damper", DAMPERS)
@pytest.mark.parametrize("web", WEBS)
def test_normal_forces(web, damper):
    """A term of the elastic force, of its damping or of the turning normals left out."""
    for seed in range(4):
        require_derivative(Case(WEBS[web], DAMPERS[damper]).meeting(seed))


@pytest.mark.parametrize("steps", [0, 1, 2, 4])
@pytest.mark.parametrize("friction", FRICTIONS)
@pytest.mark.parametrize("web", WEBS)
def test_friction(web, friction, steps):
    """Stretch that does not follow the pose, anchors' levers, a cone that does not follow the load.

    Without a step contacts are new and unstretched, after one they are stretched since it, in part
    as deep as they have come, after more they hang on anchors that have slipped.
    """
    for seed, damper in enumerate(({}, {"alpha": 0.5}, {"alpha": 0.5, "n": 1.5})):
        case = Case(WEBS[web], damper, FRICTIONS[friction], steps)
        require_derivative(case.meeting(seed))


def test_cases_stick_and_slip_and_are_clamped():
    """Cases that do not load the terms they are for."""
    anchored = {}
    for name in ("stick", "slip"):
        meeting = Case(WEBS["smooth-a"], {}, FRICTIONS[name], 2).meeting(0)
        contacts = meeting.model.evaluate(meeting.X_FB, meeting.V_FB, meeting.state).contacts
        cone = FRICTIONS[name].dynamic_coefficient * contacts.normal_force
        slips = np.linalg.norm(contacts.friction_force_F, axis=1) > 0.99 * cone
        anchored[name] = 1 - slips.mean()
    assert anchored["stick"] > 0.5 > anchored["slip"]
    clamped = {}
    for name in ("clamped", "adhesive"):
        meeting = Case(WEBS["smooth-a"], DAMPERS[name]).meeting(3)
        contacts = meeting.model.evaluate(meeting.X_FB, meeting.V_FB).contacts
        clamped[name] = (contacts.normal_force == 0).mean()
        pulls = (contacts.normal_force < 0).any()
    assert 0.1 < clamped["clamped"] < 0.9
    assert pulls


@pytest.mark.parametrize("web", ["smooth", "exact", "exact-b", "facet"])
def test_curved_on_curved(web):
    """Directions that turn as contact moves over vertices, edges and facets of both bodies."""
    mesh = CollisionMesh(*mesh_shapes.ball(2, radius=RADIUS))
    options = {
        "smooth": AreaWeb(resolution=0.05),
        "exact": AreaWeb(resolution=0.05, field="exact"),
        "exact-b": AreaWeb(resolution=0.05, field="exact", sampled="b"),
        "facet": FacetWeb(0.006),
    }[web]
    frictions = [None, Friction(0.3), Friction(50.0)]
    for seed in range(6):
        rng = np.random.default_rng(seed)
        along = rng.normal(size=3)
        apart = (0.1 if web == "facet" else 0.0955) * along / np.linalg.norm(along)
        damper = NonlinearDamper(1e7, alpha=0.5, n=[1.0, 1.5][seed % 2])
        X_GH = pose(rng.normal(size=3), apart)
        meeting = meet((mesh, mesh), X_GH, rng, damper, options, frictions[seed % 3])
        require_derivative(meeting.after_steps(2, 1e-5 * np.array([9, -8, 7, 2, 1, -1])))


@pytest.mark.parametrize("n", [1.0, 1.5])
@pytest.mark.parametrize("along", [0.01, 0.0485])
def test_crossing_edges(along, n):
    """Fillets, and the couple near an edge's end where its window fades (within 4 mm here)."""
    for seed, friction in enumerate([None, Friction(0.3), Friction(50.0)]):
        rng = np.random.default_rng(seed)
        # An edge of a block on an edge of another, turned about where they cross.
        lean, tilt = turned([0, -np.pi / 4, 0]), turned(0.1 * rng.normal(size=3))
        edge = 0.05 * np.sqrt(2) - 3.5e-4  # from a block's centre
        X_GH = np.eye(4)
        X_GH[:3, :3] = lean @ tilt @ turned([np.pi / 4, 0, 0])
        X_GH[:3, 3] = lean @ ([0, -0.02, edge] + tilt @ [along, 0, edge])
        damper = NonlinearDamper(1e7, alpha=0.5, n=n)
        web = AreaWeb(fillet=1e-3, resolution=0.2)
        meeting = meet((block(0.1), block(0.1)), X_GH, rng, damper, web, friction)
        meeting = meeting.after_steps(2, 1e-5 * np.array([9, 9, 9, 1, 1, -1]))
        forces = meeting.model.evaluate(meeting.X_FB, meeting.V_FB, meeting.state)
        fillets = (forces.contacts.key >> np.uint64(63)).sum()
        assert fillets == (1 if along < 0.04 else 3)
        require_derivative(meeting)


def test_frictionless_springs_without_damping_have_a_symmetric_stiffness():
    """Springs that are not the gradient of an energy.

    The stiffness is then the second derivative of the stored energy, but for the moment τ of the
    load: two rotations one after the other differ by their order, so S − Sᵀ = [τ×]ᵀ.
    """
    for web in ("smooth-a", "smooth-b", "exact-a", "facet"):
        meeting = Case(WEBS[web]).meeting(1)
        found = meeting.linearize()
        S, (torque, force) = found.stiffness[0], np.split(found.wrench[0], 2)
        units = 1 / np.outer(UNITS, UNITS)
        skew = np.cross(np.eye(3), torque)  # its rows are e_k × τ
        assert np.abs(S).max() > 0
        scale = np.abs(S * units).max()
        asymmetry = S - S.T
        expected = np.zeros((6, 6))
        expected[:3, :3] = skew
        assert_allclose(asymmetry * units, expected * units, rtol=0, atol=1e-9 * scale)
        assert np.linalg.norm(force) > 0.1


def test_damping_is_positive_and_symmetric_where_nothing_slips():
    """Damping that gives energy."""
    for web in WEBS.values():
        case = Case(web, {"alpha": 0.5}, Friction(1e9), 2)
        damping = case.meeting(2).linearize().damping
        scaled = damping[0] / np.outer(UNITS, UNITS)
        assert_allclose(scaled, scaled.T, atol=1e-12 * np.abs(scaled).max())
        assert np.linalg.eigvalsh(scaled).min() > -1e-12 * np.abs(scaled).max()


def test_symmetric_variant_leaves_out_what_cannot_be_symmetric():
    """A solver for symmetric matrices given what is not, or given something else."""
    case = Case(WEBS["smooth-b"], {"alpha": 0.5}, Friction(0.3), 2)
    meeting = case.meeting(1)
    damping = meeting.linearize(symmetric=True).damping[0]
    assert_allclose(damping, damping.T, atol=1e-12 * np.abs(damping).max())
    sticking = Case(WEBS["smooth-b"], {"alpha": 0.5}, Friction(1e9), 2).meeting(1)
    for found in (sticking.linearize(symmetric=True), sticking.linearize()):
        assert_allclose(found.damping[0], sticking.linearize().damping[0], atol=1e-9)


def test_pairs_are_linearized_alike_whatever_the_threads():
    """Sums that depend on who computes them; pairs that are not those in contact."""
    rng = np.random.default_rng(3)
    mesh = CollisionMesh(*mesh_shapes.ball(2, radius=RADIUS))
    geometries = [ContactGeometry(f"g{i}", i, mesh) for i in range(6)]
    pairs = [
        ContactPair(a, b, NonlinearDamper(1e7, alpha=0.3), AreaWeb(resolution=0.05), Friction(0.4))
        for a in range(6)
        for b in range(a)
    ]
    X_FB = np.stack([pose(rng.normal(size=3), 0.05 * rng.normal(size=3)) for _ in range(6)])
    V_FB = rng.normal(size=(6, 6))
    names = [f"b{i}" for i in range(6)]
    one, four = (ContactModel(names, geometries, pairs, threads=t) for t in (1, 4))
    found, again = one.linearize(X_FB, V_FB), four.linearize(X_FB, V_FB)
    assert_array_equal(found.pair, one.evaluate(X_FB, V_FB).loaded.pairs)
    assert len(found) > 5
    for name in ("pair", "bodies", "wrench", "stiffness", "damping"):
        assert_array_equal(getattr(found, name), getattr(again, name), err_msg=name)
    total = np.zeros((6, 3))
    for (a, b), wrench in zip(found.bodies, found.wrench, strict=True):
        total[a] += wrench[3:]
        total[b] -= wrench[3:]
    assert_allclose(total, one.evaluate(X_FB, V_FB).body_wrenches[:, 3:], atol=1e-9)


def test_bodies_apart_have_no_stiffness():
    """Rows for pairs that do not touch."""
    model = scenes.model(block(0.1), block(0.1), NonlinearDamper(1e7), web=AreaWeb())
    found = model.linearize(scenes.poses((0, 0, 0.3)), scenes.velocities())
    assert len(found) == 0
    assert found.stiffness.shape == (0, 6, 6)


@pytest.mark.parametrize("web", [AreaWeb(0.002), FacetWeb(0.004)], ids=["area", "facets"])
def test_wrenches_on_all_bodies_change_as_they_move(web):
    # A body that carries others along, or a moment about an origin that moves, is left out.
    meshes = [CollisionMesh(*mesh_shapes.ball(2, radius=RADIUS)) for _ in range(3)]
    geometries = [
        ContactGeometry(f"g{i}", i, mesh, pose(0.3 * i * np.ones(3), [0.01 * i, -0.02, 0.01]))
        for i, mesh in enumerate(meshes)
    ]
    damper = NonlinearDamper(k=1e3 if isinstance(web, FacetWeb) else 1e9, alpha=0.4)
    pairs = [ContactPair(b, a, damper, web, Friction(0.5)) for a, b in ((0, 1), (1, 2), (0, 2))]
    model = ContactModel(["a", "b", "c"], geometries, pairs)
    # Their centres are the corners of a triangle.
    apart = 2 * RADIUS + (1e-3 if isinstance(web, FacetWeb) else -1e-3)
    corners = apart * np.array([[0, 0, 0], [1, 0, 0], [0.5, 0.866, 0.01]])
    turns = [[0.1, 0.2, 0.3], [0.2, -0.5, 0.3], [1.2, 0.5, -0.3]]
    X_FB = np.stack([pose(turn, corner) for turn, corner in zip(turns, corners, strict=True)])
    for X_FBi, geometry in zip(X_FB, geometries, strict=True):
        X_FBi[:3, 3] -= X_FBi[:3, :3] @ geometry.X_BG[:3, 3]
    V_FB = np.random.default_rng(4).normal(size=(3, 6)) * np.repeat([1.0, 0.05], 3)

    def moved(motion: Floats) -> Floats:
        X = X_FB.copy()
        for body, xi in enumerate(motion):
            X[body, :3, :3] = turned(xi[:3]) @ X[body, :3, :3]
            X[body, :3, 3] += xi[3:]
        return X

    before = model.evaluate(moved(-1e-4 * V_FB), V_FB)
    state = model.advance(model.initial_state(), 0.0, before)
    assert len(np.unique(state.forces.contacts.pair)) == 3

    def wrenches(motion: Floats, velocity: Floats) -> Floats:
        return model.evaluate(moved(motion), V_FB + velocity, state).body_wrenches

    count = 18
    dX, dV = (np.zeros((3, 6, 2 * count)) for _ in range(2))
    dX.reshape(count, -1)[:, :count] = np.eye(count)
    dV.reshape(count, -1)[:, count:] = np.eye(count)
    slopes = model.differentiate(X_FB, V_FB, dX, dV, state)
    for k in range(2 * count):
        step = STEP if k < count else VELOCITY_STEP
        ahead = wrenches(step * dX[..., k], step * dV[..., k])
        behind = wrenches(-step * dX[..., k], -step * dV[..., k])
        differences = (ahead - behind) / (2 * step)
        scale = np.abs(differences / np.repeat([RADIUS, 1.0], 3)).max()
        off = np.abs((slopes[..., k] - differences) / np.repeat([RADIUS, 1.0], 3))
        assert off.max() < TOLERANCE * scale, k
    with pytest.raises(ValueError, match=r"dV_FB must be \(nb, 6, n\), here \(3, 6, 36\)"):
        model.differentiate(X_FB, V_FB, dX, dV[..., 0], state)
