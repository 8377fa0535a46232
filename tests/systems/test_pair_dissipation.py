"""Dissipation of two materials, combined as Drake does."""

import pytest

from contact_toolkit import CollisionMesh
from contact_toolkit.shapes import primitives
from systems.contact_config import ContactLawConfig
from systems.plant.pair_parameters import Side, make_contact_pair
from systems.plant.proximity_material import ProximityMaterial
from systems.plant.whole_bodies import WholeBody


@pytest.mark.parametrize("soft_is_first", [True, False])
def test_the_softer_side_lends_its_dissipation(soft_is_first):
    """Weights that are swapped: the hard side's dissipation, which hardly deforms."""
    mesh = CollisionMesh(*primitives.box([0.1, 0.1, 0.1]))
    whole = WholeBody(diagonal=mesh.diagonal, weight=10.0, load=10.0)
    soft = Side(0, mesh, ProximityMaterial(0.5, 0.5, 3.0, 1e6, 1e5), whole)
    hard = Side(1, mesh, ProximityMaterial(0.5, 0.5, 0.6, 4e6, 1e5), whole)
    sides = (soft, hard) if soft_is_first else (hard, soft)
    pair = make_contact_pair(*sides, ContactLawConfig())
    # d = E2 / (E1 + E2) d1 + E1 / (E1 + E2) d2
    assert pair.damper.alpha == pytest.approx(2 / 3 * (4 * 3.0 + 1 * 0.6) / 5)


@pytest.mark.parametrize(
    ("alpha", "loss"), [(0.0, 0.0), (0.01, 0.0015), (0.2, 0.01), (3.1, 0.01), (20.0, 0.03)]
)
def test_what_settles_loses_as_much_at_any_small_damping(alpha, loss):
    """With one settling speed for all, what is damped little would rattle on, and walk down."""
    mesh = CollisionMesh(*primitives.box([0.1, 0.1, 0.1]))
    whole = WholeBody(diagonal=mesh.diagonal, weight=10.0, load=10.0)
    a, b = (Side(i, mesh, ProximityMaterial(0.5, 0.5, 3.0, 1e6, 1e5), whole) for i in range(2))
    damper = make_contact_pair(a, b, ContactLawConfig(alpha=alpha)).damper
    assert 1.5 * alpha * damper.settling == pytest.approx(loss)
