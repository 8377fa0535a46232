"""Solids put together and cut from each other; the results are closed whatever the operands."""

from __future__ import annotations

import numpy as np

from contact_toolkit import _core
from contact_toolkit.shapes.primitives import Triangles as Surface

_SMALLEST = 1e-7  # [m] detail below this is merged away: slivers that no contact can feel
# [-] Of the size: so close together, surfaces touch. Vertices are moved by half of it, onto a grid.
TOUCHING = 2.0**-34


def union(*surfaces: Surface) -> Surface:
    """Return the solid made of all of them."""
    import manifold3d  # noqa: PLC0415  the toolkit imports with numpy alone

    return _surface(
        manifold3d.Manifold.batch_boolean(
            [_manifold(surface) for surface in surfaces], manifold3d.OpType.Add
        )
    )


def united_shells(*surfaces: Surface) -> Surface:
    """Return the solid made of all closed shells of the surfaces, each filled.

    Shells that touch up to `TOUCHING` become one, and sides that they had in common vanish. Raises
    MeshError for what is not closed and for shells wound inside out, such as those of cavities.
    """
    import manifold3d  # noqa: PLC0415

    size = max(float(np.ptp(vertices, axis=0).max()) for vertices, _ in surfaces)
    grid = TOUCHING * 2.0 ** np.ceil(np.log2(size))
    shells = [
        shell
        for vertices, faces in surfaces
        for shell in _manifold((np.round(vertices / grid) * grid, faces)).decompose()
    ]
    if any(shell.volume() < 0 for shell in shells):
        raise _core.MeshError("a shell is inside out: of a cavity, as a rule")
    whole = manifold3d.Manifold.batch_boolean(shells, manifold3d.OpType.Add)
    # As if it had been made in one piece: sides that come to lie in a plane are one.
    mesh = whole.as_original().simplify(grid).to_mesh64()
    return np.array(mesh.vert_properties[:, :3], np.float64), np.array(mesh.tri_verts, np.int32)


def difference(surface: Surface, *cutters: Surface) -> Surface:
    """Return the solid without the cutters."""
    import manifold3d  # noqa: PLC0415

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
    import manifold3d  # noqa: PLC0415

    vertices, faces = surface
    mesh = manifold3d.Mesh64(np.array(vertices, np.float64), np.array(faces, np.uint64))
    made = manifold3d.Manifold(mesh)
    if made.status() != manifold3d.Error.NoError:
        raise _core.MeshError(f"no closed surface: {made.status().name}")
    return made


def _surface(manifold) -> Surface:  # type: ignore[no-untyped-def]
    mesh = manifold.simplify(_SMALLEST).to_mesh64()
    return (
        np.array(mesh.vert_properties[:, :3], np.float64),
        np.array(mesh.tri_verts, np.int32),
    )
