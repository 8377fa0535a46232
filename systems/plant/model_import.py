"""Build the contact model of chosen pairs of a plant's collision geometries."""

from __future__ import annotations

from collections.abc import Mapping

from pydrake.geometry import GeometryId, SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex

from contact_toolkit import ContactGeometry, ContactModel
from systems.contact_config import ContactConfig, ContactLawConfig
from systems.plant.geometry_import import GeometryImporter, ImportedGeometry
from systems.plant.millimetres import warn_of_millimetres
from systems.plant.names import BodyNames
from systems.plant.open_links import without_open_links
from systems.plant.pair_parameters import make_contact_pair, overlay
from systems.plant.pair_stiffness import Side
from systems.plant.pair_web import require_keys_of_web, web_name
from systems.plant.pairs import GeometryPair
from systems.plant.proximity_material import ProximityMaterial, library_material
from systems.plant.seams import unite_seams
from systems.plant.whole_bodies import WholeBodies


def import_contact_model(
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    names: BodyNames,
    pairs: list[GeometryPair],
    config: ContactConfig,
) -> tuple[ContactModel, list[BodyIndex]]:
    """Return the contact model of the pairs, and the plant's body for each of the model's bodies.

    Raises ValueError for settings that make no sense, telling where they stand, and MeshError for a
    geometry that cannot be read.
    """
    importer = GeometryImporter(
        plant,
        scene_graph,
        tessellation_tolerance=config.tessellation_tolerance,
        half_space_reach=config.half_space_reach,
    )
    geometries = importer.read_all(pairs)
    warn_of_millimetres(plant, scene_graph, geometries.values())
    materials = {
        names.find(body, "materials"): _material(body, material)
        for body, material in config.materials.items()
    }
    geometries, pairs = unite_seams(geometries, pairs, materials)
    laws = _laws(config, names, {_bodies_of(pair, geometries) for pair in pairs})
    bodies = sorted({geometry.body for geometry in geometries.values()}, key=int)
    rows = {body: row for row, body in enumerate(bodies)}

    def as_contact(geometry: ImportedGeometry) -> ContactGeometry:
        name = f"{names.name_of(geometry.body)}/{geometry.name}"
        return ContactGeometry(name, rows[geometry.body], geometry.mesh, geometry.X_BG)

    pairs = without_open_links(
        plant, geometries, pairs, lambda pair: laws[_bodies_of(pair, geometries)], as_contact
    )
    whole_bodies = WholeBodies(
        plant, ((each.body, each.mesh, each.X_BG) for each in geometries.values())
    )
    sides = {
        geometry: Side(
            index,
            imported.mesh,
            materials.get(imported.body, imported.material),
            whole_bodies.of(imported.body),
        )
        for index, (geometry, imported) in enumerate(geometries.items())
    }
    contact_pairs = []
    for a, b in pairs:
        try:
            law = laws[_bodies_of((a, b), geometries)]
            contact_pairs.append(make_contact_pair(sides[a], sides[b], law))
        except ValueError as error:
            touching = " and ".join(names.name_of(geometries[side].body) for side in (a, b))
            raise ValueError(f"contact between {touching}: {error}") from error
    model = ContactModel(
        [names.name_of(body) for body in bodies],
        [as_contact(geometry) for geometry in geometries.values()],
        contact_pairs,
        threads=config.threads,
    )
    return model, bodies


def _material(body: str, name: str) -> ProximityMaterial:
    try:
        return library_material(name)
    except ValueError as error:
        raise ValueError(f"materials: {body}: {error}") from error


def _bodies_of(
    pair: GeometryPair, geometries: Mapping[GeometryId, ImportedGeometry]
) -> frozenset[BodyIndex]:
    return frozenset(geometries[geometry].body for geometry in pair)


def _laws(
    config: ContactConfig, names: BodyNames, touching: set[frozenset[BodyIndex]]
) -> dict[frozenset[BodyIndex], ContactLawConfig]:
    """Return the settings of each two bodies that may touch."""
    require_keys_of_web(config, web_name(config))
    laws: dict[frozenset[BodyIndex], ContactLawConfig] = dict.fromkeys(touching, config)
    for i, override in enumerate(config.overrides):
        where = f"overrides[{i}]"
        pair = frozenset(names.find_two(override.bodies, where))
        if pair not in laws:
            raise ValueError(f"{where}: {override.bodies} is none of the pairs that may touch")
        laws[pair] = overlay(laws[pair], override)
        try:
            require_keys_of_web(override, web_name(laws[pair]))
        except ValueError as error:
            raise ValueError(f"{where}: {error}") from error
    return laws
