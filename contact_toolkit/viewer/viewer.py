"""A viewer for queries without a simulator: meshes, witness lines, hierarchies, swept volumes."""

from __future__ import annotations

import subprocess
import sys
import warnings
from itertools import islice
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from contact_toolkit.query.arguments import as_pose
from contact_toolkit.query.witness import WitnessPairs
from contact_toolkit.shapes.convex_pieces import ConvexPieces, Shape
from contact_toolkit.shapes.mesh import CollisionMesh, Floats, Ints

Rgba = tuple[float, float, float, float]

# The twelve edges of a box, between corners numbered by the bits x + 2 y + 4 z.
_BOX_EDGES = [
    (0, 1), (2, 3), (4, 5), (6, 7), (0, 2), (1, 3), (4, 6), (5, 7), (0, 4), (1, 5), (2, 6), (3, 7),
]  # fmt: skip


class Viewer:
    """Shows shapes and query results in the browser, on the `meshcat` package.

    A server process of its own serves the loopback interface only, until `close` or the end of a
    `with` block. Names are paths like "A" or "A/boxes"; showing something under a name again
    replaces it.

    Attributes
    ----------
    url
        Address to open in a browser of this machine.

    Raises
    ------
    RuntimeError
        If the server does not start.

    Examples
    --------
    >>> from contact_toolkit import CollisionMesh
    >>> from contact_toolkit.shapes.primitives import box
    >>> from contact_toolkit.viewer import Viewer
    >>> with Viewer() as viewer:  # doctest: +ELLIPSIS
    ...     viewer.show("cube", CollisionMesh(*box([0.1, 0.1, 0.1])))
    ...     print(viewer.url)
    http://127.0.0.1:...
    """

    def __init__(self) -> None:
        self._server = subprocess.Popen(
            [sys.executable, "-u", "-m", "contact_toolkit.viewer.server"],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,  # Ctrl-C in the notebook does not end it
        )
        assert self._server.stdout is not None
        urls = dict(line.strip().split("=", 1) for line in islice(self._server.stdout, 2))
        if len(urls) < 2:
            _, errors = self._server.communicate()
            raise RuntimeError(f"the viewer's server did not start:\n{errors}")
        meshcat = _meshcat()
        # Without its constructor, which prints, and leaves a socket open.
        window = meshcat.visualizer.ViewerWindow.__new__(meshcat.visualizer.ViewerWindow)
        window.server_proc, window.zmq_url = None, urls["zmq_url"]
        window.connect_zmq()
        self.url = urls["web_url"]
        self._root = meshcat.Visualizer.view_into(window, meshcat.path.Path(()))
        self._scene = self._root["meshcat"]
        self._geometry = meshcat.geometry

    def show(
        self,
        name: str,
        shape: Shape,
        X_FS: ArrayLike | None = None,
        rgba: Rgba = (0.6, 0.65, 0.7, 1.0),
    ) -> None:
        """Show a shape S at a pose in the common frame F."""
        self._scene[name].delete()
        if isinstance(shape, ConvexPieces):
            surfaces = [shape.hull(i) for i in range(len(shape))]
        else:
            surfaces = [(shape.vertices, shape.faces)]
        for index, (vertices, faces) in enumerate(surfaces):
            self._add_surface(f"{name}/{index}", vertices, faces, rgba)
        self.move(name, np.eye(4) if X_FS is None else X_FS)

    def move(self, name: str, X_FS: ArrayLike) -> None:
        """Move what is shown under a name to another pose in F."""
        self._scene[name].set_transform(as_pose(X_FS, "X_FS"))

    def show_witness_pairs(
        self,
        name: str,
        pairs: WitnessPairs,
        X_FA: ArrayLike | None = None,
        rgba: Rgba = (0.85, 0.1, 0.2, 1.0),
    ) -> None:
        """Show a line between the two points of each row."""
        points = np.stack([pairs.p_ACa, pairs.p_ACb], axis=1).reshape(-1, 3)
        self._add_lines(name, points, rgba)
        self.move(name, np.eye(4) if X_FA is None else X_FA)

    def show_hierarchy(
        self,
        name: str,
        mesh: CollisionMesh,
        level: int,
        X_FM: ArrayLike | None = None,
        rgba: Rgba = (0.1, 0.4, 0.8, 1.0),
    ) -> None:
        """Show the boxes of a mesh's bounding volume hierarchy at a level, 0 below the root."""
        depth = int(mesh.hierarchy["depth"])
        if not 0 <= level < depth:
            raise ValueError(f"level must be from 0 to {depth - 1} for this mesh, not {level}")
        corners = mesh.hierarchy_boxes(level)  # (n, 8, 3)
        self._add_lines(name, corners[:, _BOX_EDGES].reshape(-1, 3), rgba)
        self.move(name, np.eye(4) if X_FM is None else X_FM)

    def show_sweep(
        self,
        name: str,
        shape: Shape,
        X_FS_start: ArrayLike,
        X_FS_end: ArrayLike,
        *,
        steps: int = 12,
        rgba: Rgba = (0.9, 0.6, 0.1, 0.15),
    ) -> None:
        """Show the volume a shape sweeps over, by faint copies along the queries' own motion."""
        if steps < 2:
            raise ValueError(f"steps must be at least 2, not {steps}")
        start, end = as_pose(X_FS_start, "X_FS_start"), as_pose(X_FS_end, "X_FS_end")
        turn = Rotation.from_matrix(start[:3, :3].T @ end[:3, :3]).as_rotvec()
        self._scene[name].delete()
        for index, fraction in enumerate(np.linspace(0.0, 1.0, steps)):
            X_FS = (1 - fraction) * start + fraction * end
            X_FS[:3, :3] = start[:3, :3] @ Rotation.from_rotvec(fraction * turn).as_matrix()
            self.show(f"{name}/{index}", shape, X_FS, rgba)

    def look(self, camera: ArrayLike, target: ArrayLike = (0.0, 0.0, 0.0)) -> None:
        """Look from a point (3,) at another, in F [m]; hide the grid and axes, which are metres."""
        away = np.asarray(camera, np.float64) - np.asarray(target, np.float64)
        if away.shape != (3,) or not (np.isfinite(away).all() and away.any()):
            raise ValueError(
                f"camera and target must be two points (3,), not {camera!r}, {target!r}"
            )
        for scenery in ("Grid", "Axes"):
            self._root[scenery].set_property("visible", False)
        X_VF = np.eye(4)  # meshcat's camera always looks at its own origin
        X_VF[:3, 3] = -np.asarray(target, np.float64)
        self._scene.set_transform(X_VF)
        x, y, z = away.tolist()
        self._root["Cameras/default/rotated/<object>"].set_property("position", [x, z, -y])  # y up

    def remove(self, name: str) -> None:
        """Remove what is shown under a name."""
        self._scene[name].delete()

    def static_html(self) -> str:
        """Return the scene as one self-contained page, for notebooks and reports."""
        return str(self._scene.static_html())

    def close(self) -> None:
        """End the server."""
        self._scene.window.zmq_socket.close(linger=0)
        self._server.kill()
        self._server.communicate()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _add_surface(self, name: str, vertices: Floats, faces: Ints, rgba: Rgba) -> None:
        g = self._geometry
        material = g.MeshLambertMaterial(
            color=_hex(rgba), opacity=rgba[3], transparent=rgba[3] < 1, flatShading=True
        )
        self._scene[name].set_object(g.TriangularMeshGeometry(vertices, faces), material)

    def _add_lines(self, name: str, points: Floats, rgba: Rgba) -> None:
        g = self._geometry
        positions = g.PointsGeometry(np.ascontiguousarray(points.T, dtype=np.float32))
        self._scene[name].set_object(
            g.LineSegments(positions, g.LineBasicMaterial(color=_hex(rgba)))
        )


def _hex(rgba: Rgba) -> int:
    r, g, b = (round(255 * channel) for channel in rgba[:3])
    return r << 16 | g << 8 | b


def _meshcat() -> Any:
    with warnings.catch_warnings():
        # The package is frozen (2021) and imports what its dependencies have since deprecated.
        warnings.simplefilter("ignore", DeprecationWarning)
        import meshcat  # noqa: PLC0415  brings a web server along, which most users never need
        import meshcat.geometry  # noqa: PLC0415
        import meshcat.visualizer  # noqa: PLC0415
    return meshcat
