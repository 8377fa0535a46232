"""The force by which nodes are chosen where a body is round: what the lighter body bears."""

import math

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RevoluteJoint, SpatialInertia

from contact_toolkit import CollisionMesh
from contact_toolkit.shapes import primitives
from systems.contact_config import ContactLawConfig
from systems.plant.pair_parameters import make_contact_pair
from systems.plant.pair_stiffness import Side
from systems.plant.proximity_material import ProximityMaterial
from systems.plant.whole_bodies import WholeBodies, WholeBody


@pytest.mark.parametrize(
    ("loads", "force"),
    [((3.0, math.inf), 3.0), ((3.0, 0.5), 0.5), ((math.inf, math.inf), None), ((0.0, 3.0), 3.0)],
)
def test_the_lighter_body_tells_the_usual_force(loads, force):
    """Nodes for a crate under a ball; for a body without mass, infinitely many."""
    mesh = CollisionMesh(*primitives.box([0.1, 0.1, 0.1]))
    material = ProximityMaterial(0.5, 0.5, 3.0, 1e6, 1e5)
    sides = [Side(i, mesh, material, WholeBody(0.2, 1.0, load)) for i, load in enumerate(loads)]
    assert make_contact_pair(*sides, ContactLawConfig()).web.nominal_force == force


def test_a_foot_bears_its_robot():
    """Nodes for the foot alone: ten times as many as what stands on it needs."""
    plant = MultibodyPlant(1e-3)
    inertia = SpatialInertia.SolidBoxWithMass(1.0, 0.1, 0.1, 0.1)
    foot, leg, trunk, other = (
        plant.AddRigidBody(name, inertia) for name in ("foot", "leg", "trunk", "other")
    )
    for parent, child in ((trunk, leg), (leg, foot)):
        joint = RevoluteJoint(child.name(), parent.body_frame(), child.body_frame(), [1, 0, 0])
        plant.AddJoint(joint)
    plant.Finalize()
    mesh = CollisionMesh(*primitives.box([0.1, 0.1, 0.1]))
    meshes = [(body.index(), mesh, np.eye(4)) for body in (foot, trunk, other)]
    whole = WholeBodies(plant, meshes)
    assert whole.of(foot.index()).load == pytest.approx(3 * 9.81)
    assert whole.of(foot.index()).weight == pytest.approx(9.81)
    assert whole.of(other.index()).load == pytest.approx(9.81)
