"""A plug pressed into a bore that is too small for it: row 18 of the README's closed forms.

The foundation stiffness is that of the thick ring around a solid shaft (Lamé), so that the pressure
of an interference is that of a real press fit.
"""

import math

import pytest
from pydrake.geometry import Mesh
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import PrismaticJoint, SpatialInertia
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import Context, DiagramBuilder, EventStatus
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial
from validation_scenes import ON_BOTH_PLANTS_BUT_SLOW, check, on

from scenarios import parts
from scenarios.parts.surface import revolve
from systems import AddNonlinearDamperContact, ContactConfig, FrictionConfig

BORE, OUTER, DEPTH = 0.01, 0.02, 0.02  # [m] radii and length of the sleeve
INTERFERENCE = 4e-5  # [m] of the radius
MODULUS = 3e9  # [Pa], a hard plastic
MU = 0.2
MASS = 0.1  # [kg]
SECTIONS = 48
GONE = 3e-5  # [m]: a little farther than the springs of friction give

# Pressure of a radial interference d: p = E d / (2 R) (1 − R²/Ro²), shaft and ring of one material.
FOUNDATION = MODULUS / (2 * BORE) * (1 - (BORE / OUTER) ** 2)  # [Pa/m]
PRESSURE = FOUNDATION * INTERFERENCE  # [Pa]

# What is pressed in, and how much of its length is in the bore [m].
FITS = {
    "shaft through a ring": (
        lambda: parts.rod(0.03, BORE + INTERFERENCE, SECTIONS, rings=8),
        DEPTH,
    ),
    "bush within a ring": (lambda: ring(0.007, BORE + INTERFERENCE, 0.016), 0.016),
}


def ring(inner: float, outer: float, length: float) -> parts.Surface:
    half = length / 2
    outline = [(outer, -half), (outer, half), (inner, half), (inner, -half)]
    return revolve(outline, SECTIONS, closed=True)


def push_out_force(folder, pressed: parts.Surface, largest: float, time_step: float) -> float:
    """Force [N] at which the plug leaves its place, under one that grows up to `largest`."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step)
    plug = plant.AddRigidBody(
        "plug", SpatialInertia.SolidCylinderWithMass(MASS, BORE, DEPTH, [0, 0, 1])
    )
    surfaces = (pressed, ring(BORE, OUTER, DEPTH))
    for body, surface in zip((plug, plant.world_body()), surfaces, strict=True):
        path = parts.write_obj(folder / f"{body.name()}.obj", surface)
        plant.RegisterCollisionGeometry(
            body, RigidTransform(), Mesh(path), "mesh", CoulombFriction(MU, MU)
        )
    joint = plant.AddJoint(
        PrismaticJoint("axis", plant.world_frame(), plug.body_frame(), [0, 0, 1])
    )
    plant.AddJointActuator("drive", joint)
    plant.mutable_gravity_field().set_gravity_vector([0, 0, 0])
    plant.Finalize()
    ramp = PiecewisePolynomial.FirstOrderHold([0, 0.2], [[0, largest]])
    drive = builder.AddSystem(TrajectorySource(ramp))
    builder.Connect(drive.get_output_port(), plant.get_actuation_input_port())
    config = ContactConfig(
        k=FOUNDATION, alpha=1.0, resolution=0.1, field="exact", friction=FrictionConfig(static=MU)
    )
    AddNonlinearDamperContact(builder, plant, scene_graph, config=config)
    simulator = Simulator(builder.Build())
    if not time_step:
        ResetIntegratorFromFlags(simulator, "radau3", 1e-3)
        simulator.get_mutable_integrator().set_target_accuracy(1e-4)
    context = plant.GetMyContextFromRoot(simulator.get_mutable_context())

    def stop_when_gone(_root: Context) -> EventStatus:
        if joint.get_translation(context) > GONE:
            return EventStatus.ReachedTermination(plant, "gone")
        return EventStatus.DidNothing()

    simulator.set_monitor(stop_when_gone)
    simulator.AdvanceTo(0.2)
    return float(ramp.value(simulator.get_context().get_time())[0, 0])


@ON_BOTH_PLANTS_BUT_SLOW
@pytest.mark.parametrize("name", FITS)
def test_a_press_fit_lets_go_where_coulomb_says(name, tmp_path, record_property, time_step):
    """Row 18: an interference that presses too much or too little, or friction that gives early."""
    pressed, length = FITS[name]
    expected = MU * PRESSURE * 2 * math.pi * BORE * length
    got = push_out_force(tmp_path, pressed(), 1.5 * expected, time_step)
    row = (18, f"{name}: push-out force [N]" + on(time_step))
    check(record_property, row, expected, got, 0.05)
