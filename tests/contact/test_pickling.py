"""What the contact model hands out survives pickling with its bits, in this process and another."""

import copy
import pickle
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import contact_scenes as scenes
import mesh_shapes
import numpy as np
import pytest
from numpy.testing import assert_array_equal

from contact_toolkit import (
    AreaWeb,
    CollisionMesh,
    ContactArrays,
    ContactGeometry,
    ContactModel,
    ContactPair,
    ContactState,
    FacetWeb,
    Friction,
    NonlinearDamper,
    StepSolver,
)

pytestmark = pytest.mark.engine

WEBS = [
    pytest.param(AreaWeb(0.002), id="area"),
    pytest.param(AreaWeb(field="exact"), id="exact"),
    pytest.param(FacetWeb(0.004), id="facets"),
]


def make_model(web: AreaWeb | FacetWeb, friction: float = 0.4) -> ContactModel:
    shapes = mesh_shapes.cube(0.1), mesh_shapes.doughnut()
    geometries = [
        ContactGeometry(name, name, CollisionMesh(*shape))
        for name, shape in zip(("table", "ring"), shapes, strict=True)
    ]
    k = 1e3 if isinstance(web, FacetWeb) else 1e8
    damper = NonlinearDamper(k, alpha=0.3)
    return ContactModel(
        ["table", "ring"], geometries, [ContactPair(1, 0, damper, web, Friction(friction))]
    )


def poses_at(step: int) -> np.ndarray:
    """The ring slides over the table and sinks into it, so that anchors hold, drag and appear."""
    return scenes.poses((1e-5 * step, 2e-6 * step, 0.0695 - 2e-6 * step))


def velocities() -> np.ndarray:
    V_FB = np.zeros((2, 6))
    V_FB[1] = 0.1, -0.2, 0.3, 0.01, 0.002, -0.002
    return V_FB


def run(model: ContactModel, state: ContactState, steps: range) -> ContactState:
    for step in steps:
        forces = model.evaluate(poses_at(step), velocities(), state)
        state = model.advance(state, 1e-3 * step, forces)
    return state


COLUMNS = [name for name in dir(ContactArrays) if not name.startswith("_")]


def bits(state: ContactState) -> list[bytes]:
    """All that a state answers; how much was looked at to find it out is no answer."""
    forces, contacts = state.forces, state.forces.contacts
    rows = [getattr(contacts, name) for name in COLUMNS]
    sums = forces.body_wrenches, forces.energies, forces.powers, state.losses
    return [np.asarray(each).tobytes() for each in (*rows, *sums, state.time)]


@pytest.mark.parametrize("web", WEBS)
def test_a_state_goes_on_where_it_was_saved_with_an_equal_model(web):
    # An anchor, a loss or a spring that is lost on the way: forces would leap after a restart.
    model = make_model(web)
    halfway = run(model, model.initial_state(), range(20))
    assert halfway.forces.contacts.anchored.any()
    through = run(model, halfway, range(20, 40))
    assert through.losses.all()
    saved = pickle.dumps(halfway)
    del model, halfway
    again = make_model(web)
    resumed = run(again, pickle.loads(saved), range(20, 40))
    assert bits(resumed) == bits(through)


@pytest.mark.parametrize("web", WEBS)
def test_a_state_may_outlive_its_model(web):
    # What a state remembers refers to the meshes of its model.
    model = make_model(web)
    state = run(model, model.initial_state(), range(20))
    expected = run(model, state, range(20, 40))
    del model
    assert bits(run(make_model(web), state, range(20, 40))) == bits(expected)


def test_a_model_pickles_with_its_settings():
    model = make_model(AreaWeb(0.001, resolution=0.05))
    copied = pickle.loads(pickle.dumps(model))
    assert (copied.bodies, copied.pairs) == (model.bodies, model.pairs)
    state = run(model, model.initial_state(), range(10))
    assert bits(run(copied, state, range(10, 20))) == bits(run(model, state, range(10, 20)))


def test_a_model_of_other_parameters_refuses_the_state():
    # A number left out of what names a model: its state would be taken for another's.
    model = make_model(AreaWeb(0.002))
    state = run(model, model.initial_state(), range(3))
    geometries, (pair,) = model.geometries, model.pairs
    moved = np.eye(4)
    moved[0, 3] = 1e-9
    finer = CollisionMesh(*mesh_shapes.cube(0.1 + 1e-9))
    changed = [
        (geometries, replace(pair, damper=replace(pair.damper, settling=1e-9))),
        (geometries, replace(pair, web=AreaWeb(0.002, sampled="b"))),
        (geometries, replace(pair, web=FacetWeb(0.002))),
        (geometries, replace(pair, friction=Friction(0.4, damping=0.0))),
        (geometries, replace(pair, a=0, b=1)),
        ((replace(geometries[0], X_BG=moved), geometries[1]), pair),
        ((replace(geometries[0], mesh=finer), geometries[1]), pair),
    ]
    for parts, touching in changed:
        other = ContactModel(model.bodies, parts, [touching])
        with pytest.raises(ValueError, match="or an equal one"):
            other.find(poses_at(3), state)
    renamed = [replace(each, name=f"the {each.name}") for each in geometries]
    ContactModel(model.bodies, renamed, [pair], threads=2).find(poses_at(3), state)


def test_what_comes_of_a_model_pickles():
    model = make_model(AreaWeb(0.002))
    state = run(model, model.initial_state(), range(5))
    found = model.find(poses_at(5), state)
    forces = model.forces(found, velocities(), state)
    for each in (found, forces, forces.contacts, state, model.initial_state()):
        saved = pickle.dumps(each)
        assert pickle.dumps(pickle.loads(saved)) == saved
        assert copy.copy(each) is copy.deepcopy(each) is each
    loaded = pickle.loads(pickle.dumps(forces))
    assert_array_equal(loaded.contacts.p_FCa, forces.contacts.p_FCa)
    assert_array_equal(
        model.forces(pickle.loads(pickle.dumps(found)), velocities(), state).body_wrenches,
        forces.body_wrenches,
    )
    # Taken over as they are, though it is unknown by now which state they are of.
    after, same = (model.advance(state, 0.005, each) for each in (forces, loaded))
    assert bits(after) == bits(same)


def test_an_eased_state_pickles_before_the_first_step():
    model = make_model(AreaWeb(0.002))
    state = model.eased_state(np.array([1e-4]), 0.0, 0.1)
    loaded = pickle.loads(pickle.dumps(state))
    assert bits(run(model, loaded, range(5))) == bits(run(model, state, range(5)))


def test_a_solved_step_pickles():
    model = make_model(AreaWeb(0.002))
    solver = StepSolver(
        model,
        num_positions=7,
        num_velocities=6,
        v_start=[0],
        nv=[6],
        q_start=[0],
        inertia_R=np.diag([1e-3, 1e-3, 1e-3, 1.0, 1.0, 1.0])[None],
        tree=[-1, 0],
        X_RB=np.tile(np.eye(4), (2, 1, 1)),
    )
    q, v = np.array([1.0, 0, 0, 0, 0, 0, 0.0695]), velocities()[1]
    start, gravity = model.initial_state(), np.array([0, 0, -9.81])
    solved = solver.solve_under_gravity(start, 0.0, 1e-3, q, v, gravity, poses_at(0))
    loaded = pickle.loads(pickle.dumps(solved))
    assert (loaded.status, loaded.iterations) == (solved.status, solved.iterations)
    states = [model.advance_implicitly(start, 1e-3, each.forces) for each in (solved, loaded)]
    assert bits(states[0]) == bits(states[1])


@pytest.mark.parametrize(
    "spoil", [lambda b: b[:-1], lambda b: b + b"\0", lambda b: b.replace(b" 1\n", b" 0\n")]
)
def test_bytes_that_are_not_a_state_are_refused(spoil):
    # Read as they come, they would end the process, or worse, go on with nonsense.
    model = make_model(AreaWeb(0.002))
    saved = run(model, model.initial_state(), range(3)).__getstate__()
    with pytest.raises(ValueError, match="not the bytes of a ContactState"):
        ContactState.__new__(ContactState).__setstate__(spoil(saved))


def test_another_process_goes_on_with_the_same_bits(tmp_path):
    model = make_model(AreaWeb(0.002))
    halfway = run(model, model.initial_state(), range(20))
    (tmp_path / "saved").write_bytes(pickle.dumps((model, halfway)))
    program = (
        "import pickle, pathlib, test_pickling as t\n"
        "model, state = pickle.loads(pathlib.Path('saved').read_bytes())\n"
        "state = t.run(model, state, range(20, 40))\n"
        "pathlib.Path('resumed').write_bytes(pickle.dumps(state))"
    )
    tests = Path(__file__).parents[1]
    path = f"{tests / 'contact'}:{tests / 'support'}"
    done = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path[:0] = {path!r}.split(':')\n{program}"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    resumed = pickle.loads((tmp_path / "resumed").read_bytes())
    assert bits(resumed) == bits(run(model, halfway, range(20, 40)))
