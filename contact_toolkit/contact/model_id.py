"""What a contact model is known by, in this process or another."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict, replace

from contact_toolkit.contact.contact_pair import ContactGeometry, ContactPair
from contact_toolkit.query.arguments import as_pose
from contact_toolkit.shapes.shared_mesh import surface_digest


def model_id(
    num_bodies: int,
    geometries: Sequence[ContactGeometry],
    body_of: Sequence[int],
    pairs: Sequence[ContactPair],
) -> int:
    """Return a number, not 0, that models of equal geometries and pairs have in common.

    `body_of`: for each geometry the index of its body.
    """
    digest = hashlib.blake2b(f"{num_bodies} bodies".encode(), digest_size=8)
    surfaces = {id(each.mesh): each.mesh for each in geometries}
    digests = {key: surface_digest(mesh) for key, mesh in surfaces.items()}
    for geometry, body in zip(geometries, body_of, strict=True):
        digest.update(digests[id(geometry.mesh)])
        digest.update(f"{body} {as_pose(geometry.X_BG, 'X_BG').tolist()}".encode())
    kinds: dict[ContactPair, int] = {}  # seldom many
    for pair in pairs:
        kind = kinds.setdefault(replace(pair, a=0, b=0), len(kinds))
        digest.update(f"{pair.a} {pair.b} {kind};".encode())
    for each in kinds:
        digest.update(f"{type(each.web).__name__} ".encode())
        digest.update(json.dumps(asdict(each), default=float).encode())
    return int.from_bytes(digest.digest(), "little") or 1
