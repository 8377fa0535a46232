"""The material library: usable numbers, each accounted for."""

import pytest

from contact_toolkit import MATERIALS, Friction, NonlinearDamper, find_material
from contact_toolkit.contact.materials import STIFFEST_MODULUS

NAMED = ("steel", "aluminium", "hard plastic", "rubber", "wood", "ice", "mud", "tall grass", "sand")


def test_the_library_holds_what_it_promises():
    assert set(NAMED) == set(MATERIALS)


@pytest.mark.parametrize("name", NAMED)
def test_every_set_makes_a_contact_and_says_why(name):
    material = find_material(name)
    damper = NonlinearDamper(material.modulus / 1e-3, material.alpha, adhesion=material.adhesion)
    assert damper.restitution(1.0) == pytest.approx(material.restitution, rel=1e-9)
    Friction(
        material.static_friction,
        material.dynamic_friction,
        material.stiffness_ratio,
        material.damping,
    )
    assert len(material.source) > 50
    assert 0 < material.modulus <= STIFFEST_MODULUS


def test_media_that_only_resist_have_a_damping_to_resist_with():
    for name, material in MATERIALS.items():
        assert (material.stiffness_ratio == 0) == (material.damping is not None), name


def test_steel_is_within_the_published_range():
    assert 0.08 <= find_material("steel").alpha <= 0.32


def test_aluminium_on_steel_is_the_tabulated_pair():
    steel, aluminium = find_material("steel"), find_material("aluminium")
    combine = Friction.combined_coefficient
    assert combine(steel.static_friction, aluminium.static_friction) == pytest.approx(
        0.61, abs=5e-3
    )
    assert combine(steel.dynamic_friction, aluminium.dynamic_friction) == pytest.approx(
        0.47, abs=5e-3
    )


def test_an_unknown_name_is_answered_with_the_known_ones():
    with pytest.raises(ValueError, match=r"no material 'butter'; there are steel, aluminium"):
        find_material("butter")


def test_the_library_cannot_be_changed_by_accident():
    with pytest.raises(TypeError):
        MATERIALS["steel"] = MATERIALS["mud"]
