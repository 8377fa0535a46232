"""Solids put together and cut from each other; the results are closed whatever the operands."""

from __future__ import annotations

import numpy as np

from scenarios.parts.surface import Surface

_SMALLEST = 1e-7  # [m] detail below this is merged away: slivers that no contact can feel


def union(*surfaces: Surface) -> Surface:
    """Return the solid made of all of them."""
    import manifold3d

    return _surface(
        manifold3d.Manifold.batch_boolean(
            [_manifold(surface) for surface in surfaces], manifold3d.OpType.Add
        )
    )


def difference(surface: Surface, *cutters: Surface) -> Surface:
    """Return the solid without the cutters."""
    import manifold3d

    return _surface(
        manifold3d.Manifold.batch_boolean(
            [_manifold(surface), *map(_manifold, cutters)], manifold3d.OpType.Subtract
        )
    )


def moved(surface: Surface, translation: tuple[float, float, float], rotation=None) -> Surface:  # type: ignore[no-untyped-def]
    """Return the solid rotated (3, 3), then translated [m]."""
    vertices, faces = surface
    turned = vertices if rotation is None else vertices @ np.asarray(rotation).T
    return turned + np.asarray(translation), faces


def _manifold(surface: Surface):  # type: ignore[no-untyped-def]
    import manifold3d

    vertices, faces = surface
    mesh = manifold3d.Mesh64(np.array(vertices, np.float64), np.array(faces, np.uint64))
    made = manifold3d.Manifold(mesh)
    assert made.status() == manifold3d.Error.NoError, made.status()
    return made


def _surface(manifold) -> Surface:  # type: ignore[no-untyped-def]
    mesh = manifold.simplify(_SMALLEST).to_mesh64()
    return (
        np.array(mesh.vert_properties[:, :3], np.float64),
        np.array(mesh.tri_verts, np.int32),
    )
