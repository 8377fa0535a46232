"""Tells of bodies so large that their file must have been in millimetres."""

from __future__ import annotations

import warnings
from collections.abc import Iterable

from pydrake.geometry import Convex, Mesh, SceneGraph
from pydrake.multibody.plant import MultibodyPlant

from systems.plant.geometry_import import ImportedGeometry

_HUGE = 10.0  # [m] few moving bodies made of a mesh are as large; a part of 1 cm read as mm is


def warn_of_millimetres(
    plant: MultibodyPlant, scene_graph: SceneGraph, geometries: Iterable[ImportedGeometry]
) -> None:
    """Warn, once, of meshes on moving bodies that are larger than ten metres."""
    inspector = scene_graph.model_inspector()
    huge = [
        f"{geometry.name} of {plant.get_body(geometry.body).name()} is {geometry.mesh.diagonal:.3g}"
        for geometry in geometries
        if geometry.mesh.diagonal > _HUGE
        and isinstance(inspector.GetShape(geometry.geometry_id), Mesh | Convex)
        and not plant.IsAnchored(plant.get_body(geometry.body))
    ]
    if huge:
        warnings.warn(
            f"collision geometry {', '.join(huge[:3])} m across; if its file is in millimetres, "
            'scale it by 0.001 (scale="0.001 0.001 0.001" in URDF, <scale> in SDF, Mesh(path, '
            "0.001))",
            UserWarning,
            stacklevel=4,
        )
