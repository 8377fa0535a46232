"""Simulations that were saved go on, in another process, as if nothing had happened."""

import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from pydrake.geometry import Box, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import PrismaticJoint, SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from systems import AddNonlinearDamperContact, ContactConfig, SavedContext

KINDS = ["implicit", "explicit", "continuous"]
HALFWAY, END = 0.04, 0.06  # [s] the ball hits, the box slides, the slider pushes it


def make_simulator(kind: str, bodies: int = 2) -> Simulator:
    builder = DiagramBuilder()
    step = {"implicit": 2e-3, "explicit": 5e-5, "continuous": 0.0}[kind]
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, step)
    rough = CoulombFriction(0.5, 0.5)
    world = plant.world_body()
    plant.RegisterCollisionGeometry(
        world, RigidTransform([0, 0, -0.05]), Box(2, 2, 0.1), "table", rough
    )
    for i in range(bodies):
        box = plant.AddRigidBody(f"box{i}", SpatialInertia.SolidBoxWithMass(1, 0.1, 0.1, 0.1))
        plant.RegisterCollisionGeometry(box, RigidTransform(), Box(0.1, 0.1, 0.1), "box", rough)
        plant.SetDefaultFloatingBaseBodyPose(box, RigidTransform([0.4 * i, 0, 0.05 + 0.003 * i]))
    push = plant.AddRigidBody("push", SpatialInertia.SolidSphereWithMass(0.5, 0.03))
    at = RigidTransform([0, 0, 0.05])
    plant.RegisterCollisionGeometry(push, at, Sphere(0.03), "push", rough)
    slider = plant.AddJoint(
        PrismaticJoint("slider", plant.world_frame(), push.body_frame(), [1, 0, 0])
    )
    slider.set_default_translation(-0.09)
    plant.AddJointActuator("motor", slider)
    plant.Finalize()
    AddNonlinearDamperContact(
        builder,
        plant,
        scene_graph,
        config=ContactConfig(k=1e7, discrete="explicit" if kind == "explicit" else "implicit"),
    )
    port, system = plant.get_actuation_input_port(), plant
    if kind == "continuous":  # fixed from outside
        builder.ExportInput(port, "force")
    simulator = Simulator(builder.Build())
    if kind == "continuous":
        system = simulator.get_system()
        port = system.get_input_port()
    port.FixValue(system.GetMyContextFromRoot(simulator.get_mutable_context()), [8.0])
    if kind == "continuous":
        integrator = simulator.get_mutable_integrator()
        integrator.set_maximum_step_size(2e-4)
        integrator.set_fixed_step_mode(True)
    return simulator


def state_of(simulator: Simulator) -> bytes:
    context, plant = simulator.get_context(), simulator.get_system().GetSubsystemByName("plant")
    contact = simulator.get_system().GetSubsystemByName("contact")
    own = contact.GetMyContextFromRoot(context)
    energies = contact.get_energies_output_port().Eval(own)
    x = plant.GetPositionsAndVelocities(plant.GetMyContextFromRoot(context))
    return np.concatenate([[context.get_time()], x, energies]).tobytes()


def resume(kind: str, saved: str, resumed: str) -> None:
    simulator = make_simulator(kind)
    pickle.loads(Path(saved).read_bytes()).restore(
        simulator.get_system(), simulator.get_mutable_context()
    )
    simulator.AdvanceTo(END)
    Path(resumed).write_bytes(state_of(simulator))


@pytest.mark.parametrize("kind", KINDS)
def test_another_process_goes_on_with_the_same_bits(kind, tmp_path):
    # What is not saved, be it a digit or what a step has reported, shows within 0.02 s.
    simulator = make_simulator(kind)
    simulator.AdvanceTo(HALFWAY)
    saved = SavedContext.of(simulator.get_system(), simulator.get_context())
    (tmp_path / "saved").write_bytes(pickle.dumps(saved))
    simulator.AdvanceTo(END)
    program = f"import test_saved_context as t; t.resume({kind!r}, 'saved', 'resumed')"
    done = subprocess.run(
        [
            sys.executable,
            "-c",
            f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r})\n{program}",
        ],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "resumed").read_bytes() == state_of(simulator)


def test_a_context_of_another_diagram_is_refused():
    two, three = make_simulator("implicit"), make_simulator("implicit", bodies=3)
    saved = SavedContext.of(two.get_system(), two.get_context())
    with pytest.raises(ValueError, match="saved of another system: its discrete values"):
        saved.restore(three.get_system(), three.get_mutable_context())
