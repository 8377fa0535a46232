"""The meetings of `test_contact_robustness` through a whole Drake diagram, on both webs.

Either a run stays finite and makes no energy from nothing, or it ends in an error that names the
bodies and says what is wrong: past half a thickness, or where the surfaces of a facet web cross,
forces have no side. A body wholly within another meets none of its facets: the facet web is silent.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from pydrake.geometry import Mesh
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import CalcSpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder, EventStatus
from scipy.spatial.transform import Rotation
from test_contact_robustness import LOOSE, MEETINGS, PARTS, SIDE, Meeting

from scenarios.parts import write_obj
from systems import AddNonlinearDamperContact, ContactConfig, FrictionConfig

ALPHAS = (0.0, 0.5)  # [s/m]; friction the same
OVERLAPPED = ("overlapped", "overlapped at a corner", "coincident", "nearly coincident")
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


def meeting_on(web: str, name: str) -> Meeting:
    """The meeting; on the facet web a box that comes is a ball: face on face has many answers."""
    meeting = MEETINGS[name]
    if web == "area" or meeting.part == "ball" or name in OVERLAPPED:
        return meeting
    x, y, z = meeting.p
    return replace(meeting, part="ball", p=(x, y, z - SIDE / 2 + 0.02))


def meet(folder: Path, name: str, web: str, alpha: float, *, when_deep: str = "raise") -> Outcome:
    """Run a meeting; contact with damping also rubs."""
    meeting, mu = meeting_on(web, name), alpha
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
        **(facet if web == "facet" else {"k": meeting.k, "resolution": 0.1}),
    )
    contact = AddNonlinearDamperContact(builder, plant, scene_graph, config=config)
    simulator = Simulator(builder.Build())
    context = simulator.get_mutable_context()
    # The error control must see what the deformation is: it is at most about v √(m/k) in a bounce.
    lightest = min(body.default_mass() for body in bodies)
    deformation = np.linalg.norm(meeting.v) * np.sqrt(lightest / (meeting.k * AREA))
    simulator.get_mutable_integrator().set_target_accuracy(min(1e-7, 1e-2 * (deformation or 1)))
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


TOO_DEEP = "deeper than half the other's thickness|surfaces cross"
# Where the answer is an error: (name, web, α).
REFUSED = {
    *(
        (name, "area", alpha)
        for name in ("stiffness 1", "one inside the other")
        for alpha in ALPHAS
    ),
    *((name, "facet", alpha) for name in ("stiffness 1", *OVERLAPPED) for alpha in ALPHAS),
    ("1 km/s", "facet", 0.0),
}


@pytest.mark.parametrize("alpha", ALPHAS)
@pytest.mark.parametrize("web", ["area", "facet"])
@pytest.mark.parametrize("name", MEETINGS)
def test_nothing_from_nothing(name, web, alpha, tmp_path):
    """Numbers that are not finite, energy or momentum from nothing, an error without a name."""
    if (name, web, alpha) in REFUSED:
        with pytest.raises(RuntimeError, match=f"block.* and comer.*({TOO_DEEP})"):
            meet(tmp_path, name, web, alpha)
        return
    met = meet(tmp_path, name, web, alpha)
    touching = not (web == "facet" and name in WITHIN)
    assert (met.loaded > 0) == touching
    assert np.isfinite(met.states).all()
    assert met.energy.max() <= met.energy[0] * (1 + LOOSE)
    pushed = np.linalg.norm(met.momentum, axis=1).max() + np.sqrt(met.energy[0])
    assert np.abs(met.momentum - met.momentum[0]).max() <= 1e-8 * pushed


@pytest.mark.parametrize("name", ["overlapped", "coincident", "1 km/s"])
def test_crossed_facets_stay_finite_where_they_are_only_warned_of(name, tmp_path):
    """A force that is not finite where facets cross."""
    with pytest.warns(RuntimeWarning, match="surfaces cross"):
        met = meet(tmp_path, name, "facet", 0.0, when_deep="warn")
    assert np.isfinite(met.states).all()
