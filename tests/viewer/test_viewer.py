"""The Drake-free viewer: what it serves, to whom, and that a browser draws it."""

import re
from pathlib import Path

import mesh_shapes
import numpy as np
import pytest
from playback_page import playback_page
from poses import pose

from contact_toolkit import CollisionMesh, ConvexPieces, witness_pairs
from contact_toolkit.viewer.viewer import Viewer


@pytest.fixture(scope="module")
def viewer():
    with Viewer() as viewer:
        yield viewer


def test_serves_the_loopback_interface_only(viewer):
    """A laptop at a conference that shows its meshes to everyone."""
    port = int(re.search(r":(\d+)/", viewer.url).group(1))
    listening = [
        line.split()[1]
        for table in ("/proc/net/tcp", "/proc/net/tcp6")
        for line in Path(table).read_text().splitlines()[1:]
        if line.split()[3] == "0A" and line.split()[1].endswith(f":{port:04X}")
    ]
    assert listening == [f"0100007F:{port:04X}"]


def test_shows_shapes_pairs_boxes_and_sweeps(viewer, tmp_path):
    """Something asked for that never reaches the page."""
    A, B = CollisionMesh(*mesh_shapes.cube()), CollisionMesh(*mesh_shapes.ball(2))
    X_AB = pose(p=(0, 0, 2.02))
    viewer.show("A", A)
    viewer.show("B", B, X_AB)
    viewer.show_witness_pairs("web", witness_pairs(A, B, X_AB, 0.6))
    viewer.show_hierarchy("boxes", B, 1, X_AB)
    viewer.show_sweep("sweep", A, np.eye(4), pose(p=(2.0, 0, 0)), steps=3)
    viewer.show("pieces", ConvexPieces([A.vertices, A.vertices + 2]))
    viewer.move("A", pose(p=(0.1, 0, 0)))
    viewer.remove("pieces")
    page = viewer.static_html()
    assert "LineSegments" in page
    scene = tmp_path / "scene.html"
    scene.write_text(page)
    assert scene.stat().st_size > 500_000  # meshcat's own code is in it: no server needed


def test_bad_arguments_are_refused(viewer):
    """A scene that silently shows something else."""
    mesh = CollisionMesh(*mesh_shapes.cube())
    with pytest.raises(ValueError, match="level must be from 0"):
        viewer.show_hierarchy("boxes", mesh, 99)
    with pytest.raises(ValueError, match="steps"):
        viewer.show_sweep("sweep", mesh, np.eye(4), np.eye(4), steps=1)
    with pytest.raises(ValueError, match="X_FS"):
        viewer.show("A", mesh, 2 * np.eye(4))
    with pytest.raises(ValueError, match="camera and target must be two points"):
        viewer.look((1, 2, 3), (1, 2, 3))


@pytest.mark.browser
def test_a_browser_draws_what_is_looked_at(tmp_path):
    """A part of millimetres that is a speck before the horizon, or out of the picture."""
    ball, X_FB = CollisionMesh(*mesh_shapes.ball(2, radius=0.005)), pose(p=(1, 2, 3))
    scene = tmp_path / "scene.html"
    with Viewer() as viewer, playback_page(640, 480) as page:
        viewer.show("ball", ball, X_FB, (1, 0, 0, 1))
        viewer.look((1.01, 1.98, 3.01), X_FB[:3, 3])
        scene.write_text(viewer.static_html())
        page.open(scene, "() => typeof viewer !== 'undefined'")
        r, g, b = np.moveaxis(page.pixels().astype(int), 2, 0)
        assert page.complaints == []
    rows, columns = np.nonzero(r > 2 * np.maximum(g, b))
    np.testing.assert_allclose([rows.mean(), columns.mean()], [240, 320], atol=10)
    # At 4.9 radii, in a field of view 75° high: a disc of a quarter of the height.
    assert np.ptp(rows) == pytest.approx(480 * 0.2085 / np.tan(np.radians(37.5)), rel=0.1)
