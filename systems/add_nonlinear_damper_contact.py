"""Put nonlinear-damper contact into a diagram under construction."""

from __future__ import annotations

from functools import partial

from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder

from systems.contact_config import ContactConfig
from systems.diagnostics.silent_losses import warn_of_silent_losses
from systems.nonlinear_damper_contact import NonlinearDamperContact
from systems.plant.model_import import import_contact_model
from systems.plant.names import BodyNames
from systems.plant.pairs import choose_geometry_pairs
from systems.step.implicit_step import ImplicitStep
from systems.wiring.builtin_contact import take_over_pairs
from systems.wiring.force_ports import add_generalized_force, add_spatial_forces
from systems.wiring.planning import TakenPairs
from systems.wiring.plant_inputs import before_build


def AddNonlinearDamperContact(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    *,
    config: ContactConfig | None = None,
) -> NonlinearDamperContact:
    """Let bodies of a plant touch by the nonlinear damper instead of Drake's own contact.

    The collision geometries of the chosen pairs are taken away from built-in contact; all other
    pairs keep it. Pairs that the user filtered stay filtered, so a second call takes what the first
    has left. Drake's signed distances between the pairs are gone with its contact: inverse
    kinematics sees them only in a context opened by `contact.RestoreFilters`. Forces already
    connected to the plant's force input ports are added to; connect others before, not after.

    Parameters
    ----------
    builder
        Holds the plant and the scene graph; not built yet.
    plant
        Finalized.
    config
        Settings; by default every pair touches, by the area web, with Drake's own parameters.

    Returns
    -------
    NonlinearDamperContact
        Added to the builder, as "contact" unless there is one, and connected.

    Raises
    ------
    ValueError
        For settings that make no sense, body names the plant does not know, pairs that cannot
        touch, and where a force input port of the plant is exported from the diagram.
    MeshError
        For a collision geometry that cannot be read; the geometry is named.

    Examples
    --------
    >>> from pydrake.geometry import Box
    >>> from pydrake.math import RigidTransform
    >>> from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
    >>> from pydrake.multibody.tree import SpatialInertia
    >>> from pydrake.systems.framework import DiagramBuilder
    >>> from systems import AddNonlinearDamperContact
    >>> builder = DiagramBuilder()
    >>> plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.001)
    >>> cube = plant.AddRigidBody("cube", SpatialInertia.SolidBoxWithMass(1, 0.1, 0.1, 0.1))
    >>> for body, size in ((plant.world_body(), (1, 1, 0.1)), (cube, (0.1, 0.1, 0.1))):
    ...     _ = plant.RegisterCollisionGeometry(
    ...         body, RigidTransform(), Box(*size), "box", CoulombFriction(0.5, 0.5)
    ...     )
    >>> plant.Finalize()
    >>> contact = AddNonlinearDamperContact(builder, plant, scene_graph)
    >>> diagram = builder.Build()
    >>> contact.model.bodies
    ('world', 'cube')
    """
    if not plant.is_finalized():
        raise ValueError("plant must be finalized before contact is added: call plant.Finalize()")
    if not plant.geometry_source_is_registered():
        raise ValueError("plant has no geometry: register it with the scene graph")
    warn_of_silent_losses(plant)
    config = ContactConfig() if config is None else config
    names = BodyNames(plant)
    pairs = choose_geometry_pairs(plant, scene_graph.model_inspector(), names, config.pairs)
    model, bodies = import_contact_model(plant, scene_graph, names, pairs, config)
    if config.discrete not in ("implicit", "explicit"):
        raise ValueError(f"discrete must be implicit or explicit, not {config.discrete!r}")
    implicit = None
    if plant.time_step() > 0 and config.discrete == "implicit":
        implicit = partial(ImplicitStep, plant, scene_graph, model, bodies, pairs)
    contact = NonlinearDamperContact(
        plant,
        model,
        bodies,
        implicit=implicit,
        hold_anchors=config.hold_anchors,
        max_step=config.max_step,
        when_deep=config.when_deep,
        when_chattering=config.when_chattering,
        initial_overlap=config.initial_overlap,
        easing_time=config.easing_time,
        taken_pairs=TakenPairs(scene_graph, pairs),
    )
    take_over_pairs(scene_graph, plant.get_source_id(), pairs)
    if builder.HasSubsystemNamed("contact"):
        builder.AddSystem(contact)
    else:
        builder.AddNamedSystem("contact", contact)
    if contact.implicit:
        contact.connect_plant_forces(builder)
        before_build(builder, lambda: contact.connect_plant_inputs(builder))
    builder.Connect(plant.get_state_output_port(), contact.get_state_input_port())
    if contact.uses_state or contact.implicit:
        add_generalized_force(
            builder,
            contact.get_generalized_forces_output_port(),
            plant.get_applied_generalized_force_input_port(),
        )
    if contact.uses_lists:
        builder.Connect(plant.get_body_poses_output_port(), contact.get_body_poses_input_port())
        builder.Connect(
            plant.get_body_spatial_velocities_output_port(),
            contact.get_body_spatial_velocities_input_port(),
        )
        if not contact.implicit:
            add_spatial_forces(
                builder,
                contact.get_spatial_forces_output_port(),
                plant.get_applied_spatial_force_input_port(),
            )
    return contact
