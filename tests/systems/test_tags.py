"""Contact of geometry tagged in the ways that models in the wild are: rigid, pointwise, not at all.

Forces are those of the contact system on a pose set by hand, against closed forms.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    Box,
    ProximityProperties,
    SceneGraphConfig,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.framework import DiagramBuilder

from contact_toolkit.contact.materials import STIFFEST_MODULUS
from systems import AddNonlinearDamperContact, ContactConfig, NonlinearDamperContact

MASS, GRAVITY = 2.0, 9.81
SIDE = 0.2


def rigid() -> ProximityProperties:
    properties = ProximityProperties()
    AddContactMaterial(friction=CoulombFriction(0.5, 0.5), properties=properties)
    AddRigidHydroelasticProperties(0.1, properties)
    return properties


def compliant(modulus: float) -> ProximityProperties:
    properties = ProximityProperties()
    AddContactMaterial(friction=CoulombFriction(0.5, 0.5), properties=properties)
    AddCompliantHydroelasticProperties(0.1, modulus, properties)
    return properties


def pointwise(stiffness: float) -> ProximityProperties:
    properties = ProximityProperties()
    AddContactMaterial(
        point_stiffness=stiffness, friction=CoulombFriction(0.5, 0.5), properties=properties
    )
    return properties


def untagged() -> ProximityProperties:
    return ProximityProperties()


class OnTable:
    """Shapes on a body over a table whose top is z = 0."""

    def __init__(
        self,
        shapes: list[tuple[Shape, RigidTransform]],
        tags: ProximityProperties,
        table_tags: ProximityProperties,
        *,
        bodies: int = 1,
        graph: SceneGraphConfig | None = None,
        settings: ContactConfig | None = None,
    ) -> None:
        builder = DiagramBuilder()
        self.plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
        if graph is not None:
            scene_graph.set_config(graph)
        inertia = SpatialInertia.SolidBoxWithMass(MASS / bodies, SIDE, SIDE, SIDE)
        parts = [self.plant.AddRigidBody(f"part{i}", inertia) for i in range(bodies)]
        for part in parts[1:]:
            self.plant.WeldFrames(parts[0].body_frame(), part.body_frame())
        for i, (shape, X_BG) in enumerate(shapes):
            self.plant.RegisterCollisionGeometry(parts[i % bodies], X_BG, shape, f"shape{i}", tags)
        table = RigidTransform([0.0, 0.0, -0.5])
        self.plant.RegisterCollisionGeometry(
            self.plant.world_body(), table, Box(2, 2, 1), "table", table_tags
        )
        self.plant.Finalize()
        self.contact: NonlinearDamperContact = AddNonlinearDamperContact(
            builder, self.plant, scene_graph, config=settings
        )
        self.diagram = builder.Build()
        self.part = parts[0]

    def force_at(self, height: float) -> float:
        """Upward force on the body [N] with its origin at a height [m], at rest."""
        context = self.diagram.CreateDefaultContext()
        self.plant.SetFreeBodyPose(
            self.plant.GetMyMutableContextFromRoot(context),
            self.part,
            RigidTransform([0.0, 0.0, height]),
        )
        wrenches = self.contact.get_body_wrenches_output_port().Eval(
            self.contact.GetMyContextFromRoot(context)
        )
        moving = [index != self.plant.world_body().index() for index in self.contact.bodies]
        return float(wrenches.reshape(-1, 6)[moving, 5].sum())


def cube() -> list[tuple[Shape, RigidTransform]]:
    return [(Box(SIDE, SIDE, SIDE), RigidTransform())]


def cube_of_eight() -> list[tuple[Shape, RigidTransform]]:
    offsets = itertools.product((-SIDE / 4, SIDE / 4), repeat=3)
    return [(Box(SIDE / 2, SIDE / 2, SIDE / 2), RigidTransform(list(p))) for p in offsets]


def test_two_rigid_bodies_touch_by_stiff_skins():
    """The pair that Drake gives to point contact would be refused, or of a wrong stiffness."""
    scene = OnTable(cube(), rigid(), rigid())
    skin = 0.01 * math.sqrt(3) * SIDE
    depth = 1e-5
    expected = STIFFEST_MODULUS / (2 * skin) * SIDE**2 * depth
    assert scene.force_at(SIDE / 2 - depth) == pytest.approx(expected, rel=1e-3)


def test_a_rigid_body_does_not_soften_the_contact_of_a_compliant_one():
    """A rigid table would add a skin of its own to the modulus that the user tagged."""
    (pair,) = OnTable(cube(), compliant(2e6), rigid()).contact.model.pairs
    assert pair.damper.k == pytest.approx(2e6 / (0.01 * math.sqrt(3) * SIDE))


@pytest.mark.parametrize("stiffness", [1e3, 1e5])
def test_point_stiffness_is_the_force_per_depth_of_a_box_on_its_face(stiffness: float):
    """The one tag that the model has would be ignored: 1e3 N/m and unset gave the same force."""
    load = MASS * GRAVITY
    depth = load / stiffness
    scene = OnTable(cube(), pointwise(stiffness), rigid())
    assert scene.force_at(SIDE / 2 - depth) == pytest.approx(load, rel=5e-3, abs=0)


def test_two_point_stiffnesses_are_in_series():
    """Each side would yield as if it were alone, twice as stiff as Drake's."""
    load = MASS * GRAVITY
    scene = OnTable(cube(), pointwise(2e4), pointwise(2e4))
    assert scene.force_at(SIDE / 2 - load / 1e4) == pytest.approx(load, rel=5e-3)


def test_point_stiffness_holds_for_a_round_body_at_its_own_weight():
    """A sphere's patch grows with its depth: the force per depth is right at one load, its own."""
    load = MASS * GRAVITY
    stiffness, radius = 4e3, SIDE / 2
    scene = OnTable([(Sphere(radius), RigidTransform())], pointwise(stiffness), rigid())
    assert scene.force_at(radius - load / stiffness) == pytest.approx(load, rel=0.01)


@pytest.mark.parametrize("tags", [rigid, untagged, lambda: pointwise(1e4)])
def test_untagged_table_touches_whatever_lies_on_it(tags):
    """A model without a single tag of ours or Drake's would be refused."""
    assert OnTable(cube(), tags(), untagged()).force_at(SIDE / 2 - 1e-4) > 0


@pytest.mark.parametrize("bodies", [1, 2, 8])
def test_stiffness_does_not_depend_on_how_an_object_was_cut(bodies: int):
    """A mug of eight convex pieces would be twice as stiff as the same mug in one."""
    (whole,) = OnTable(cube(), untagged(), untagged()).contact.model.pairs
    pieces = OnTable(cube_of_eight(), untagged(), untagged(), bodies=bodies).contact.model.pairs
    assert len(pieces) == bodies  # those of one body are one solid
    np.testing.assert_allclose([pair.damper.k for pair in pieces], whole.damper.k, rtol=1e-9)


def test_a_dissipation_that_nobody_chose_bounces_like_the_parts_of_a_robot():
    """Drake's 50 s/m would stop every untagged model dead as if its author had asked for it."""
    (pair,) = OnTable(cube(), untagged(), untagged()).contact.model.pairs
    assert pair.damper.restitution(1.0) == pytest.approx(0.3)
    graph = SceneGraphConfig()
    graph.default_proximity_properties.hunt_crossley_dissipation = 6.0
    (pair,) = OnTable(cube(), untagged(), untagged(), graph=graph).contact.model.pairs
    assert pair.damper.alpha == pytest.approx(4.0)
