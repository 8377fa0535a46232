"""Every division and root in the force path at the numbers that make it 0/0.

Exact zeros, equal points, motion exactly along a surface or square to it, edges exactly parallel,
denormals: such poses are what models start from, and one 0/0 ends a simulation.
"""

import itertools

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from mesh_shapes import cube
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
    NonlinearDamper,
)

pytestmark = pytest.mark.engine

CUBE_VERTICES, CUBE_FACES = cube()
SIDE = 0.125  # sums and products of powers of two are exact
BLOCK = CollisionMesh(SIDE * CUBE_VERTICES, CUBE_FACES)
WALL = CollisionMesh(CUBE_VERTICES * [SIDE, 0.5, 0.5], CUBE_FACES)
DEPTH = 2.0**-17
TINY = [0.0, -0.0, 5e-324, -1e-310, 1e-162, 1e-17, -1e-9]


def shifted(x=0.0, y=0.0, z=0.0) -> np.ndarray:
    X = np.eye(4)
    X[:3, 3] = x, y, z
    return X


def turned(quarters_x: int, quarters_z: float) -> np.ndarray:
    """Return a rotation: exact quarter turns about x, after others about z."""
    c, s = [(1, 0), (0, 1), (-1, 0), (0, -1)][quarters_x]
    about_x = np.array([[1, 0, 0], [0, c, -s], [0, s, c]], dtype=float)
    angle = quarters_z * np.pi / 2
    about_z = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    return about_x @ about_z


def scene(k=1e7, n=1.0, web=AreaWeb, **settings) -> ContactModel:
    pair = ContactPair(
        0, 1, NonlinearDamper(k, 1.0, n), friction=Friction(0.5), web=web(**settings)
    )
    return ContactModel(
        ["block", "wall"],
        [ContactGeometry("block", "block", BLOCK), ContactGeometry("wall", "wall", WALL)],
        [pair],
    )


@pytest.mark.parametrize("sampled", ["a", "b"])
@pytest.mark.parametrize("field", ["smooth", "exact"])
def test_motion_exactly_along_a_wall(sampled, field):
    """0/0 in the stretch of a spring whose node is out of contact while its facets are in."""
    model, state = scene(sampled=sampled, field=field), ContactState()
    for step in range(32):
        X = np.stack([shifted(SIDE - DEPTH, 0.0, step / 128), np.eye(4)])
        V = np.array([[0, 0, 0, 0, 0, 1.0], np.zeros(6)])
        forces = model.evaluate(X, V, state)
        contacts = forces.contacts
        assert contacts.normal_force.sum() > 0
        rub = np.linalg.norm(contacts.friction_force_F, axis=1)
        assert (rub <= 0.5 * contacts.normal_force * (1 + 1e-12)).all()
        assert (contacts.friction_force_F[:, 2] <= 0).all()
        state = model.advance(state, step / 128, forces)


def test_a_couple_of_crossing_edges_has_no_friction_of_its_own():
    """0/0 in the stretch of the fillets' couple, two forces without stiffness."""
    model, state = scene(fillet=0.005), ContactState()
    couples = 0
    for step in range(6):
        # The block's edge along z lies across the wall's upper edge, near its own end,
        # a little turned, deeper by the step.
        out, along = np.array([1, 0, 1]) / np.sqrt(2), np.array([1, 0, -1]) / np.sqrt(2)
        upright = np.stack([out, np.cross(along, out), along], axis=1) @ turned(0, -0.5)
        X = np.eye(4)
        X[:3, :3] = Rotation.from_rotvec([0.1, 0.15, 0.05]).as_matrix() @ upright
        edge = X[:3, :3] @ [-SIDE / 2, -SIDE / 2, SIDE / 2 - 0.01]
        X[:3, 3] = np.array([SIDE / 2, 0, 0.25]) - edge - (1e-3 + 1e-4 * step) * out
        forces = model.evaluate(np.stack([X, np.eye(4)]), np.ones((2, 6)) * [[1], [0]], state)
        assert np.isfinite(forces.body_wrenches).all()
        couple = forces.contacts.stiffness == 0
        couples += couple.sum()
        assert not forces.contacts.friction_force_F[couple].any()
        state = model.advance(state, 1e-3 * step, forces)
    assert couples > 0


webs = st.sampled_from(
    [
        {"field": "smooth"},
        {"field": "exact", "sampled": "b"},
        {"field": "exact"},
        {"field": "smooth", "fillet": 0.004},
        {"field": "exact", "n": 1.5, "standoff": 1e-4},
        {"web": FacetWeb, "standoff": 1e-3, "k": 1e4},
        {"web": FacetWeb, "standoff": 1e-3, "k": 1e4, "n": 1.5, "weighting": "unit"},
    ]
)
numbers = st.sampled_from([*TINY, 1e-5, -(2.0**-7), 1.0])
offsets = st.sampled_from([SIDE, SIDE - DEPTH, SIDE - 1e-5, np.nextafter(SIDE, 0), 0.1, 0.0])


@settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    options=webs,
    start=st.tuples(offsets, st.sampled_from([*TINY, 0.25, 0.1]), st.sampled_from([*TINY, 0.25])),
    turn=st.tuples(st.integers(0, 3), st.sampled_from([0, 0.5, 1, 1.5])),
    motion=st.tuples(st.tuples(*[numbers] * 3), st.tuples(*[numbers] * 6)),
    duration=st.sampled_from([0.0, 5e-324, 1e-310, 1e-3]),
)
@example(
    options={"field": "exact", "sampled": "b"},
    start=(SIDE - DEPTH, 0.0, 0.0),
    turn=(0, 0),
    motion=((0.0, 0.0, 2.0**-7), (0.0,) * 6),
    duration=1e-3,
)
@example(
    options={"field": "exact"},
    start=(0.0, 0.0, 0.0),
    turn=(0, 0),
    motion=((0.0,) * 3, (0.0,) * 6),
    duration=0.0,
)
def test_nothing_but_finite_numbers(options, start, turn, motion, duration):
    """A division or root met at zero, at equal points or at denormals."""
    model, state = scene(**options), ContactState()
    way, twist = motion
    velocity = np.stack([np.array(twist), np.zeros(6)])
    for step in range(4):
        X = np.eye(4)
        X[:3, :3] = turned(*turn)
        X[:3, 3] = np.array(start) + step * np.array(way)
        forces = model.evaluate(np.stack([X, np.eye(4)]), velocity, state)
        assert np.isfinite(forces.body_wrenches).all()
        assert np.isfinite(forces.energies).all()
        assert np.isfinite(forces.powers).all()
        state = model.advance(state, step * duration, forces)
        assert np.isfinite(state.losses).all()
        coasted = model.coast(state, duration)
        assert coasted is not None
        assert np.isfinite(coasted.body_wrenches).all()


@pytest.mark.parametrize("spins", list(itertools.product([0.0, 1e160], repeat=2)))
def test_a_force_that_is_no_number_names_the_pair(spins):
    """A NaN or infinity handed on: Drake ends in an error that names nobody."""
    model = scene()
    X = np.stack([shifted(SIDE - DEPTH), np.eye(4)])
    V = np.array([[0, spins[0], 0, -1.7e308, spins[1], 0], np.zeros(6)])
    with pytest.raises(RuntimeError, match=r"pair 0 \('block', 'wall'\).*not finite"):
        model.evaluate(X, V)


def test_a_step_that_ends_at_no_time():
    """Losses that are NaN from then on."""
    model = scene()
    forces = model.evaluate(np.stack([shifted(0.2), np.eye(4)]), np.zeros((2, 6)))
    with pytest.raises(ValueError, match="time must be finite"):
        model.advance(ContactState(), float("nan"), forces)
    with pytest.raises(ValueError, match="duration must be finite"):
        model.coast(ContactState(), float("inf"))
