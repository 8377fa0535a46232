"""The generated parts: closed, wound outward, of the size and volume they claim."""

import manifold3d
import numpy as np
import pytest
import trimesh

from scenarios.parts import PARTS, make_part, write_obj
from scenarios.parts.fits import MORSE_HALF_ANGLE


def solid(name, **parameters):
    vertices, faces = make_part(name, parameters)
    return trimesh.Trimesh(vertices, faces, process=False)


def ngon(sections):
    """Area of a regular polygon as a share of its circumscribed circle's radius squared."""
    return sections / 2 * np.sin(2 * np.pi / sections)


def radii(vertices):
    return np.hypot(vertices[:, 0], vertices[:, 1])


def turned(mesh, angle, translation):
    mesh.apply_transform(trimesh.transformations.rotation_matrix(angle, [0, 0, 1]))
    mesh.apply_translation(translation)
    return mesh


def gap(mesh, other):
    """Least distance [m] of two solids, negated volume of what they share [m³] if they clash."""
    a, b = (
        manifold3d.Manifold(manifold3d.Mesh64(np.array(m.vertices), m.faces.astype(np.uint64)))
        for m in (mesh, other)
    )
    return a.min_gap(b, 0.01) or -(a ^ b).volume()


@pytest.mark.parametrize("name", PARTS)
def test_every_part_is_a_closed_outward_surface(name):
    vertices, faces = make_part(name)
    assert vertices.dtype == np.float64
    assert faces.dtype == np.int32
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume > 0.0
    assert mesh.area_faces.min() > 1e-12  # [m²]
    assert len(np.unique(faces)) == len(vertices)  # no vertex without a facet
    assert len(np.unique(vertices, axis=0)) == len(vertices)  # none twice


@pytest.mark.parametrize(
    ("name", "holes"),
    [
        ("doughnut", 1), ("truncated_cone", 0), ("box", 0), ("icosphere", 0), ("involute_gear", 1),
        ("bolt", 0), ("nut", 1), ("hole_plate", 1), ("taper_socket", 1), ("v_groove", 0),
        ("mug", 1), ("tracked_robot", 0), ("bowl_feeder", 0), ("collet", 1), ("spinning_top", 0),
        ("voussoir", 0), ("height_field", 0), ("stairs", 0), ("boulder_field", 0), ("rock", 0),
    ],
)  # fmt: skip
def test_parts_have_the_holes_they_should(name, holes):
    assert solid(name).euler_number == 2 - 2 * holes


@pytest.mark.parametrize(
    ("name", "volume"),
    [
        ("box", 0.1**3),
        ("truncated_cone", ngon(128) * 0.25 / 3 * (0.05**2 + 0.05 * 0.02 + 0.02**2)),
        ("rod", ngon(24) * 0.005**2 * 0.3),
        ("l_bracket", (0.06 * 0.01 + 0.07 * 0.01) * 0.03),
        ("v_groove", (0.06 * 0.05 - 0.03**2 * np.tan(np.deg2rad(15))) * 0.04),
        ("wedge", (0.03**2 - 0.005**2) * np.tan(np.deg2rad(15)) * 0.03),
        ("hole_plate", (0.06**2 - ngon(96) * 0.01**2) * 0.03),
        ("voussoir", 0.15 * (0.6**2 - 0.5**2) / 2 * np.sin(np.pi / 9)),
        ("stairs", 1.2 * (0.17 * 2.4 + 0.28 * 0.17 * 15)),
    ],
)
def test_volume_of_faceted_parts_is_exact(name, volume):
    assert solid(name).volume == pytest.approx(volume, rel=1e-12)


@pytest.mark.parametrize(
    ("name", "volume", "share"),
    [
        ("doughnut", 2 * np.pi**2 * 0.05 * 0.02**2, 0.01),
        ("icosphere", 4 / 3 * np.pi * 0.05**3, 0.02),
        ("capsule", np.pi * 0.004**2 * 0.02 + 4 / 3 * np.pi * 0.004**3, 0.02),
        ("peg", np.pi * (0.00995**2 * 0.049 + 0.001 * (0.00995**2 - 0.00995e-3 + 1e-6 / 3)), 0.01),
    ],
)
def test_faceted_parts_fall_short_of_the_smooth_solid(name, volume, share):
    assert (1 - share) * volume < solid(name).volume < volume


def test_rock_n_stack_has_the_published_facets():
    assert len(make_part("doughnut")[1]) == 2 * 64 * 32
    assert len(make_part("truncated_cone")[1]) == 2 * 128 * 40 + 2 * 128  # wall and two ends


@pytest.mark.parametrize("divisions", [1, 2, 5])
def test_box_faces_are_cut_as_often_as_asked(divisions):
    mesh = solid("box", divisions=divisions)
    assert mesh.faces.shape == (12 * divisions**2, 3)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(1e-3)


@pytest.mark.parametrize(("frequency", "facets"), [(1, 20), (7, 980), (71, 100_820)])
def test_icosphere_reaches_any_size_on_the_exact_sphere(frequency, facets):
    vertices, faces = make_part("icosphere", {"frequency": frequency})
    assert faces.shape == (facets, 3)
    np.testing.assert_allclose(np.linalg.norm(vertices, axis=1), 0.05, rtol=1e-14)


def test_bumpy_sphere_is_not_convex_and_keeps_its_bounds():
    mesh = solid("bumpy_sphere", frequency=24, amplitude=0.1)
    radius = np.linalg.norm(mesh.vertices, axis=1)
    assert not mesh.is_convex
    assert 0.045 <= radius.min() < 0.048
    assert 0.052 < radius.max() <= 0.055


def test_thread_has_the_iso_metric_diameters_lead_and_flanks():
    mesh = solid("bolt", allowance=0.0)
    middle = mesh.vertices[np.abs(mesh.vertices[:, 2] - 0.012) < 0.006]
    radius = radii(middle)
    assert 2 * radius.max() == pytest.approx(0.016)
    assert 2 * radius.min() == pytest.approx(0.016 - 1.25 * np.sqrt(0.75) * 0.002)
    # Along the crest's two edges the height advances one pitch a turn.
    crest = middle[radius > 0.008 - 1e-9]
    turn = np.arctan2(crest[:, 1], crest[:, 0]) / (2 * np.pi)
    offset = np.unique(np.round((crest[:, 2] / 0.002 - turn) % 1.0, 9))
    np.testing.assert_allclose(offset, [0.5 - 1 / 16, 0.5 + 1 / 16])
    # Flanks lean 30° from the plane across the axis (a facet's normal, to a percent).
    slope = np.abs(mesh.face_normals[np.abs(mesh.triangles_center[:, 2] - 0.012) < 0.006, 2])
    flanks = slope > 0.5
    assert flanks.sum() > 0.7 * len(slope)
    np.testing.assert_allclose(slope[flanks], np.cos(np.deg2rad(30)), rtol=0.01)


def test_nut_and_bolt_have_the_sizes_benchmarks_rely_on():
    assert len(make_part("nut")[1]) == pytest.approx(15_000, rel=0.05)
    assert len(make_part("bolt")[1]) == pytest.approx(25_000, rel=0.05)


@pytest.mark.parametrize("turn", [0.0, 0.3])
def test_nut_screwed_along_the_bolt_touches_nowhere(turn):
    bolt = solid("bolt", sections=36)
    nut = turned(solid("nut", sections=36), 2 * np.pi * turn, [0, 0, 0.002 * (6 + turn)])
    assert 2e-5 < gap(nut, bolt) < 1e-4
    turned(nut, np.pi / 2, [0, 0, 0])  # a quarter turn without the rise: the threads clash
    assert gap(nut, bolt) < 0.0


def test_gears_mesh_at_the_sum_of_their_pitch_radii():
    gear = solid("involute_gear", backlash=1e-4, rows=1)
    other = turned(solid("involute_gear", backlash=1e-4, rows=1), np.pi / 24, [0.048, 0, 0])
    assert 1e-5 < gap(gear, other) < 5e-5
    other.apply_translation([-2e-4, 0, 0])
    assert gap(gear, other) < 0.0


def test_taper_plug_fits_its_socket():
    socket = solid("taper_socket").vertices
    bore = socket[radii(socket) < 0.0095]
    np.testing.assert_allclose(radii(bore), 0.009 + bore[:, 2] * np.tan(MORSE_HALF_ANGLE))
    plug = solid("taper_plug").vertices[:-2]  # without the end faces' centres
    np.testing.assert_allclose(radii(plug), 0.009 + plug[:, 2] * np.tan(MORSE_HALF_ANGLE))


@pytest.mark.parametrize(
    ("name", "parameters", "complaint"),
    [
        ("torus", {}, "no part is called 'torus'"),
        ("doughnut", {"radius": 1.0}, "no parameter radius; it has: major_radius"),
        ("doughnut", {"minor_radius": 0.06}, "0 < minor_radius < major_radius"),
        ("doughnut", {"major_sections": 2}, "at least 3 sections"),
        ("doughnut", {"major_sections": 6.5}, "major_sections must be a whole number"),
        ("truncated_cone", {"height": "tall"}, "height must be a number"),
        ("truncated_cone", {"height": float("nan")}, "height must be finite"),
        ("truncated_cone", {"height": -1.0}, "must be positive"),
        ("box", {"divisions": 0}, "at least 1"),
        ("bolt", {"length": 0.003}, "too short"),
        ("nut", {"sections": 100}, "sections must be 6, 12"),
        ("involute_gear", {"pressure_angle": 0.8}, "come to a point"),
        ("taper_plug", {"length": 1.0}, "comes to a point"),
    ],
)
def test_impossible_parts_say_why(name, parameters, complaint):
    with pytest.raises(ValueError, match=complaint):
        make_part(name, parameters)


def test_obj_files_hold_every_bit(tmp_path):
    vertices, faces = make_part("bumpy_sphere", {"frequency": 3})
    mesh = trimesh.load(write_obj(tmp_path / "part.obj", (vertices, faces)), process=False)
    np.testing.assert_array_equal(mesh.vertices, vertices)
    np.testing.assert_array_equal(mesh.faces, faces)


def test_the_robot_is_not_convex_and_stands_clear_of_the_ground():
    """A hull as good as convex would test nothing that other contact cannot do."""
    robot = solid("tracked_robot")
    assert robot.volume < 0.7 * robot.convex_hull.volume
    middle = robot.vertices[np.abs(robot.vertices[:, 1]) < 0.1]
    assert middle[:, 2].min() > 0.05


def test_ground_of_one_seed_is_one_ground():
    """A run could not be repeated."""
    for name in ("height_field", "rock", "boulder_field"):
        first, again, other = (make_part(name, {"seed": seed})[0] for seed in (3, 3, 4))
        np.testing.assert_array_equal(first, again)
        assert first.shape != other.shape or np.any(first != other)


def test_a_slope_falls_towards_x_by_its_angle():
    """A hill would be steeper or flatter than its scenario says."""
    vertices, _ = make_part("height_field", {"slope": 0.3, "roughness": 0.0})
    top = vertices[vertices[:, 2] > vertices[:, 2].min()]
    np.testing.assert_allclose(top[:, 2], -np.tan(0.3) * top[:, 0], atol=1e-12)


def test_the_bowls_track_climbs_one_pitch_a_turn():
    """Parts would be fed along a track that is none."""
    vertices, _ = make_part("bowl_feeder")
    inner = vertices[np.isclose(np.hypot(vertices[:, 0], vertices[:, 1]), 0.10)]
    angle = np.unwrap(np.sort(np.arctan2(inner[:, 1], inner[:, 0])))
    inner = inner[inner[:, 2] > 1e-6]  # not where the track comes out of the floor
    assert len(angle) > 72
    for a, z in zip(np.arctan2(inner[:, 1], inner[:, 0]), inner[:, 2], strict=True):
        climbs = 0.03 * (a / (2 * np.pi) + np.arange(-1, 3))
        assert min(abs(z - c - d) for c in climbs for d in (-0.0035, -0.0005, 0.0)) < 1e-5
