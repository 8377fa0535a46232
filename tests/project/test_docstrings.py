"""The examples in the docstrings run, and what they print is what they say."""

import doctest

import pytest

import contact_toolkit
import contact_toolkit.viewer
import systems

PACKAGES = (contact_toolkit, contact_toolkit.viewer, systems)
PUBLIC = {name: getattr(package, name) for package in PACKAGES for name in package.__all__}
# Made by others: whose example shows them.
SHOWN_BY = {
    "MATERIALS": "find_material",
    "Material": "find_material",
    "ClosestPair": "distance",
    "FeatureKind": "witness_pairs",
    "WitnessPairs": "witness_pairs",
    "Distances": "distance_batch",
    "SignedDistances": "signed_distance",
    "SweptDistance": "swept_distance",
    "SweptDistances": "swept_distance_batch",
    "TimeOfImpact": "time_of_impact",
    "TimesOfImpact": "time_of_impact_batch",
    "ImpactStatus": "time_of_impact_batch",
    "Shape": "ConvexPieces",
    "MeshDefects": "CollisionMesh",
    "MeshSolid": "CollisionMesh",
    "MeshError": "CollisionMesh",
    "DecompositionError": "decompose",
    "CSpaceClass": "classify",
    "CSpaceGeometry": "CSpaceModel",
    "Classification": "classify",
    "MotionClassification": "classify_motions",
    "ContactGeometry": "ContactModel",
    "ContactPair": "ContactModel",
    "ContactState": "ContactModel",
    "ContactStatus": "ContactModel",
    "ContactArrays": "ContactModel",
    "LoadedSprings": "ContactModel",
    "Forces": "ContactModel",
    "Linearization": "ContactModel",
    "StepSolution": "StepSolver",
    "ContactLawConfig": "ContactConfig",
    "MeshBody": "add_mesh_body",
}
RAISING = [  # queries, and what reads a model: an error of theirs is the caller's to know
    "AddNonlinearDamperContact",
    "WitnessCache",
    "distance",
    "intersects",
    "signed_distance",
    "swept_distance",
    "swept_intersects",
    "time_of_impact",
    "witness_pairs",
]


@pytest.mark.parametrize("name", sorted(set(PUBLIC) - set(SHOWN_BY)))
def test_examples(name):
    # An example that no longer runs teaches what does not work.
    (example,) = doctest.DocTestFinder(recurse=False).find(PUBLIC[name], name, globs={})
    assert example.examples
    report: list[str] = []
    assert doctest.DocTestRunner().run(example, out=report.append).failed == 0, "".join(report)


def test_every_public_name_is_shown():
    # A name whose use is to be guessed; or a list above of what is gone.
    assert set(SHOWN_BY) <= set(PUBLIC)
    assert set(SHOWN_BY.values()) <= set(PUBLIC) - set(SHOWN_BY)


@pytest.mark.parametrize("name", RAISING)
def test_errors_are_listed(name):
    # What to catch, and when.
    assert "Raises" in PUBLIC[name].__doc__ or "errors" in PUBLIC[name].__doc__
