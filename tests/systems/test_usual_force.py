"""The force by which nodes are chosen where a body is round: the weight of the lighter body."""

import math

import pytest

from contact_toolkit import CollisionMesh
from contact_toolkit.shapes import primitives
from systems.contact_config import ContactLawConfig
from systems.plant.pair_parameters import make_contact_pair
from systems.plant.pair_stiffness import Side
from systems.plant.proximity_material import ProximityMaterial
from systems.plant.whole_bodies import WholeBody


@pytest.mark.parametrize(
    ("weights", "force"),
    [((3.0, math.inf), 3.0), ((3.0, 0.5), 0.5), ((math.inf, math.inf), None), ((0.0, 3.0), 3.0)],
)
def test_the_lighter_body_tells_the_usual_force(weights, force):
    """Nodes for a crate under a ball; for a body without mass, infinitely many."""
    mesh = CollisionMesh(*primitives.box([0.1, 0.1, 0.1]))
    material = ProximityMaterial(0.5, 0.5, 3.0, 1e6, 1e5)
    sides = [Side(i, mesh, material, WholeBody(0.2, weight)) for i, weight in enumerate(weights)]
    assert make_contact_pair(*sides, ContactLawConfig()).web.nominal_force == force
