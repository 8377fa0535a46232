"""What a scene is, and a run of it under one of the contacts."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import DefaultProximityProperties, GeometryId
from pydrake.math import RigidTransform
from pydrake.multibody.plant import ContactResults, MultibodyPlant
from pydrake.multibody.tree import RigidBody
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from benchmarks.discrete_steps import make_plant, no_inputs
from systems import AddNonlinearDamperContact

TIME_STEP = 2e-3  # [s]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Truth:
    """What a figure is by statics or a closed form, and by how much it may differ."""

    value: float
    within: float

    def __str__(self) -> str:
        return f"{self.value:g} ± {self.within:g}"

    def met_by(self, figure: float) -> bool:
        """Whether a figure is as it should be; NaN is not."""
        return abs(figure - self.value) <= self.within


@dataclass(frozen=True)
class Scene:
    """A scene.

    Attributes
    ----------
    name
        For tables and tests.
    made_of
        Which files of which packages, and what they lack.
    packages
        Those it needs, as pip calls them.
    build
        Adds the bodies to a plant; mesh files may be written into the folder.
    connect
        Adds what drives it.
    measure
        Moves a run on and returns its figures, by the names of `truths`.
    truths
        Figure, with its unit → what it should be.
    """

    name: str
    made_of: str
    packages: tuple[str, ...]
    build: Callable[[MultibodyPlant, Path], None]
    measure: Callable[[Run], dict[str, float]]
    truths: Mapping[str, Truth]
    connect: Callable[[DiagramBuilder, MultibodyPlant], None] = no_inputs


class Run:
    """A scene under one of `benchmarks.discrete_steps.ENGINES`, at its beginning.

    Attributes
    ----------
    plant, context
        The plant, and its context.
    spent
        Time of a core that stepping took [s].
    """

    def __init__(self, scene: Scene, engine: str, folder: Path) -> None:
        self._scene, self._folder = scene, folder
        builder = DiagramBuilder()
        self.plant, scene_graph = make_plant(builder, engine, TIME_STEP)
        scene.build(self.plant, folder)
        self.plant.Finalize()
        scene.connect(builder, self.plant)
        self._contact = None
        if engine == "ours":
            self._contact = AddNonlinearDamperContact(builder, self.plant, scene_graph)
        self._simulator = Simulator(builder.Build())
        root = self._simulator.get_mutable_context()
        self.context = self.plant.GetMyMutableContextFromRoot(root)
        self._inspector = scene_graph.model_inspector()
        self._simulator.Initialize()
        self.spent = 0.0

    @property
    def time(self) -> float:
        """Of the simulation [s]."""
        return float(self.context.get_time())

    def advance(self, duration: float) -> None:
        """Step on by a duration [s]."""
        start = time.thread_time()
        self._simulator.AdvanceTo(self.time + duration)
        self.spent += time.thread_time() - start

    def pose(self, body: str) -> RigidTransform:
        """Return a body's pose in W."""
        return self.plant.EvalBodyPoseInWorld(self.context, self.plant.GetBodyByName(body))

    def speed(self, bodies: Iterable[RigidBody]) -> float:
        """Return how fast the fastest of these bodies' origins moves [m/s]."""
        velocities = self.plant.get_body_spatial_velocities_output_port().Eval(self.context)
        return max(
            float(np.linalg.norm(velocities[int(body.index())].translational())) for body in bodies
        )

    def weight(self, bodies: Iterable[RigidBody]) -> float:
        """Return what bodies weigh together [N]."""
        gravity = float(np.linalg.norm(self.plant.gravity_field().gravity_vector()))
        return gravity * sum(body.get_mass(self.context) for body in bodies)

    def force_on(self, bodies: Iterable[RigidBody], duration: float = 0.0) -> Floats:
        """Return the contact force on bodies together (3,) in W [N].

        At present, or the mean while a duration passes.
        """
        rows = {int(body.index()) for body in bodies}
        steps = round(duration / TIME_STEP)
        if steps == 0:
            return self._force_on(rows)
        total = np.zeros(3)
        for _ in range(steps):
            self.advance(TIME_STEP)
            total += self._force_on(rows)
        return total / steps

    def overlap(self, softest: float = 0.0) -> float:
        """Return how deep the deepest overlap of two bodies is by Drake's reckoning [m].

        Of those with a hydroelastic modulus of at least `softest` [Pa]; untagged ones have Drake's
        default. Asked of a plant of its own, which filters nothing; Drake takes convex hulls.
        """
        builder = DiagramBuilder()
        plant, _ = make_plant(builder, "Drake point", TIME_STEP)
        self._scene.build(plant, self._folder)
        plant.Finalize()
        diagram = builder.Build()
        context = plant.GetMyMutableContextFromRoot(diagram.CreateDefaultContext())
        plant.SetPositions(context, self.plant.GetPositions(self.context))
        query = plant.get_geometry_query_input_port().Eval(context)

        default = DefaultProximityProperties().hydroelastic_modulus

        def is_hard(geometry: GeometryId) -> bool:
            properties = query.inspector().GetProximityProperties(geometry)
            modulus = properties.GetPropertyOrDefault(
                "hydroelastic", "hydroelastic_modulus", default
            )
            return modulus >= softest

        return max(
            (
                pair.depth
                for pair in query.ComputePointPairPenetration()
                if is_hard(pair.id_A) and is_hard(pair.id_B)
            ),
            default=0.0,
        )

    def _force_on(self, rows: set[int]) -> Floats:
        if self._contact is None:
            return self._force_of_drake(rows)
        contact_context = self._contact.GetMyContextFromRoot(self._simulator.get_context())
        wrenches = self._contact.get_body_wrenches_output_port().Eval(contact_context)
        at = [i for i, body in enumerate(self._contact.bodies) if int(body) in rows]
        return np.asarray(wrenches).reshape(-1, 6)[at, 3:].sum(axis=0)

    def _force_of_drake(self, rows: set[int]) -> Floats:
        results: ContactResults = self.plant.get_contact_results_output_port().Eval(self.context)
        total = np.zeros(3)
        for i in range(results.num_point_pair_contacts()):
            point = results.point_pair_contact_info(i)
            share = (int(point.bodyB_index()) in rows) - (int(point.bodyA_index()) in rows)
            total += share * point.contact_force()
        for i in range(results.num_hydroelastic_contacts()):
            patch = results.hydroelastic_contact_info(i)
            surface = patch.contact_surface()
            a, b = (self._body_of(each) for each in (surface.id_M(), surface.id_N()))
            total += ((a in rows) - (b in rows)) * patch.F_Ac_W().translational()
        return total

    def _body_of(self, geometry: object) -> int:
        body = self.plant.GetBodyFromFrameId(self._inspector.GetFrameId(geometry))
        return int(body.index())
