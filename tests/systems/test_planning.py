"""What planners, loggers and stations see of a plant whose contact was taken over."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pydrake.geometry import Box, Mesh, Meshcat, MeshcatParams
from pydrake.math import RigidTransform
from pydrake.multibody.inverse_kinematics import InverseKinematics
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import PrismaticJoint, RevoluteJoint, SpatialInertia
from pydrake.solvers import Solve
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput

from systems import (
    AddNonlinearDamperContact,
    ContactForceVisualizer,
    OpenForcePorts,
    PairWrenches,
)

SIDE, MASS, GRAVITY = 0.1, 0.5, 9.81


def add_box_and_table(plant: MultibodyPlant) -> None:
    friction = CoulombFriction(0.5, 0.5)
    inertia = SpatialInertia.SolidBoxWithMass(MASS, SIDE, SIDE, SIDE)
    box = plant.AddRigidBody("box", inertia)
    cube = Box(SIDE, SIDE, SIDE)
    plant.RegisterCollisionGeometry(box, RigidTransform(), cube, "box", friction)
    plant.RegisterCollisionGeometry(
        plant.world_body(), RigidTransform([0, 0, -0.5]), Box(2, 2, 1), "table", friction
    )
    plant.SetDefaultFloatingBaseBodyPose(box, RigidTransform([0, 0, SIDE / 2]))


def height_by_inverse_kinematics(plant: MultibodyPlant, context: Context) -> float:
    """Nearest height of the box to 2 cm inside the table, at which it keeps 1 cm of distance."""
    own = plant.GetMyMutableContextFromRoot(context)
    box = plant.GetBodyByName("box")
    plant.SetFreeBodyPose(own, box, RigidTransform([0, 0, -0.02]))
    problem = InverseKinematics(plant, own)
    problem.AddMinimumDistanceLowerBoundConstraint(0.01, 0.02)
    start = plant.GetPositions(own)
    problem.prog().AddQuadraticErrorCost(np.eye(7), start, problem.q())
    result = Solve(problem.prog(), start)
    assert result.is_success()
    return float(result.GetSolution(problem.q())[6])


def test_inverse_kinematics_keeps_its_distance_in_a_context_with_restored_filters():
    """A planner would put an arm into the table and call it a success."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=2e-3)
    add_box_and_table(plant)
    plant.Finalize()
    contact = AddNonlinearDamperContact(builder, plant, scene_graph)
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    contact.RestoreFilters(context)
    assert height_by_inverse_kinematics(plant, context) == pytest.approx(SIDE / 2 + 0.01, abs=1e-3)
    # Contexts to simulate are left alone: Drake's contact would push there too.
    assert height_by_inverse_kinematics(plant, diagram.CreateDefaultContext()) < 0


def test_force_between_two_bodies_is_the_weight_and_can_be_logged():
    """A user could not tell which body holds which, but for summing springs by hand."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=2e-3)
    add_box_and_table(plant)
    plant.Finalize()
    contact = AddNonlinearDamperContact(builder, plant, scene_graph)
    wrenches = PairWrenches.AddToBuilder(builder, contact, [("box", "world"), ("world", "box")])
    log = LogVectorOutput(wrenches.get_output_port(), builder)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(0.5)
    context = simulator.get_context()
    push = contact.force_between(context, "box", "world")
    np.testing.assert_allclose(push, [0, 0, 0, 0, 0, MASS * GRAVITY], atol=1e-3 * MASS * GRAVITY)
    logged = log.FindLog(context).data()[:, -1]
    np.testing.assert_allclose(logged[:6], push, atol=0.02 * MASS * GRAVITY)
    np.testing.assert_allclose(logged[9:], -logged[3:6])
    with pytest.raises(ValueError, match="no body 'bocks' in this contact; there are"):
        contact.force_between(context, "bocks", "world")


def test_station_that_exports_its_force_ports_gets_contact_and_keeps_its_ports():
    """`MakeHardwareStation` exports both ports before it calls back: contact was refused."""

    def make_station() -> Diagram:
        builder = DiagramBuilder()
        plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=2e-3)
        add_box_and_table(plant)
        plant.Finalize()
        for name in ("applied_generalized_force", "applied_spatial_force"):
            builder.ExportInput(plant.GetInputPort(name), name)
        AddNonlinearDamperContact(builder, plant, scene_graph)  # as its callback would
        return builder.Build()

    with pytest.raises(ValueError, match=r"build the diagram within systems.OpenForcePorts"):
        make_station()
    with OpenForcePorts():
        station = make_station()
    simulator = Simulator(station)
    plant = station.GetSubsystemByName("plant")
    own = plant.GetMyContextFromRoot(simulator.get_context())
    simulator.AdvanceTo(0.2)
    assert plant.GetPositions(own)[6] == pytest.approx(SIDE / 2, abs=1e-5)
    lift = np.array([0, 0, 0, 0, 0, 2 * MASS * GRAVITY])
    station.GetInputPort("applied_generalized_force").FixValue(
        simulator.get_mutable_context(), lift
    )
    simulator.AdvanceTo(0.3)
    assert plant.GetPositions(own)[6] == pytest.approx(SIDE / 2 + GRAVITY * 0.1**2 / 2, rel=0.03)


def test_continuous_plant_says_which_limits_it_ignores():
    """An arm would swing through its stops, with no word from Drake."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    add_box_and_table(plant)
    inertia = SpatialInertia.SolidBoxWithMass(MASS, SIDE, SIDE, SIDE)
    arm = plant.AddRigidBody("arm", inertia)
    free = plant.AddRigidBody("free", inertia)
    world = plant.world_frame()
    plant.AddJoint(PrismaticJoint("slide", world, arm.body_frame(), [1.0, 0, 0], -0.1, 0.1))
    plant.AddJoint(RevoluteJoint("swing", arm.body_frame(), free.body_frame(), [1.0, 0, 0]))
    plant.Finalize()
    with pytest.warns(UserWarning, match=r"Drake leaves out the limits of slide: bodies will move"):
        AddNonlinearDamperContact(builder, plant, scene_graph)


def test_forces_are_drawn_where_drake_draws_its_own():
    """Drake's contact results are empty: Meshcat would show bodies that float."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=2e-3)
    add_box_and_table(plant)
    plant.Finalize()
    contact = AddNonlinearDamperContact(builder, plant, scene_graph)
    meshcat = Meshcat(MeshcatParams(host="localhost"))
    ContactForceVisualizer.AddToBuilder(builder, contact, meshcat)
    Simulator(builder.Build()).AdvanceTo(0.5)
    path = "contact_forces/hydroelastic/world+box"
    assert meshcat.HasPath(f"{path}/head/cone")
    assert meshcat.HasPath(f"{path}/shaft/unit")


def test_a_file_in_millimetres_is_hinted_at(tmp_path: Path):
    """A ball of 30 m would fall for seconds, and the user look for the error elsewhere."""
    path = tmp_path / "part.obj"
    path.write_text("v 0 0 0\nv 30 0 0\nv 0 30 0\nv 0 0 30\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=2e-3)
    add_box_and_table(plant)
    part = plant.AddRigidBody("part", SpatialInertia.SolidSphereWithMass(1.0, 0.01))
    friction = CoulombFriction(0.5, 0.5)
    plant.RegisterCollisionGeometry(part, RigidTransform(), Mesh(path), "shell", friction)
    plant.Finalize()
    with pytest.warns(UserWarning, match=r"shell of part is .* m across; if its file is in milli"):
        AddNonlinearDamperContact(builder, plant, scene_graph)
