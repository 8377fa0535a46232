"""Time derivatives of a Drake plant under contact, against its own plus a native evaluation.

Why: an integrator asks the plant, not the contact model. The difference between the two times is
what the ports, the caches and the Python between them cost: the same for no spring and a thousand.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import cycle

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RigidBody, SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder

from benchmarks.contact_forces import SPRINGS, loaded
from benchmarks.harness import Row, Stopwatch
from benchmarks.mesh_pairs import Pose, doughnut_on_cone
from benchmarks.witness_coherent import closed_path
from contact_toolkit import AreaWeb, ContactModel
from systems import NonlinearDamperContact

NAME = "contact in Drake"
_FAR = 10.0  # [m] apart, nothing is found


def measure(watch: Stopwatch, coarser: int = 1) -> Iterator[Row]:
    """Move the doughnut on the fixed cone, and far from it."""
    pair = doughnut_on_cone(coarser)
    springs = SPRINGS // coarser**2
    model, X_AB = loaded(
        *pair.meshes(), pair.poses["tilted"], springs, web=AreaWeb(), friction=None
    )
    path = closed_path(X_AB)
    far = [X_AB.copy() for X_AB in path]
    for X_AB in far:
        X_AB[2, 3] += _FAR
    for case, poses in {"area web, smooth": path, "far apart": far}.items():
        with_contact, without = Falling(poses, model), Falling(poses)
        V_FB, state = np.zeros((2, 6)), model.initial_state()
        X_FBs = [np.stack([np.eye(4), X_AB]) for X_AB in poses]
        state = model.advance(state, 0.0, model.evaluate(X_FBs[0], V_FB, state))
        evaluate = partial(model.evaluate, V_FB=V_FB, state=state)
        both, plant, native = watch.medians(
            with_contact.derivatives,
            without.derivatives,
            partial(next, map(evaluate, cycle(X_FBs))),
        )
        output = len(model.find(X_FBs[0]))
        yield Row(NAME, case, "sum of both", both, plant + native, size=pair.facets, output=output)


class Falling:
    """A free body at poses in turn, about to be integrated; under contact when given a model."""

    def __init__(self, poses: list[Pose], model: ContactModel | None = None) -> None:
        builder = DiagramBuilder()
        plant = builder.AddSystem(MultibodyPlant(time_step=0.0))
        body = plant.AddRigidBody("b", SpatialInertia.SolidSphereWithMass(1.0, 0.1))
        plant.Finalize()
        if model:
            _connect(builder, plant, body, model)
        self._diagram = builder.Build()
        self._context = self._diagram.CreateDefaultContext()
        at = plant.GetMyMutableContextFromRoot(self._context)
        self._states = cycle([_state(plant, body, at, X_WB) for X_WB in poses])
        # At the first pose a step begins: from here on the contact state remembers it.
        plant.SetPositionsAndVelocities(at, next(self._states))
        Simulator(self._diagram, self._context).AdvancePendingEvents()

    def derivatives(self) -> object:
        """Evaluate them at the next pose."""
        self._context.SetContinuousState(next(self._states))
        return self._diagram.EvalTimeDerivatives(self._context)


def _connect(
    builder: DiagramBuilder, plant: MultibodyPlant, body: RigidBody, model: ContactModel
) -> None:
    bodies = [plant.world_body().index(), body.index()]
    contact = builder.AddSystem(NonlinearDamperContact(plant, model, bodies))
    builder.Connect(plant.get_state_output_port(), contact.get_state_input_port())
    builder.Connect(
        contact.get_generalized_forces_output_port(),
        plant.get_applied_generalized_force_input_port(),
    )


def _state(plant: MultibodyPlant, body: RigidBody, context: Context, X_WB: Pose) -> np.ndarray:
    plant.SetFreeBodyPose(context, body, RigidTransform(X_WB))
    return np.array(plant.GetPositionsAndVelocities(context))
