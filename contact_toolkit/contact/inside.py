"""What an area pair needs of its surfaces: that the probed one bounds a solid, or a standoff."""

from __future__ import annotations

import logging

from contact_toolkit.contact.contact_pair import ContactGeometry
from contact_toolkit.contact.spring_webs import AreaWeb
from contact_toolkit.shapes.mesh import CollisionMesh

_SHELL = (
    0.02  # [-] of the smaller diagonal: as wide as nodes are usually apart, so it costs nothing
)
_log = logging.getLogger("contact_toolkit")


def require_inside(web: AreaWeb, a: ContactGeometry, b: ContactGeometry) -> None:
    """Refuse a pair of which no surface can be probed, with the defects and the mend."""
    if web.standoff > 0:
        return
    sides = {"a": a, "b": b}
    solid = [name for name, side in sides.items() if side.mesh.solid.has_inside]
    if web.sampled == "auto":
        if solid:
            return
        needed = [a, b]
        said = "neither surface has an inside to measure a penetration by"
    else:
        probed = "b" if web.sampled == "a" else "a"
        if probed in solid:
            return
        needed = [sides[probed]]
        said = f"sampled={web.sampled!r} has a surface probed that has no inside to measure a"
        said += " penetration by"
    shell = _SHELL * min(a.mesh.diagonal, b.mesh.diagonal)
    mends = [
        f"mend {'one of them' if len(needed) > 1 else 'it'}",
        f"set standoff={shell:.1g} (a shell [m] in which the surfaces already push)",
    ]
    if len(needed) == 1 and solid:
        mends.append("leave sampled as it is by default")
    raise ValueError(
        f"{said}. {' '.join(f'{describe(side)}.' for side in needed)} "
        f"{'; or '.join(mends)}".replace(". mend", ". Mend")
        + f". {inspect_command(needed)}"
    )


def tell_of_repairs(geometries: tuple[ContactGeometry, ...]) -> None:
    """Log, once a mesh, what of it is taken otherwise than given."""
    for geometry in geometries:
        mesh = geometry.mesh
        if mesh._told_of_repairs:
            continue
        mesh._told_of_repairs = True
        solid = mesh.solid
        said = []
        if solid.repairs:
            said.append(f"for contact, {solid.repairs}")
        if solid.kind == "nearly closed":
            said.append(
                f"it has {'; '.join(mesh.describe_defects())}: near them the sign is that of the "
                f"winding number, and contact is not to be trusted; close them where it matters "
                f"({inspect_command([geometry])})"
            )
        if solid.kind == "inside out":
            said.append(
                f"it is wound inside out (volume {solid.volume:.3g} m³), so it is only sampled, "
                f"never probed; reverse its facets"
            )
        if said:
            _log.warning("%s: %s", _where(geometry), "; ".join(said))


def _where(geometry: ContactGeometry) -> str:
    source = geometry.mesh.source
    return f"geometry {geometry.name!r}" + (f" ({source})" if source else "")


def describe(geometry: ContactGeometry) -> str:
    """Return its name, its file and what is wrong with it."""
    return f"{_where(geometry)} has {'; '.join(geometry.mesh.describe_defects()) or 'no volume'}"


def inspect_command(geometries: list[ContactGeometry]) -> str:
    """Return the command that shows more of what is wrong with them."""
    files = dict.fromkeys(_file(side.mesh) for side in geometries)
    return " and ".join(f"`contact-toolkit inspect {file}`" for file in files) + " shows more"


def _file(mesh: CollisionMesh) -> str:
    return mesh.source or "FILE"
