"""Surfaces without an inside: what they can touch, and what is said where they cannot."""

import logging

import mesh_shapes
import numpy as np
import pytest

from contact_toolkit import (
    AreaWeb,
    CollisionMesh,
    ContactGeometry,
    ContactModel,
    ContactPair,
    Friction,
    NonlinearDamper,
)

pytestmark = pytest.mark.engine

K = 1e8
V, F = mesh_shapes.cube(0.1)
SLAB = V * [5.0, 5.0, 1.0]
DEPTH = 1e-4


def model(a: CollisionMesh, b: CollisionMesh, **pair) -> ContactModel:
    return ContactModel(
        ["a", "b"],
        [ContactGeometry("nut/collision", "a", a), ContactGeometry("bolt/collision", "b", b)],
        [ContactPair(0, 1, NonlinearDamper(K), web=AreaWeb(**pair), friction=Friction(0.5))],
    )


def pushed(scene: ContactModel, z: float) -> np.ndarray:
    X = np.stack([np.eye(4), np.eye(4)])
    X[0, 2, 3] = z
    return scene.evaluate(X, np.zeros((2, 6))).body_wrenches[0]


@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("without", [F[2:], F[:, ::-1]], ids=["without a side", "wound inside out"])
def test_a_box_without_an_inside_on_a_slab(without, swapped):
    """A plant refused because one of its meshes is open, though the other is closed."""
    scene = model(CollisionMesh(V, without), CollisionMesh(SLAB, F))
    if swapped:
        scene = model(CollisionMesh(SLAB, F), CollisionMesh(V, without))
    wrench = pushed(scene, (-1 if swapped else 1) * (0.1 - DEPTH))
    force = K * 0.01 * DEPTH * (-1 if swapped else 1)
    np.testing.assert_allclose(wrench[3:], [0, 0, force], atol=0.01 * abs(force))


@pytest.mark.parametrize("faces", [F[1:], np.vstack([F, F[:, ::-1]])], ids=["hole", "doubled"])
def test_two_nearly_closed_bodies(faces):
    """Refused, or twice as stiff, for a defect far from the contact."""
    # The facet that is missing is of a side, away from where they touch.
    scene = model(CollisionMesh(V, faces), CollisionMesh(SLAB, faces))
    force = K * 0.01 * DEPTH
    np.testing.assert_allclose(pushed(scene, 0.1 - DEPTH)[3:], [0, 0, force], atol=0.02 * force)


@pytest.mark.parametrize("sampled", ["a", "b"])
def test_two_cubes_in_one_mesh_are_one_block(sampled):
    """The wall between them, seen as a surface, would push sideways or bear load."""
    second = V + np.array([0.1, 0, 0])
    two = CollisionMesh(np.vstack([V, second]), np.vstack([F, F + 8]))
    one = CollisionMesh(V * [2, 1, 1] + [0.05, 0, 0], F)
    found, expected = (
        pushed(model(block, CollisionMesh(SLAB, F), sampled=sampled), 0.1 - DEPTH)
        for block in (two, one)
    )
    np.testing.assert_allclose(found, expected, atol=1e-6 * K * 0.02 * DEPTH)
    # The slab's nodes, where these are sampled, see the block's rim to within their spacing.
    assert found[5] == pytest.approx(K * 0.02 * DEPTH, rel=0.02 if sampled == "a" else 0.06)


def test_what_is_said_of_two_open_surfaces(tmp_path):
    """A message that names neither the geometry, nor the file, nor the defect, nor the mend."""
    path = tmp_path / "nut.obj"
    lines = [f"v {x} {y} {z}" for x, y, z in V] + [f"f {a} {b} {c}" for a, b, c in F[2:] + 1]
    path.write_text("\n".join(lines))
    nut, bolt = CollisionMesh.from_file(path), CollisionMesh(*mesh_shapes.sheet())
    with pytest.raises(ValueError, match=r"pair 0 .*neither surface has an inside") as error:
        model(nut, bolt)
    said = str(error.value)
    assert f"geometry 'nut/collision' ({path}) has 4 open edges, the first of facet" in said
    assert "geometry 'bolt/collision' has 32 open edges" in said
    assert "standoff=0.003" in said
    assert f"`contact-toolkit inspect {path}`" in said
    with pytest.raises(ValueError, match=r"sampled='b'.*leave sampled as it is by default"):
        model(nut, CollisionMesh(SLAB, F), sampled="b")


def test_the_shell_that_is_offered_is_cheap():
    """A field of cells half the shell wide: 876 MB, and a thousandth of real time."""
    sheet = mesh_shapes.sheet(20, size=0.3, wave=0.0)
    flat = CollisionMesh(sheet[0] * [1, 1, 0], sheet[1])
    box = CollisionMesh(V, F[2:])
    for standoff in (3e-3, 1e-5):
        scene = model(box, flat, standoff=standoff, sampled="a")
        wrench = pushed(scene, 0.05 + standoff - standoff / 4)
        assert wrench[5] == pytest.approx(K * 0.01 * standoff / 4, rel=0.05)
        probed = scene.find(np.stack([np.eye(4)] * 2)).num_probed
        assert (probed < 20_000).all()


def test_repairs_are_told_once(caplog):
    """Facets set right in silence, or again for every pair."""
    faces = F.copy()
    faces[4] = faces[4, ::-1]
    mesh = CollisionMesh(V, np.vstack([faces, faces[7:8]]))
    with caplog.at_level(logging.WARNING, logger="contact_toolkit"):
        for _ in range(2):
            model(mesh, CollisionMesh(SLAB, F))
    assert len(caplog.records) == 1
    said = caplog.records[0].getMessage()
    assert "geometry 'nut/collision': for contact, 1 facet turned round (first: facet 4)" in said
    assert "1 facet left out as duplicates (first: facet 12)" in said
