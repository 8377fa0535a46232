"""AddNonlinearDamperContact: who touches, by what law, and what is left to Drake's own contact."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pydrake.common.value import AbstractValue
from pydrake.common.yaml import yaml_load_typed
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    Box,
    CollisionFilterDeclaration,
    GeometrySet,
    ProximityProperties,
    Role,
    RoleAssign,
    SceneGraph,
)
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import (
    AddMultibodyPlantSceneGraph,
    CalcContactFrictionFromSurfaceProperties,
    CoulombFriction,
    ExternallyAppliedSpatialForce,
    MultibodyPlant,
)
from pydrake.multibody.tree import PrismaticJoint, SpatialInertia
from pydrake.systems.framework import Context, Diagram, DiagramBuilder
from pydrake.systems.primitives import ConstantValueSource, ConstantVectorSource

from contact_toolkit import AreaWeb, FacetWeb, Friction, NonlinearDamper, find_material
from systems import (
    AddNonlinearDamperContact,
    ContactConfig,
    FrictionConfig,
    NonlinearDamperContact,
    PairConfig,
)

FACET = {"web": "facet", "standoff": 0.01, "k": 1e4, "alpha": 0.0}


def rubber() -> ProximityProperties:
    properties = ProximityProperties()
    AddContactMaterial(
        dissipation=3.0,
        point_stiffness=2e4,
        friction=CoulombFriction(0.6, 0.4),
        properties=properties,
    )
    AddCompliantHydroelasticProperties(0.1, 2e6, properties)
    return properties


class Boxes:
    """Boxes of 0.2 m called 'a', 'b' and so on, and a floor whose top is z = 0."""

    def __init__(self, names: str = "ab", time_step: float = 0.0) -> None:
        self.builder = DiagramBuilder()
        self.plant, self.scene_graph = AddMultibodyPlantSceneGraph(self.builder, time_step)
        inertia = SpatialInertia.SolidBoxWithMass(1.0, 0.2, 0.2, 0.2)
        bodies = [self.plant.AddRigidBody(name, inertia) for name in names]
        self.shapes = [
            self.plant.RegisterCollisionGeometry(
                body, RigidTransform(), Box(0.2, 0.2, 0.2), "box", rubber()
            )
            for body in bodies
        ]
        self.plant.RegisterCollisionGeometry(
            self.plant.world_body(), RigidTransform([0, 0, -0.1]), Box(4, 4, 0.2), "floor", rubber()
        )
        self.plant.Finalize()

    def add(self, **settings) -> NonlinearDamperContact:
        config = ContactConfig(**FACET | settings)
        return AddNonlinearDamperContact(self.builder, self.plant, self.scene_graph, config=config)

    def context(self, diagram: Diagram, **heights: float) -> Context:
        """Return a context with each box at its height, and a row of boxes 0.5 m apart."""
        context = diagram.CreateDefaultContext()
        plant_context = self.plant.GetMyContextFromRoot(context)
        for i, (name, z) in enumerate(heights.items()):
            body = self.plant.GetBodyByName(name)
            self.plant.SetFreeBodyPose(plant_context, body, RigidTransform([0.5 * i, 0, z]))
        return context


def touching_bodies(contact: NonlinearDamperContact) -> set[frozenset[str]]:
    geometries, bodies = contact.model.geometries, contact.model.bodies
    return {
        frozenset(bodies[geometries[side].body] for side in (pair.a, pair.b))
        for pair in contact.model.pairs
    }


def pairs(*names: str) -> set[frozenset[str]]:
    return {frozenset(name.split("-")) for name in names}


def test_every_unfiltered_pair_touches_by_default():
    assert touching_bodies(Boxes().add()) == pairs("world-a", "world-b", "a-b")


def test_only_declared_pairs_touch():
    contact = Boxes("abc").add(pairs=[["b", "a"], ["world", "c"]])
    assert touching_bodies(contact) == pairs("a-b", "world-c")


def test_pairs_the_user_filtered_stay_filtered():
    boxes = Boxes()
    declaration = CollisionFilterDeclaration().ExcludeWithin(GeometrySet(boxes.shapes))
    boxes.scene_graph.collision_filter_manager().Apply(declaration)
    assert touching_bodies(boxes.add()) == pairs("world-a", "world-b")


def test_bodies_that_pass_through_each_other_by_a_filter_cannot_be_declared():
    boxes = Boxes()
    everything = GeometrySet(boxes.scene_graph.model_inspector().GetAllGeometryIds(Role.kProximity))
    boxes.scene_graph.collision_filter_manager().Apply(
        CollisionFilterDeclaration().ExcludeWithin(everything)
    )
    with pytest.raises(ValueError, match="'a' and 'b' cannot touch"):
        boxes.add(pairs=[["a", "b"]])
    with pytest.raises(ValueError, match="no two collision geometries"):
        boxes.add()


def test_built_in_contact_is_empty_for_replaced_pairs_and_still_there_for_others():
    boxes = Boxes(time_step=1e-4)
    boxes.add(pairs=[["world", "a"]])
    diagram = boxes.builder.Build()
    context = boxes.context(diagram, a=0.099, b=0.099)
    plant_context = boxes.plant.GetMyContextFromRoot(context)
    query = boxes.plant.get_geometry_query_input_port().Eval(plant_context)
    inspector = query.inspector()
    touching = {
        frozenset(
            boxes.plant.GetBodyFromFrameId(inspector.GetFrameId(geometry)).name()
            for geometry in (contact.id_A, contact.id_B)
        )
        for contact in query.ComputePointPairPenetration()
    }
    assert touching == pairs("world-b")


def test_own_contact_pushes_replaced_pairs_only():
    boxes = Boxes()
    contact = boxes.add(pairs=[["world", "a"]])
    diagram = boxes.builder.Build()
    context = boxes.context(diagram, a=0.105, b=0.105)
    plant_context = boxes.plant.GetMyContextFromRoot(context)
    force = boxes.plant.get_applied_generalized_force_input_port().Eval(plant_context)
    a, b = (boxes.plant.GetBodyByName(name).floating_velocities_start_in_v() for name in "ab")
    assert force[a + 5] > 0
    np.testing.assert_array_equal(force[b : b + 6], 0)
    contacts = contact.get_contacts_output_port().Eval(contact.GetMyContextFromRoot(context))
    assert len(contacts) > 0
    assert set(contacts.pair) == {0}


def test_hydroelastic_meshes_are_dropped_only_where_all_pairs_are_replaced():
    """Else each context builds meshes that nobody uses, or Drake's own pairs change."""
    boxes = Boxes("abc")
    boxes.add(pairs=[["a", "world"], ["a", "b"], ["a", "c"]])
    inspector = boxes.scene_graph.model_inspector()
    kept = [inspector.GetProximityProperties(shape) for shape in boxes.shapes]
    assert [bool(each.GetPropertiesInGroup("hydroelastic")) for each in kept] == [False, True, True]
    friction = kept[0].GetProperty("material", "coulomb_friction")
    assert friction.static_friction() == 0.6
    # The change of role must not undo the filters.
    assert inspector.CollisionFiltered(boxes.shapes[0], boxes.shapes[1])
    assert not inspector.CollisionFiltered(boxes.shapes[1], boxes.shapes[2])


def test_law_follows_the_proximity_properties_where_nothing_is_set():
    (pair,) = Boxes("a").add(k=None, alpha=None).model.pairs
    assert pair.damper.k == pytest.approx(1e4)  # two of 2e4 N/m in series
    assert pair.damper.alpha == pytest.approx(2.0)  # 2/3 of the Hunt-Crossley dissipation
    assert pair.damper.n == 1.0
    assert not pair.damper.adhesion


def test_area_web_is_the_default_and_takes_moduli_over_skins_in_series():
    boxes = Boxes("a")
    contact = AddNonlinearDamperContact(boxes.builder, boxes.plant, boxes.scene_graph)
    (pair,) = contact.model.pairs
    skin = 0.01 * math.sqrt(3) * 0.2  # of the smaller body, the box
    assert pair.web == AreaWeb(nominal_force=9.81)
    assert pair.damper.k == pytest.approx(1e6 / skin)  # two of 2e6 Pa in series
    settings = {"skin": 1e-3, "field": "exact", "resolution": 0.1, "fillet": 2e-3}
    (pair,) = Boxes("a").add(web="area", standoff=None, k=None, **settings).model.pairs
    assert pair.damper.k == pytest.approx(1e9)
    assert pair.web == AreaWeb(field="exact", resolution=0.1, fillet=2e-3, nominal_force=9.81)


def test_friction_is_combined_as_drake_does_unless_set():
    boxes = Boxes("a")
    rougher = CoulombFriction(0.9, 0.8)
    properties = ProximityProperties()
    AddContactMaterial(friction=rougher, properties=properties)
    boxes.scene_graph.AssignRole(
        boxes.plant.get_source_id(), boxes.shapes[0], properties, RoleAssign.kReplace
    )
    (pair,) = boxes.add().model.pairs
    combined = CalcContactFrictionFromSurfaceProperties(CoulombFriction(0.6, 0.4), rougher)
    assert pair.friction.static == pytest.approx(combined.static_friction())
    assert pair.friction.dynamic == pytest.approx(combined.dynamic_friction())
    settings = FrictionConfig(static=0.3, stiffness_ratio=1.0)
    (pair,) = Boxes("a").add(friction=settings).model.pairs
    assert pair.friction == Friction(0.3, None, stiffness_ratio=1.0)


def test_override_of_one_friction_setting_keeps_the_others():
    contact = Boxes("a").add(
        friction=FrictionConfig(static=0.3, stiffness_ratio=1.0),
        overrides=[PairConfig(bodies=["a", "world"], friction=FrictionConfig(static=0.5))],
    )
    (pair,) = contact.model.pairs
    assert pair.friction == Friction(0.5, None, stiffness_ratio=1.0)


def test_law_follows_the_settings_where_there_are_any():
    settings = {"k": 3.0, "alpha": 0.5, "n": 1.5, "adhesion": True, "weighting": "unit"}
    (pair,) = Boxes("a").add(standoff=0.002, **settings).model.pairs
    assert pair.damper == NonlinearDamper(k=3.0, alpha=0.5, n=1.5, adhesion=True)
    assert pair.web == FacetWeb(0.002, "unit")


def test_override_changes_its_own_pair_only_and_the_later_one_wins():
    contact = Boxes().add(
        overrides=[
            PairConfig(bodies=["b", "a"], k=5.0, n=1.2),
            PairConfig(bodies=["a", "b"], k=6.0),
        ]
    )
    geometries, bodies = contact.model.geometries, contact.model.bodies
    laws = {
        frozenset(bodies[geometries[side].body] for side in (pair.a, pair.b)): pair.damper
        for pair in contact.model.pairs
    }
    assert laws.pop(frozenset("ab")) == NonlinearDamper(k=6.0, n=1.2)
    assert set(laws.values()) == {NonlinearDamper(k=1e4)}


def test_settings_load_from_yaml():
    config = yaml_load_typed(
        schema=ContactConfig,
        data="""
        web: facet
        standoff: 0.0015
        k: 25
        pairs: [[world, a]]
        overrides:
        - bodies: [world, a]
          alpha: 3.5
        threads: 2
        """,
    )
    boxes = Boxes("a")
    contact = AddNonlinearDamperContact(
        boxes.builder, boxes.plant, boxes.scene_graph, config=config
    )
    (pair,) = contact.model.pairs
    assert pair.damper == NonlinearDamper(k=25.0, alpha=3.5)
    assert pair.web.standoff == 0.0015


def test_materials_of_the_library_take_the_place_of_proximity_properties():
    config = yaml_load_typed(
        schema=ContactConfig, data="materials: {a: steel, b: rubber, world: mud}"
    )
    boxes = Boxes()
    contact = AddNonlinearDamperContact(
        boxes.builder, boxes.plant, boxes.scene_graph, config=config
    )
    geometries, bodies = contact.model.geometries, contact.model.bodies
    laws = {
        frozenset(bodies[geometries[side].body] for side in (pair.a, pair.b)): pair
        for pair in contact.model.pairs
    }
    steel, rubber, mud = (find_material(name) for name in ("steel", "rubber", "mud"))
    skin = 0.01 * math.sqrt(3) * 0.2
    hard = laws[frozenset("ab")]
    assert hard.damper.k == pytest.approx(1 / (skin / steel.modulus + skin / rubber.modulus))
    assert min(steel.alpha, rubber.alpha) < hard.damper.alpha < max(steel.alpha, rubber.alpha)
    assert hard.friction.static == pytest.approx(2 * 0.74 * 1.0 / 1.74)
    assert not hard.damper.adhesion
    soft = laws[frozenset(("a", "world"))]
    assert soft.damper.k == pytest.approx(1 / (skin / steel.modulus + mud.skin / mud.modulus))
    assert soft.damper.adhesion
    assert (soft.friction.stiffness_ratio, soft.friction.damping) == (0.0, mud.damping)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"materials": {"a": "butter"}}, "materials: a: no material 'butter'; there are steel"),
        ({"materials": {"x": "steel"}}, "materials: the plant has no body 'x'"),
        ({"pairs": [["a", "bb"]]}, r"pairs\[0\]: the plant has no body 'bb'; did you mean b"),
        ({"pairs": [["a", "b"], ["a", "a"]]}, r"pairs\[1\]: 'a' cannot touch itself"),
        ({"pairs": [["a"]]}, r"pairs\[0\]: give two body names, not 1"),
        (
            {"overrides": [PairConfig(bodies=["a", "x"])]},
            r"overrides\[0\]: .* no body 'x'",
        ),
        ({"overrides": [PairConfig()]}, r"overrides\[0\]: give two body names, not 0"),
        (
            {"pairs": [["a", "b"]], "overrides": [PairConfig(bodies=["world", "a"])]},
            r"overrides\[0\]: .* none of the pairs that may touch",
        ),
        ({"k": -1.0}, "contact between world and a: k must be positive"),
        ({"k": None, "n": 1.5}, "contact between world and a: .* set k"),
        ({"n": 0.5}, "contact between world and a: n must be"),
        ({"alpha": math.nan}, "contact between world and a: alpha must be"),
        ({"standoff": None}, "contact between world and a: .*set standoff"),
        ({"standoff": 0.0}, "facet web needs a positive standoff"),
        (
            {"web": "spider"},
            "^web must be .*, not 'spider'",
        ),
        ({"weighting": "none"}, "weighting must be"),
        ({"threads": 0}, "threads must be"),
        ({"max_step": -1.0}, "max_step must be a time"),
        ({"tessellation_tolerance": 0.0}, "tessellation_tolerance must be a share of the radius"),
        ({"half_space_reach": -1.0}, "half_space_reach must be a finite radius"),
        ({"when_deep": "sink"}, "when_deep must be warn or raise"),
        ({"when_chattering": "talk"}, "when_chattering must be warn or raise"),
        ({"friction": FrictionConfig(static=-0.1)}, "contact between world and a: static must be"),
        ({"friction": FrictionConfig(static=0.1, dynamic=0.2)}, "dynamic must be between 0 and"),
        ({"web": "area", "k": None, "skin": 0.0}, "skin must be a thickness"),
        ({"web": "area", "field": "corn"}, "field must be one of"),
    ],
)
def test_settings_that_make_no_sense_are_refused_with_the_mend(settings, message):
    with pytest.raises(ValueError, match=message):
        Boxes().add(**settings)


def test_ambiguous_body_name_is_refused_with_the_choices():
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
    for model in ("left", "right"):
        finger = plant.AddRigidBody(
            "finger", plant.AddModelInstance(model), SpatialInertia.SolidBoxWithMass(1, 1, 1, 1)
        )
        plant.RegisterCollisionGeometry(finger, RigidTransform(), Box(1, 1, 1), "box", rubber())
    plant.Finalize()
    with pytest.raises(ValueError, match="say which: left::finger, right::finger"):
        AddNonlinearDamperContact(
            builder, plant, scene_graph, config=ContactConfig(pairs=[["finger", "world"]], **FACET)
        )
    contact = AddNonlinearDamperContact(
        builder,
        plant,
        scene_graph,
        config=ContactConfig(pairs=[["left::finger", "right::finger"]], **FACET),
    )
    assert contact.model.bodies == ("left::finger", "right::finger")


def test_plant_must_be_finalized():
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
    with pytest.raises(ValueError, match=r"plant\.Finalize"):
        AddNonlinearDamperContact(builder, plant, scene_graph)


def test_plant_must_have_geometry():
    plant = MultibodyPlant(0.0)
    plant.Finalize()
    builder = DiagramBuilder()
    with pytest.raises(ValueError, match="register it with the scene graph"):
        AddNonlinearDamperContact(builder, plant, builder.AddSystem(SceneGraph()))


def test_forces_already_applied_are_added_to():
    """A thruster and contact both act, through either force port, whatever was connected first."""
    boxes = Boxes("a")
    plant, builder = boxes.plant, boxes.builder
    thrust = builder.AddSystem(ConstantVectorSource(np.arange(6.0)))
    builder.Connect(thrust.get_output_port(), plant.get_applied_generalized_force_input_port())
    boxes.add()
    diagram = builder.Build()
    force = plant.get_applied_generalized_force_input_port()
    far = boxes.context(diagram, a=1.0)
    np.testing.assert_array_equal(force.Eval(plant.GetMyContextFromRoot(far)), np.arange(6.0))
    near = boxes.context(diagram, a=0.105)
    np.testing.assert_array_less(5.1, force.Eval(plant.GetMyContextFromRoot(near))[5])


def test_lists_of_forces_already_applied_are_added_to():
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
    inertia = SpatialInertia.SolidBoxWithMass(1.0, 0.2, 0.2, 0.2)
    lift = plant.AddRigidBody("lift", inertia)
    plant.AddJoint(PrismaticJoint("z", plant.world_frame(), lift.body_frame(), [0, 0, 1]))
    free = plant.AddRigidBody("free", inertia)
    for body in (lift, free):
        plant.RegisterCollisionGeometry(body, RigidTransform(), Box(0.2, 0.2, 0.2), "box", rubber())
    plant.Finalize()
    push = ExternallyAppliedSpatialForce()
    push.body_index = lift.index()
    push.F_Bq_W = SpatialForce(np.zeros(3), np.array([0, 0, 7.0]))
    pushing = builder.AddSystem(ConstantValueSource(AbstractValue.Make([push])))
    builder.Connect(pushing.get_output_port(), plant.get_applied_spatial_force_input_port())
    AddNonlinearDamperContact(builder, plant, scene_graph, config=ContactConfig(**FACET))
    context = builder.Build().CreateDefaultContext()
    plant_context = plant.GetMyContextFromRoot(context)
    plant.SetFreeBodyPose(plant_context, free, RigidTransform([0.01, 0.02, 0.205]))
    forces = plant.get_applied_spatial_force_input_port().Eval(plant_context)
    vertical = [force.F_Bq_W.translational()[2] for force in forces]
    assert len(vertical) == 2
    assert 7.0 in vertical
    assert min(vertical) < 0  # contact pushes the lower box down


def test_second_call_takes_the_pairs_the_first_has_left_and_adds_its_forces():
    boxes = Boxes()
    first = boxes.add(pairs=[["world", "a"]])
    second = boxes.add()
    assert touching_bodies(second) == pairs("world-b", "a-b")
    diagram = boxes.builder.Build()
    context = boxes.context(diagram, a=0.105, b=0.105)
    force = boxes.plant.get_applied_generalized_force_input_port().Eval(
        boxes.plant.GetMyContextFromRoot(context)
    )
    alone = [
        contact.get_generalized_forces_output_port().Eval(contact.GetMyContextFromRoot(context))
        for contact in (first, second)
    ]
    assert all(each.any() for each in alone)
    np.testing.assert_array_equal(force, sum(alone))


def test_exported_force_port_is_refused_with_the_mend():
    boxes = Boxes()
    boxes.builder.ExportInput(boxes.plant.get_applied_generalized_force_input_port(), "thrust")
    with pytest.raises(ValueError, match=r"exported from the diagram.*Adder"):
        boxes.add()


@pytest.mark.parametrize(
    ("settings", "complaint"),
    [
        ({"resolution": 0.1}, "^resolution: of the area web, and the web here is 'facet'; leave"),
        (
            {"web": "area", "weighting": "unit"},
            "^weighting: of the facet web, .*set web: facet",
        ),
        (
            {"overrides": [PairConfig(bodies=["a", "world"], web="area", weighting="unit")]},
            r"^overrides\[0\]: weighting: of the facet web",
        ),
    ],
)
def test_a_setting_of_the_other_web_is_refused(settings, complaint):
    # It would be ignored, and the user never know.
    with pytest.raises(ValueError, match=complaint):
        Boxes("a").add(**settings)


def test_an_override_may_change_the_web():
    # Settings of the web that the rest has do not hold for the exception's.
    override = PairConfig(bodies=["a", "world"], web="area", resolution=0.1)
    contact = Boxes("a").add(weighting="unit", overrides=[override])
    assert contact.model.pairs[0].web == AreaWeb(0.01, resolution=0.1, nominal_force=9.81)
