"""What a scenario's playback draws, and from where it is seen."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import (
    GeometryId,
    IllustrationProperties,
    Mesh,
    Meshcat,
    MeshcatVisualizer,
    MeshcatVisualizerParams,
    Rgba,
    Role,
    SceneGraph,
)
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import DiagramBuilder

from scenarios.format.scenario import Scenario
from scenarios.simulation.contact_playback import ContactPlayback
from systems import NonlinearDamperContact

ARROW = 0.6  # length of the arrow of the mean weight, relative to the mean body's radius
_DRAWN = {".obj", ".gltf", ".glb", ".vtk"}  # mesh files that Meshcat draws
_PLAIN = Rgba(0.6, 0.65, 0.7, 1.0)
_VIEW = np.array([0.62, -0.68, 0.39])  # from where a scene is seen, a unit vector

Floats = NDArray[np.float64]


def add_drawings(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    contact: NonlinearDamperContact,
    meshcat: Meshcat,
    scenario: Scenario,
    *,
    live: bool = False,
) -> None:
    """Draw bodies, springs and forces; `live` adds the collision layer, hidden at first."""
    show = scenario.visualization
    period = 1.0 / show.frame_rate
    draw_bare_collision_models(plant, scene_graph)
    parameters = MeshcatVisualizerParams(role=Role.kIllustration, publish_period=period)
    MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat, parameters)
    if live:
        parameters = MeshcatVisualizerParams(
            role=Role.kProximity,
            publish_period=period,
            prefix="collision",
            visible_by_default=False,
        )
        MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat, parameters)
    weight = mean_weight(plant)
    arrow = show.force_scale * weight or ARROW * _mean_radius(plant, contact)
    if show.web or show.arrows:
        drawing = ContactPlayback(
            plant,
            contact,
            meshcat,
            publish_period=period,
            arrow=arrow if show.arrows else 0.0,
            weight=weight,
            lines=show.web,
            record=not live,
        )
        ContactPlayback.add_to(builder, contact, drawing)
    for scenery in ("/Grid", "/Axes"):
        meshcat.SetProperty(scenery, "visible", value=False)


def draw_bare_collision_models(plant: MultibodyPlant, scene_graph: SceneGraph) -> None:
    """Let bodies be seen by their collision geometry that have no other which Meshcat draws."""
    inspector = scene_graph.model_inspector()

    def drawn(geometry: GeometryId) -> bool:
        shape = inspector.GetShape(geometry)
        return not isinstance(shape, Mesh) or shape.source().extension() in _DRAWN

    for index in range(plant.num_bodies()):
        frame = plant.GetBodyFrameIdIfExists(BodyIndex(index))
        if frame is None:
            continue
        shown = inspector.GetGeometries(frame, Role.kIllustration)
        if any(map(drawn, shown)):
            continue
        for geometry in shown:  # their names may be those of the others
            scene_graph.RemoveRole(plant.get_source_id(), geometry, Role.kIllustration)
        for geometry in inspector.GetGeometries(frame, Role.kProximity):
            properties = IllustrationProperties()
            properties.AddProperty("phong", "diffuse", _PLAIN)
            scene_graph.AssignRole(plant.get_source_id(), geometry, properties)


def mean_weight(plant: MultibodyPlant) -> float:
    """Return the mean weight [N] of the bodies that move, as if on earth where nothing falls."""
    fixed = {body.index() for body in plant.GetBodiesWeldedTo(plant.world_body())}
    masses = [
        plant.get_body(BodyIndex(index)).default_mass()
        for index in range(plant.num_bodies())
        if BodyIndex(index) not in fixed
    ]
    gravity = np.linalg.norm(plant.gravity_field().gravity_vector()) or 9.81
    usable = [mass for mass in masses if np.isfinite(mass) and mass > 0.0]
    return float(np.median(usable) * gravity) if usable else 1.0


def camera_for(points: Floats, radius: float) -> tuple[Floats, Floats]:
    """Return where to stand and where to look to see points (n, 3) [m] of bodies that large [m].

    Of none, as when a run fails at its start, where bodies of that size would be about the origin.
    """
    low, high = np.percentile(points if len(points) else np.zeros((1, 3)), [5.0, 95.0], axis=0)
    target = (low + high) / 2
    size = np.linalg.norm(high - low) / 2 + 1.2 * radius
    return target + 1.5 * size * _VIEW, target


def moving_radii(plant: MultibodyPlant, contact: NonlinearDamperContact) -> dict[int, float]:
    """Return, for each moving body of the contact model, how far it reaches from its origin [m]."""
    model = contact.model
    fixed = {body.index() for body in plant.GetBodiesWeldedTo(plant.world_body())}
    radii: dict[int, float] = {}
    for geometry, row in zip(model.geometries, model.geometry_bodies, strict=True):
        body = contact.bodies[row]
        if body not in fixed:
            corners = np.stack([geometry.mesh.lower, geometry.mesh.upper])
            middle = geometry.X_BG[:3, :3] @ corners.mean(axis=0) + geometry.X_BG[:3, 3]
            reach = float(np.linalg.norm(middle) + geometry.mesh.diagonal / 2)
            radii[body] = max(radii.get(body, 0.0), reach)
    return radii


def _mean_radius(plant: MultibodyPlant, contact: NonlinearDamperContact) -> float:
    return float(np.median(list(moving_radii(plant, contact).values()) or [0.1]))
