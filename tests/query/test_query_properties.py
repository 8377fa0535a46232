"""What must not change an answer, and what must change it in step (hypothesis)."""

from types import SimpleNamespace

import mesh_shapes
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from poses import inverse, pose, random_pose, random_rotation

from contact_toolkit import CollisionMesh, distance, intersects, witness_pairs

pytestmark = pytest.mark.engine

_TOLERANCE = 1e-12  # of the coordinates' size
_TOUCHING = 1e-13  # [m] for bodies of one metre: closer than this, rounding decides what touches

_SHAPES = {
    "doughnut": mesh_shapes.doughnut(10, 6, major=0.5, minor=0.2),
    "cone": mesh_shapes.cone(10, 2, bottom=0.5, top=0.2, height=1.0),
    "cube": mesh_shapes.cube(),
    "sheet": mesh_shapes.sheet(5),
    "soup": mesh_shapes.soup(40),
    "ball": mesh_shapes.ball(1, bumps=0.3),
    "sliver": mesh_shapes.sliver(width=1e-5),
}
_MESHES = {name: CollisionMesh(*shape) for name, shape in _SHAPES.items()}

shapes = st.sampled_from(sorted(_SHAPES))
rngs = st.integers(0, 2**32 - 1).map(np.random.default_rng)
some = settings(max_examples=100, suppress_health_check=[HealthCheck.too_slow])


def _standoff(rng):
    return 10.0 ** rng.uniform(-2.5, -0.3)


def _sorted_rows(found):
    order = np.lexsort((found.facet_b, found.facet_a))
    return found.facet_a[order], found.facet_b[order], found.distance[order]


def _assert_same_pairs(one, two, *, standoff, tolerance):
    """The same facet pairs at the same distances, but for pairs within rounding of the standoff."""
    one, two = (_as_dict(*_sorted_rows(found)) for found in (one, two))
    for here, there in ((one, two), (two, one)):
        for key, d in here.items():
            if key in there:
                assert abs(there[key] - d) <= tolerance
            else:
                assert d >= standoff - tolerance


def _as_dict(a, b, d):
    return dict(zip(zip(a.tolist(), b.tolist(), strict=True), d.tolist(), strict=True))


def _renumbered(found, facets_a, facets_b):
    """Rows with facet k of each mesh called facets[k]."""
    columns = found.columns()
    columns["facet_a"] = facets_a[found.facet_a]
    columns["facet_b"] = facets_b[found.facet_b]
    return SimpleNamespace(**columns)


@some
@given(shapes, shapes, rngs)
def test_swapping_a_and_b(a, b, rng):
    A, B = _MESHES[a], _MESHES[b]
    X_AB, standoff = random_pose(rng, 1.5), _standoff(rng)
    assert distance(A, B, X_AB).distance == pytest.approx(
        distance(B, A, inverse(X_AB)).distance, abs=3 * _TOLERANCE
    )
    one = witness_pairs(A, B, X_AB, standoff, merge=False)
    two = witness_pairs(B, A, inverse(X_AB), standoff, merge=False)
    turned = SimpleNamespace(**{**two.columns(), "facet_a": two.facet_b, "facet_b": two.facet_a})
    _assert_same_pairs(one, turned, standoff=standoff, tolerance=3 * _TOLERANCE)


@some
@given(shapes, shapes, rngs)
def test_moving_both_bodies(a, b, rng):
    """The same relative pose written with other coordinates: both meshes moved in their frames."""
    A, B = _MESHES[a], _MESHES[b]
    X_AB, standoff = random_pose(rng, 1.5), _standoff(rng)
    X_CA, X_DB = random_pose(rng, 2), random_pose(rng, 2)
    C, D = (
        CollisionMesh(mesh.vertices @ X[:3, :3].T + X[:3, 3], mesh.faces)
        for mesh, X in ((A, X_CA), (B, X_DB))
    )
    X_CD = X_CA @ X_AB @ inverse(X_DB)
    one = witness_pairs(A, B, X_AB, standoff, merge=False)
    two = witness_pairs(C, D, X_CD, standoff, merge=False)
    _assert_same_pairs(one, two, standoff=standoff, tolerance=10 * _TOLERANCE)


@some
@given(shapes, shapes, rngs, st.floats(-6, 6))
def test_uniform_scale(a, b, rng, exponent):
    """A tolerance in metres hidden somewhere."""
    scale = 10.0**exponent
    A, B = _MESHES[a], _MESHES[b]
    C, D = (CollisionMesh(scale * mesh.vertices, mesh.faces) for mesh in (A, B))
    X_AB, standoff = random_pose(rng, 1.5), _standoff(rng)
    X_CD = pose(X_AB[:3, :3], tuple(scale * X_AB[:3, 3]))
    one = witness_pairs(A, B, X_AB, standoff, merge=False)
    two = witness_pairs(C, D, X_CD, scale * standoff, merge=False)
    two = SimpleNamespace(**{**two.columns(), "distance": two.distance / scale})
    _assert_same_pairs(one, two, standoff=standoff, tolerance=3 * _TOLERANCE)


@some
@given(shapes, shapes, rngs)
def test_a_million_sizes_from_the_origin(a, b, rng):
    """Coordinates far larger than the bodies: only their own rounding may show."""
    A, B = _MESHES[a], _MESHES[b]
    X_AB, standoff = random_pose(rng, 1.5), _standoff(rng)
    shift = rng.choice([-1, 1], 3) * 2.0**20
    R = X_AB[:3, :3]
    C, D = (CollisionMesh(mesh.vertices + shift, mesh.faces) for mesh in (A, B))
    X_CD = pose(R, tuple(X_AB[:3, 3] + shift - R @ shift))
    one = witness_pairs(A, B, X_AB, standoff, merge=False)
    two = witness_pairs(C, D, X_CD, standoff, merge=False)
    _assert_same_pairs(one, two, standoff=standoff, tolerance=_TOLERANCE * 2**21)


@some
@given(shapes, shapes, rngs)
def test_permuting_facets_and_vertices(a, b, rng):
    """Where a facet stands in the file decides nothing but the order of rows."""
    A, B = _MESHES[a], _MESHES[b]
    X_AB, standoff = random_pose(rng, 1.5), _standoff(rng)
    (C, facets_a), (D, facets_b) = (_shuffled(mesh, rng) for mesh in (A, B))
    one = witness_pairs(A, B, X_AB, standoff, merge=False)
    two = _renumbered(witness_pairs(C, D, X_AB, standoff, merge=False), facets_a, facets_b)
    _assert_same_pairs(one, two, standoff=standoff, tolerance=_TOLERANCE)
    assert distance(C, D, X_AB).distance == pytest.approx(
        distance(A, B, X_AB).distance, abs=_TOLERANCE
    )


def _shuffled(mesh, rng):
    """The same surface numbered otherwise, each facet started at another corner or turned over."""
    facets, vertices = rng.permutation(len(mesh.faces)), rng.permutation(len(mesh.vertices))
    faces = np.argsort(vertices)[mesh.faces[facets]]
    faces = np.stack([np.roll(f, rng.integers(3))[:: rng.choice([-1, 1])] for f in faces])
    return CollisionMesh(mesh.vertices[vertices], faces), facets


@some
@given(shapes, shapes, rngs)
def test_subdivision(a, b, rng):
    """The same surface in four times as many facets is as far away."""
    A, B = _MESHES[a], _MESHES[b]
    C, D = (CollisionMesh(*mesh_shapes.subdivided(m.vertices, m.faces)) for m in (A, B))
    X_AB = random_pose(rng, 1.5)
    assert distance(C, D, X_AB).distance == pytest.approx(
        distance(A, B, X_AB).distance, abs=_TOLERANCE
    )


@some
@given(shapes, shapes, rngs)
def test_growing_standoff_only_adds(a, b, rng):
    """What is found within a small standoff is found, the same, within a large one."""
    A, B, X_AB = _MESHES[a], _MESHES[b], random_pose(rng, 1.5)
    small = witness_pairs(A, B, X_AB, 0.1, merge=False)
    large = witness_pairs(A, B, X_AB, 0.3, merge=False)
    inner = large.distance <= 0.1
    for name, column in small.columns().items():
        rows, kept = column, getattr(large, name)[inner]
        order = np.lexsort((small.facet_b, small.facet_a))
        kept_order = np.lexsort((large.facet_b[inner], large.facet_a[inner]))
        np.testing.assert_array_equal(rows[order], kept[kept_order], err_msg=name)


@some
@given(shapes, shapes, rngs, st.floats(0, 3))
def test_upper_bound_changes_no_answer_below_it(a, b, rng, upper_bound):
    A, B, X_AB = _MESHES[a], _MESHES[b], random_pose(rng, 2)
    free, bounded = distance(A, B, X_AB), distance(A, B, X_AB, upper_bound=upper_bound)
    if free.distance < upper_bound:
        assert bounded.distance == free.distance
        np.testing.assert_allclose(bounded.p_ACa - bounded.p_ACb, free.p_ACa - free.p_ACb)
    elif free.distance > upper_bound:
        assert bounded.distance == np.inf


@some
@given(shapes, shapes, rngs)
def test_the_three_queries_agree(a, b, rng):
    """Distance is the least of the witness pairs; a crossing is a pair at distance 0."""
    A, B, X_AB = _MESHES[a], _MESHES[b], random_pose(rng, 1.0)
    closest = distance(A, B, X_AB)
    found = witness_pairs(A, B, X_AB, closest.distance + 1e-6, merge=False)
    assert closest.distance == found.distance.min()
    at = (found.facet_a == closest.facet_a) & (found.facet_b == closest.facet_b)
    assert found.distance[at] == [closest.distance]
    if intersects(A, B, X_AB):
        assert closest.distance <= _TOUCHING
    else:
        assert closest.distance > 0
    if closest.distance == 0:
        assert np.linalg.norm(closest.p_ACa - closest.p_ACb) < 3 * _TOLERANCE


@some
@given(shapes, shapes, rngs, rngs)
def test_distance_is_lipschitz_in_the_pose(a, b, rng, other):
    """A jump of the distance where none of the bodies has jumped."""
    A, B, X_AB = _MESHES[a], _MESHES[b], random_pose(rng, 1.5)
    step = 10.0 ** other.uniform(-9, -1)
    moved = pose(X_AB[:3, :3], tuple(X_AB[:3, 3] + step * random_rotation(other)[0]))
    change = abs(distance(A, B, moved).distance - distance(A, B, X_AB).distance)
    assert change <= step + 3 * _TOLERANCE
