"""Links of one robot whose meshes are open: contact between two of them cannot be told."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence

from pydrake.geometry import GeometryId
from pydrake.multibody.plant import MultibodyPlant

from contact_toolkit import ContactGeometry
from contact_toolkit.contact.inside import describe, inspect_command
from systems.contact_config import ContactLawConfig
from systems.plant.geometry_import import ImportedGeometry
from systems.plant.pair_web import web_name
from systems.plant.pairs import GeometryPair
from systems.plant.whole_bodies import joint_trees

_LISTED = 4  # geometries; a robot exported from CAD may have dozens


def without_open_links(
    plant: MultibodyPlant,
    geometries: Mapping[GeometryId, ImportedGeometry],
    pairs: Sequence[GeometryPair],
    law_of: Callable[[GeometryPair], ContactLawConfig],
    as_contact: Callable[[ImportedGeometry], ContactGeometry],
) -> list[GeometryPair]:
    """Return the pairs but for those of two links of one tree of joints that have no inside.

    They pass through each other, of which it warns with what is wrong and how to mend it: a robot
    whose shells are drawn open still stands on the ground and takes hold of things, as one of two
    surfaces has to have an inside. Where a standoff is given, it serves.
    """
    tree_of = joint_trees(plant)

    def is_open(pair: GeometryPair) -> bool:
        a, b = (geometries[side] for side in pair)
        law = law_of(pair)
        return (
            tree_of[int(a.body)] == tree_of[int(b.body)]
            and web_name(law) == "area"
            and not law.standoff
            and not (a.mesh.solid.has_inside or b.mesh.solid.has_inside)
        )

    dropped = [pair for pair in pairs if is_open(pair)]
    if dropped:
        shells = {side: as_contact(geometries[side]) for pair in dropped for side in pair}
        listed = list(shells.values())[:_LISTED]
        more = len(shells) - len(listed)
        warnings.warn(
            f"{len(shells)} geometries of one robot have no inside to measure a penetration by, so "
            f"{len(dropped)} pair{'s' if len(dropped) > 1 else ''} of them will pass through each "
            "other; whatever is closed they touch. "
            + "".join(f"{describe(shell)}. " for shell in listed)
            + (f"And {more} more. " if more else "")
            + "Mend the meshes, or set standoff (a shell [m] in which the surfaces already push). "
            + inspect_command(listed),
            UserWarning,
            stacklevel=4,
        )
    left_out = set(dropped)
    return [pair for pair in pairs if pair not in left_out]
