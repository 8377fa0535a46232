"""The meetings of `test_contact_robustness` through a whole Drake diagram, on both webs.

Either a run stays finite and makes no energy from nothing, or it ends in an error that names the
bodies and says what is wrong: past half a thickness, or where the surfaces of a facet web cross,
forces have no side; where flat faces lie on each other, the facet web's torque leaps, and leaves
the error control no step to take. A body wholly within another meets none of its facets: the facet
web is silent. Steps too long for contact make energy, and are warned of.
"""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from meetings import LOOSE, MEETINGS, PARTS, SIDE, Meeting
from pydrake.geometry import Mesh
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import CalcSpatialInertia
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import Context, DiagramBuilder, EventStatus
from scipy.spatial.transform import Rotation

from scenarios.parts import write_obj
from systems import AddNonlinearDamperContact, ContactConfig, FrictionConfig

ALPHAS = (0.0, 0.5)  # [s/m]; friction the same
OVERLAPPED = ("overlapped", "overlapped at a corner", "coincident", "nearly coincident")
STIFF_OR_LIGHT = ("stiffness 1e12", "mass ratio 1e6", "1 km/s")
WITHIN = ("one inside the other", "concentric")
STANDOFF = 5e-4  # [m] of the facet web
AREA = 0.01  # [m²] of the block's side: what a foundation's stiffness becomes a spring's with


@dataclass
class Outcome:
    """What a run came to: states after every step, energy [J], momentum [N s]."""

    states: np.ndarray
    energy: np.ndarray
    momentum: np.ndarray
    loaded: int


def meet(
    folder: Path,
    meeting: Meeting,
    web: str,
    alpha: float,
    *,
    when_deep: str = "raise",
    when_chattering: str = "raise",
    accuracy: float | None = None,
    fixed_step: float = 0.0,
) -> Outcome:
    """Run a meeting; contact with damping also rubs."""
    mu = alpha
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    plant.mutable_gravity_field().set_gravity_vector([0, 0, 0])
    bodies = []
    for called, part, density in (("block", "box", 1e3), ("comer", meeting.part, meeting.density)):
        mesh = Mesh(write_obj(folder / f"{called}.obj", PARTS[part]))
        bodies.append(plant.AddRigidBody(called, CalcSpatialInertia(mesh, density)))
        plant.RegisterCollisionGeometry(
            bodies[-1], RigidTransform(), mesh, called, CoulombFriction(mu, mu)
        )
    plant.Finalize()
    facet = {"web": "facet", "standoff": STANDOFF, "k": meeting.k * AREA}
    config = ContactConfig(
        alpha=alpha,
        friction=FrictionConfig(static=mu),
        max_step=meeting.max_step,
        when_deep=when_deep,
        when_chattering=when_chattering,
        initial_overlap="warn",  # flung apart, as the law has it
        **(facet if web == "facet" else {"k": meeting.k, "resolution": 0.1}),
    )
    contact = AddNonlinearDamperContact(builder, plant, scene_graph, config=config)
    simulator = Simulator(builder.Build())
    warnings.filterwarnings("ignore", "overlap at the start")
    context = simulator.get_mutable_context()
    if accuracy is None:
        # The error control must see the deformation: it is at most about v √(m/k) in a bounce.
        lightest = min(body.default_mass() for body in bodies)
        deformation = np.linalg.norm(meeting.v) * np.sqrt(lightest / (meeting.k * AREA))
        accuracy = min(1e-7, 1e-2 * (deformation or 1))
    if fixed_step:
        ResetIntegratorFromFlags(simulator, "runge_kutta3", fixed_step)
        simulator.get_mutable_integrator().set_fixed_step_mode(True)
    else:
        simulator.get_mutable_integrator().set_target_accuracy(accuracy)
    plant_context = plant.GetMyMutableContextFromRoot(context)
    contact_context = contact.GetMyContextFromRoot(context)
    turn = Rotation.from_rotvec(meeting.turn * np.array([1.0, 0.6, 0.3])).as_matrix()
    for body, R, p, v in (
        (bodies[0], np.eye(3), np.zeros(3), np.zeros(3)),
        (bodies[1], turn, np.array(meeting.p), meeting.v),
    ):
        X_WB = RigidTransform(RotationMatrix(R), p + meeting.origin)
        plant.SetFreeBodyPose(plant_context, body, X_WB)
        plant.SetFreeBodySpatialVelocity(plant_context, body, SpatialVelocity([0, 0, 0], v))
    states, energies, momenta, loaded = [], [], [], 0

    def watch(_: Context) -> EventStatus:
        nonlocal loaded
        stored = contact.get_energies_output_port().Eval(contact_context)[:2].sum()
        energies.append(plant.EvalKineticEnergy(plant_context) + stored)
        states.append(plant.GetPositionsAndVelocities(plant_context))
        momenta.append(
            plant.CalcSpatialMomentumInWorldAboutPoint(plant_context, np.zeros(3)).translational()
        )
        loaded = max(loaded, len(contact.get_contacts_output_port().Eval(contact_context)))
        return EventStatus.DidNothing()

    simulator.set_monitor(watch)
    simulator.AdvanceTo(meeting.duration)
    return Outcome(np.array(states), np.array(energies), np.array(momenta), loaded)


def falling_ball(name: str, *, higher: float = 0.0) -> Meeting:
    """The meeting with a ball, which has one closest point; it falls from a little higher."""
    meeting = MEETINGS[name]
    x, y, z = meeting.p
    return replace(meeting, part="ball", p=(x, y, z - SIDE / 2 + 0.02 + higher))


# On the facet web boxes that fall on boxes chatter; balls, with one closest point, do not.
ON_WEB = {
    "area": MEETINGS,
    "facet": MEETINGS
    | {
        f"{name}, a ball": falling_ball(name)
        for name in ("stiffness 1", *STIFF_OR_LIGHT, "mass ratio 1e-6", "far from the origin")
    },
}
TOO_DEEP = ": .*(deeper than half the other's thickness|surfaces cross)"
CHATTERS = r" chatters: \d+ steps in a row of .* s, .* of the period"
# Where the answer is an error: (name, web, α). With friction every flat impact chatters.
REFUSED = {
    (name, web, alpha): error
    for names, web, alphas, error in [
        (("stiffness 1", "one inside the other"), "area", ALPHAS, TOO_DEEP),
        (("stiffness 1", *OVERLAPPED), "facet", ALPHAS, TOO_DEEP),
        (("stiffness 1, a ball",), "facet", ALPHAS, TOO_DEEP),
        (("1 km/s, a ball",), "facet", ALPHAS[:1], TOO_DEEP),
        (STIFF_OR_LIGHT, "facet", ALPHAS, CHATTERS),
        (("mass ratio 1e-6", "far from the origin"), "facet", ALPHAS[1:], CHATTERS),
    ]
    for name in names
    for alpha in alphas
}


@pytest.mark.parametrize("alpha", ALPHAS)
@pytest.mark.parametrize(("web", "name"), [(web, name) for web in ON_WEB for name in ON_WEB[web]])
def test_nothing_from_nothing(name, web, alpha, tmp_path):
    """Numbers that are not finite, energy or momentum from nothing, an error without a name."""
    meeting = ON_WEB[web][name]
    if error := REFUSED.get((name, web, alpha)):
        with pytest.raises(RuntimeError, match=f"contact of block.* and comer.*{error}"):
            meet(tmp_path, meeting, web, alpha)
        return
    met = meet(tmp_path, meeting, web, alpha)
    # Facets see nothing within; and surfaces that coincide have no depth on each other.
    touching = not (web == "facet" and name in WITHIN) and (web, name) != ("area", "coincident")
    assert (met.loaded > 0) == touching
    assert np.isfinite(met.states).all()
    assert met.energy.max() <= met.energy[0] * (1 + LOOSE)
    pushed = np.linalg.norm(met.momentum, axis=1).max() + np.sqrt(met.energy[0])
    assert np.abs(met.momentum - met.momentum[0]).max() <= 1e-8 * pushed


@pytest.mark.parametrize("name", ["overlapped", "coincident", "1 km/s, a ball"])
def test_crossed_facets_stay_finite_where_they_are_only_warned_of(name, tmp_path):
    """A force that is not finite where facets cross."""
    with pytest.warns(RuntimeWarning, match="surfaces cross"):
        met = meet(tmp_path, ON_WEB["facet"][name], "facet", 0.0, when_deep="warn")
    assert np.isfinite(met.states).all()


def test_chatter_stays_finite_where_it_is_only_warned_of(tmp_path):
    """A warning at every step, or motion that goes astray between leaps of torque."""
    touched = replace(MEETINGS["stiffness 1e12"], duration=5.005e-4)
    with pytest.warns(RuntimeWarning, match="block.* and comer.* chatters") as told:
        met = meet(tmp_path, touched, "facet", 0.5, when_chattering="warn")
    assert len(told) == 1
    assert np.isfinite(met.states).all()
    assert met.energy.max() <= met.energy[0] * (1 + LOOSE)


@pytest.mark.parametrize(
    ("integration", "higher", "found", "least"),
    [
        # A step that begins at touch has no error that the error control would see.
        ({"accuracy": 1e-6}, 0.0, "a step was off by", 0.1),
        ({"accuracy": 1e-5}, 0.0, "a step was off by more than", 1.0),
        ({"fixed_step": 1e-6}, 3e-7, "a step was off by", 0.05),
        ({"fixed_step": 5e-6}, 6.717e-7, "they met and parted within a step", 1.0),
    ],
)
def test_steps_too_long_are_told_with_a_mend_that_helps(
    integration, higher, found, least, tmp_path
):
    """Energy made or lost in steps too long for contact, without a word, or a mend that is none."""
    ball = falling_ball("stiffness 1e12", higher=higher)
    names = "contact of block.* and comer.*: steps of .* too long"
    with pytest.warns(RuntimeWarning, match=f"{names}.*{found}") as told:
        met = meet(tmp_path, ball, "facet", 0.0, **integration)
    assert abs(met.energy[-1] / met.energy[0] - 1) > least
    said = str(told[-1].message)
    finer, shorter = re.search(r"accuracy\((\S+)\) .* max_step to (\S+) s", said).groups()
    for mended in ({"accuracy": float(finer)}, {"fixed_step": float(shorter)}):
        met = meet(tmp_path, ball, "facet", 0.0, **mended)
        assert abs(met.energy[-1] / met.energy[0] - 1) < 0.02
