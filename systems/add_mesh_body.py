"""Make a body of a plant from a mesh file alone."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.common import MemoryFile
from pydrake.geometry import InMemoryMesh, Mesh, ProximityProperties
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import (
    ModelInstanceIndex,
    RigidBody,
    RotationalInertia,
    SpatialInertia,
    default_model_instance,
)

from contact_toolkit import CollisionMesh, MeshError
from contact_toolkit.shapes.mass_properties import mass_properties
from systems.plant.mesh_files import obj_text, read_for_drake


@dataclass(frozen=True)
class MeshBody:
    """A body made of a mesh.

    Attributes
    ----------
    body
        Of the plant.
    mesh
        Its surface, in the body's frame; `mesh.solid.repairs` says what was set right.
    mass
        [kg]
    p_BoBcm
        (3,) centre of mass [m].
    report
        What is wrong with the file's mesh, and what was made of it; empty if nothing.
    """

    body: RigidBody
    mesh: CollisionMesh
    mass: float
    p_BoBcm: NDArray[np.float64]
    report: str


def add_mesh_body(
    plant: MultibodyPlant,
    path: str | Path,
    *,
    name: str | None = None,
    density: float = 1000.0,
    scale: float = 1.0,
    model_instance: ModelInstanceIndex | None = None,
    properties: ProximityProperties | None = None,
    friction: tuple[float, float] = (0.5, 0.5),
    color: ArrayLike = (0.6, 0.65, 0.7, 1.0),
) -> MeshBody:
    """Add a body with the inertia, the collision and the visual geometry of a mesh file.

    Any mesh the toolkit reads: .obj, .stl, .ply, .off, .glb, .gltf (the last two stood upright as
    Drake does). Doubled and turned facets are set right and reported. The plant's geometry is
    registered where it has a scene graph.

    Parameters
    ----------
    plant
        Not finalized yet.
    path
        The mesh file.
    name
        Of the body; the file's unless given.
    density
        [kg/m³], uniform.
    scale
        Multiplies the coordinates: 0.001 for a file in millimetres.
    model_instance
        The default one unless given.
    properties
        For contact; by default only `friction`, static and dynamic coefficient.
    color
        (4,) red, green, blue, alpha.

    Raises
    ------
    MeshError
        Where the file cannot be read, or bounds no solid to have a mass; with the mend.
    ValueError
        Where scale or density make no sense.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from pydrake.multibody.plant import MultibodyPlant
    >>> from contact_toolkit.parts import icosphere, write_obj
    >>> from systems import add_mesh_body
    >>> plant = MultibodyPlant(time_step=0.001)
    >>> with TemporaryDirectory() as folder:
    ...     ball = write_obj(Path(folder) / "ball.obj", icosphere(radius=50.0, frequency=8))
    ...     made = add_mesh_body(plant, ball, density=1000.0, scale=0.001)  # a file in millimetres
    >>> made.body.name(), round(made.mass, 2), made.report  # a ball of 5 cm: 0.52 kg, and less
    ('ball', 0.52, '')
    """
    path = Path(path)
    if not (np.isfinite(scale) and scale > 0):
        raise ValueError(f"{path}: scale must be positive and finite, not {scale}")
    if not (np.isfinite(density) and density > 0):
        raise ValueError(f"{path}: density must be positive and finite [kg/m³], not {density}")
    vertices, faces = read_for_drake(path)
    try:
        mesh = CollisionMesh(vertices * scale, faces, source=str(path))
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from error
    solid = mesh.solid
    defects = "; ".join(mesh.describe_defects())
    if not solid.has_inside:
        raise MeshError(
            f"{path}: bounds no solid, so it has no mass: {defects}. `contact-toolkit inspect "
            f"{path}` shows more; close it (for example with trimesh.repair), or give the body its "
            f"inertia in a URDF and parse that with systems.parse_model"
        )
    mass, p_BoBcm, I_BBcm = mass_properties(mesh.repaired(), density)
    name = path.stem if name is None else name
    instance = default_model_instance() if model_instance is None else model_instance
    body = plant.AddRigidBody(name, instance, _spatial_inertia(mass, p_BoBcm, I_BBcm))
    if plant.geometry_source_is_registered():
        if properties is None:
            properties = ProximityProperties()
            properties.AddProperty("material", "coulomb_friction", CoulombFriction(*friction))
        shape = Mesh(
            InMemoryMesh(
                mesh_file=MemoryFile(obj_text(mesh.vertices, mesh.faces), ".obj", str(path))
            )
        )
        X_BG = RigidTransform()
        plant.RegisterCollisionGeometry(body, X_BG, shape, f"{name}_collision", properties)
        plant.RegisterVisualGeometry(
            body, X_BG, shape, f"{name}_visual", np.asarray(color, dtype=float)
        )
    report = "; ".join(text for text in (defects, solid.repairs) if text)
    return MeshBody(body, mesh, float(mass), p_BoBcm, report)


def _spatial_inertia(
    mass: float, p_BoBcm: NDArray[np.float64], I_BBcm: NDArray[np.float64]
) -> SpatialInertia:
    moments, products = np.diag(I_BBcm), (I_BBcm[0, 1], I_BBcm[0, 2], I_BBcm[1, 2])
    return SpatialInertia.MakeFromCentralInertia(
        mass, p_BoBcm, RotationalInertia(*moments, *products)
    )
