"""Every Drake shape becomes the mesh of the same solid, in the same place."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from pydrake.common import MemoryFile
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    InMemoryMesh,
    Mesh,
    ProximityProperties,
    SceneGraphConfig,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.framework import DiagramBuilder

from contact_toolkit import CollisionMesh, MeshError
from systems.plant.geometry_import import GeometryImporter, ImportedGeometry
from systems.plant.proximity_material import USUAL_DISSIPATION, ProximityMaterial

X_BG = RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [1.0, 2.0, 3.0])

# A 1 x 2 x 3 wedge standing on the origin; the last facet is a quad, as .obj allows.
WEDGE_OBJ = """
v 0 0 0
v 1 0 0
v 0 2 0
v 0 0 3
v 1 0 3
v 0 2 3
f 1 3 2
f 4 5 6
f 1 2 5 4
f 2 3 6 5
f 3 1 4 6
"""

TETRAHEDRA_VTK = """# vtk DataFile Version 3.0
A tetrahedron with a vertex inside.
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 5 double
0 0 0
1 0 0
0 1 0
0 0 1
.2 .2 .2
CELLS 4 20
4 0 1 2 4
4 0 3 1 4
4 0 2 3 4
4 1 3 2 4
CELL_TYPES 4
10
10
10
10
"""


def imported(
    shape: Shape, properties: ProximityProperties | None = None, tolerance: float = 0.005
) -> ImportedGeometry:
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    body = plant.AddRigidBody("part", SpatialInertia.SolidSphereWithMass(1.0, 0.1))
    if properties is None:
        properties = ProximityProperties()
        properties.AddProperty("material", "coulomb_friction", CoulombFriction(0.6, 0.4))
    geometry = plant.RegisterCollisionGeometry(body, X_BG, shape, "shape", properties)
    plant.Finalize()
    importer = GeometryImporter(plant, scene_graph, tessellation_tolerance=tolerance)
    return importer.read(geometry)


def facet_distances(mesh: CollisionMesh) -> np.ndarray:
    """Return how far each facet's plane lies from the origin."""
    return np.einsum("fi,fi->f", mesh.face_normals, mesh.vertices[mesh.faces[:, 0]])


def volume_of(shape: Shape) -> float:
    match shape:
        case Box():
            return float(np.prod(shape.size()))
        case Sphere():
            return 4 / 3 * math.pi * shape.radius() ** 3
        case Ellipsoid():
            return 4 / 3 * math.pi * shape.a() * shape.b() * shape.c()
        case Cylinder():
            return math.pi * shape.radius() ** 2 * shape.length()
        case Capsule():
            return math.pi * shape.radius() ** 2 * (shape.length() + 4 / 3 * shape.radius())
    raise NotImplementedError


@pytest.mark.parametrize(
    "shape",
    [
        Box(0.1, 0.2, 0.3),
        Sphere(0.2),
        Ellipsoid(0.1, 0.2, 0.3),
        Cylinder(0.1, 0.4),
        Capsule(0.1, 0.4),
    ],
    ids=lambda shape: type(shape).__name__,
)
@pytest.mark.parametrize("tolerance", [0.1, 0.005, 0.0005])
def test_analytic_shape_is_closed_outward_and_of_the_right_volume(shape, tolerance):
    mesh = imported(shape, tolerance=tolerance).mesh
    assert mesh.defects.closed
    assert not mesh.defects.zero_area_facets.size
    true = volume_of(shape)
    # A facet `tolerance` inside the radius costs at most three times that of the volume.
    assert (1 - 3 * tolerance) * true <= mesh.volume <= true * (1 + 1e-12)


@pytest.mark.parametrize("tolerance", [0.3, 0.05, 0.005, 0.0005])
def test_sphere_facets_lie_within_the_tolerance_of_the_true_surface(tolerance):
    mesh = imported(Sphere(2.0), tolerance=tolerance).mesh
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices, axis=1), 2.0, rtol=1e-14)
    assert facet_distances(mesh).min() >= 2.0 * (1 - tolerance)


@pytest.mark.parametrize("tolerance", [0.05, 0.005])
def test_round_side_lies_within_the_tolerance_of_the_true_surface(tolerance):
    cylinder = imported(Cylinder(0.5, 8.0), tolerance=tolerance).mesh
    capsule = imported(Capsule(0.5, 8.0), tolerance=tolerance).mesh
    assert facet_distances(cylinder).min() >= 0.5 * (1 - tolerance)
    assert facet_distances(capsule).min() >= 0.5 * (1 - tolerance)
    np.testing.assert_allclose([cylinder.lower[2], cylinder.upper[2]], [-4, 4])
    np.testing.assert_allclose([capsule.lower[2], capsule.upper[2]], [-4.5, 4.5])


def test_half_space_shows_a_single_flat_facet_on_top():
    mesh = imported(HalfSpace()).mesh
    assert mesh.defects.closed
    assert mesh.upper[2] == 0.0
    tops = np.flatnonzero(mesh.face_normals[:, 2] > 0.999)
    assert len(tops) == 1
    corners = mesh.vertices[mesh.faces[tops[0]], :2]
    middles = (corners + np.roll(corners, 1, axis=0)) / 2
    np.testing.assert_allclose(np.linalg.norm(middles, axis=1), 100.0)


def test_mesh_keeps_its_facets_and_its_non_uniform_scale(tmp_path: Path):
    path = tmp_path / "wedge.obj"
    path.write_text(WEDGE_OBJ)
    mesh = imported(Mesh(path, np.array([1.0, 2.0, 0.5]))).mesh
    assert len(mesh.faces) == 8
    assert mesh.defects.closed
    assert mesh.volume == pytest.approx(3.0)
    np.testing.assert_allclose(mesh.upper, [1, 4, 1.5])


def test_mirrored_mesh_is_not_inside_out(tmp_path: Path):
    path = tmp_path / "wedge.obj"
    path.write_text(WEDGE_OBJ)
    assert imported(Mesh(path, np.array([-1.0, 1.0, 1.0]))).mesh.volume == pytest.approx(3.0)


def test_mesh_in_memory_is_read():
    source = InMemoryMesh(mesh_file=MemoryFile(WEDGE_OBJ, ".obj", "wedge"))
    assert imported(Mesh(source, 2.0)).mesh.volume == pytest.approx(24.0)


def test_gltf_mesh_stands_as_drake_stands_it(tmp_path: Path):
    trimesh = pytest.importorskip("trimesh")
    part = trimesh.creation.box((1, 2, 3))
    part.apply_translation([0, 0, 1])
    for name, content in part.export(file_type="gltf").items():
        (tmp_path / name.replace("model", "part")).write_bytes(content)
    mesh = imported(Mesh(tmp_path / "part.gltf")).mesh
    hull = imported(Convex(tmp_path / "part.gltf")).mesh
    np.testing.assert_allclose(mesh.lower, hull.lower, atol=1e-6)
    np.testing.assert_allclose(mesh.upper, hull.upper, atol=1e-6)


def test_tetrahedral_mesh_gives_its_boundary(tmp_path: Path):
    path = tmp_path / "tetrahedra.vtk"
    path.write_text(TETRAHEDRA_VTK)
    properties = ProximityProperties()
    AddCompliantHydroelasticProperties(0.1, 1e6, properties)
    geometry = imported(Mesh(path, 2.0), properties)
    assert geometry.mesh.defects.closed
    assert len(geometry.mesh.faces) == 4
    assert geometry.mesh.volume == pytest.approx(8 / 6)
    assert geometry.material.modulus == 1e6


def test_tetrahedral_mesh_without_hydroelastic_properties_is_refused_with_the_mend(tmp_path: Path):
    path = tmp_path / "tetrahedra.vtk"
    path.write_text(TETRAHEDRA_VTK)
    with pytest.raises(MeshError, match=r"'shape' of body .*part.*convert it to .obj"):
        imported(Mesh(path))


def test_convex_is_the_scaled_hull(tmp_path: Path):
    path = tmp_path / "notched.obj"  # a tetrahedron dented to its middle: the hull is not
    path.write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv .1 .1 .1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n"
        "f 2 3 5\nf 3 4 5\nf 4 2 5\n"
    )
    dented = imported(Mesh(path, 3.0)).mesh
    hull = imported(Convex(path, 3.0)).mesh
    assert hull.defects.closed
    assert hull.volume == pytest.approx(27 / 6)
    assert dented.volume < hull.volume


def test_pose_body_and_properties_are_read():
    geometry = imported(Box(1, 1, 1))
    np.testing.assert_array_equal(geometry.X_BG, X_BG.GetAsMatrix4())
    assert int(geometry.body) == 1
    assert geometry.material.static_friction == 0.6
    assert geometry.material.dynamic_friction == 0.4


def test_untagged_geometry_is_what_drake_would_take_it_to_be():
    material = imported(Box(1, 1, 1)).material
    default = SceneGraphConfig().default_proximity_properties
    assert material.dissipation == USUAL_DISSIPATION  # theirs suits steps, see test_tags.py
    assert material.modulus == default.hydroelastic_modulus
    assert material.point_stiffness == default.point_stiffness


def test_tagged_geometry_keeps_its_tags():
    properties = ProximityProperties()
    AddContactMaterial(
        dissipation=3.0,
        point_stiffness=4e5,
        friction=CoulombFriction(0.6, 0.4),
        properties=properties,
    )
    AddCompliantHydroelasticProperties(0.1, 1e6, properties)
    material = imported(Box(1, 1, 1), properties).material
    assert material == ProximityMaterial(
        0.6, 0.4, dissipation=3.0, modulus=1e6, point_stiffness=4e5
    )


def test_rigid_hydroelastic_geometry_is_infinitely_stiff():
    properties = ProximityProperties()
    AddRigidHydroelasticProperties(0.1, properties)
    assert imported(Box(1, 1, 1), properties).material.modulus == math.inf


def test_equal_shapes_share_one_mesh(tmp_path: Path):
    """Two hundred copies of a part must not take two hundred hierarchies."""
    path = tmp_path / "wedge.obj"
    path.write_text(WEDGE_OBJ)
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    body = plant.AddRigidBody("part", SpatialInertia.SolidSphereWithMass(1.0, 0.1))
    friction = CoulombFriction(1, 1)
    shapes = [Mesh(path), Mesh(path), Mesh(path, 2.0), Sphere(1.0), Sphere(1.0), Sphere(2.0)]
    ids = [
        plant.RegisterCollisionGeometry(body, RigidTransform(), shape, f"shape{i}", friction)
        for i, shape in enumerate(shapes)
    ]
    plant.Finalize()
    importer = GeometryImporter(plant, scene_graph)
    meshes = [importer.read(geometry).mesh for geometry in ids]
    assert meshes[0] is meshes[1]
    assert meshes[3] is meshes[4]
    assert len({id(mesh) for mesh in meshes}) == 4
