"""Classification of a plant's positions, and of the motions between them, as a C-space."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant

from contact_toolkit import (
    Classification,
    CSpaceGeometry,
    CSpaceModel,
    MotionClassification,
    classify,
    classify_motions,
)
from systems.plant.geometry_import import GeometryImporter
from systems.plant.names import BodyNames
from systems.plant.pairs import choose_geometry_pairs

Floats = NDArray[np.float64]


class PlantCSpace:
    """The C-space of a finalized plant: its collision geometries, and positions q to classify.

    Parameters
    ----------
    plant, scene_graph
        The plant, finalized, and the SceneGraph it is registered with.
    pairs
        Pairs of body names to keep apart; by default all geometries that SceneGraph does not filter
        (it filters bodies joined by a joint).
    tessellation_tolerance
        How far facets may lie inside a curved surface, relative to its radius.

    Raises
    ------
    ValueError
        For names that are unknown, ambiguous, or of bodies that cannot touch.
    MeshError
        For a geometry that cannot be read.

    Examples
    --------
    >>> import numpy as np
    >>> from contact_toolkit import CSpaceClass
    >>> from pydrake.multibody.parsing import Parser
    >>> from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
    >>> from pydrake.systems.framework import DiagramBuilder
    >>> from systems import PlantCSpace
    >>> MODEL = '''<mujoco model="fall"><worldbody><geom type="plane" size="1 1 1"/>
    ...   <body name="ball" pos="0 0 0.05"><freejoint/><geom size="0.05"/></body>
    ... </worldbody></mujoco>'''
    >>> builder = DiagramBuilder()
    >>> plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.002)
    >>> _ = Parser(plant).AddModelsFromString(MODEL, "xml")
    >>> plant.Finalize()
    >>> cspace = PlantCSpace(plant, scene_graph)
    >>> q = np.array([[1, 0, 0, 0, 0, 0, z] for z in (0.02, 0.06)])  # the ball in and above ground
    >>> [CSpaceClass(kind).name for kind in cspace.classify(q).kind]
    ['COLLIDING', 'FREE']
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        scene_graph: SceneGraph,
        pairs: list[list[str]] | None = None,
        *,
        tessellation_tolerance: float = 0.005,
    ) -> None:
        names = BodyNames(plant)
        chosen = choose_geometry_pairs(plant, scene_graph.model_inspector(), names, pairs or [])
        importer = GeometryImporter(
            plant, scene_graph, tessellation_tolerance=tessellation_tolerance
        )
        imported = importer.read_all(chosen)
        rows = {geometry: row for row, geometry in enumerate(imported)}
        self._plant = plant
        self._context = plant.CreateDefaultContext()
        self._bodies = sorted({geometry.body for geometry in imported.values()}, key=int)
        self._model = CSpaceModel(
            [names.name_of(body) for body in self._bodies],
            [
                CSpaceGeometry(
                    f"{names.name_of(geometry.body)}/{geometry.name}",
                    names.name_of(geometry.body),
                    geometry.mesh,
                    geometry.X_BG,
                )
                for geometry in imported.values()
            ],
            [(rows[a], rows[b]) for a, b in chosen],
        )

    @property
    def model(self) -> CSpaceModel:
        """The bodies with their shapes, to which the results' `pair` refers."""
        return self._model

    def body_poses(self, q: ArrayLike) -> Floats:
        """Return the poses (n, nb, 4, 4) in World of the model's bodies at positions (n, nq)."""
        positions = self._as_positions(q)
        X_WB = np.empty((len(positions), len(self._bodies), 4, 4))
        bodies = [self._plant.get_body(body) for body in self._bodies]
        for row, at in zip(X_WB, positions, strict=True):
            self._plant.SetPositions(self._context, at)
            for k, body in enumerate(bodies):
                row[k] = self._plant.EvalBodyPoseInWorld(self._context, body).GetAsMatrix4()
        return X_WB

    def classify(
        self,
        q: ArrayLike,
        *,
        standoff: float = 0.0,
        upper_bound: float = np.inf,
        threads: int | None = None,
    ) -> Classification:
        """Classify positions (n, nq); see `contact_toolkit.classify`. Points are in World."""
        return classify(
            self._model,
            self.body_poses(q),
            standoff=standoff,
            upper_bound=upper_bound,
            threads=threads,
        )

    def classify_motions(
        self,
        q: ArrayLike,
        *,
        steps: int = 1,
        standoff: float = 0.0,
        tolerance: float | None = None,
        threads: int | None = None,
    ) -> MotionClassification:
        """Classify the motions between consecutive positions (n + 1, nq), each linear in q.

        Parameters
        ----------
        steps
            Parts into which each motion is cut. In each part bodies move straight and turn about a
            fixed axis, so bodies on jointed arms cut the corners of their arcs: by the arc's radius
            times angle²/8 of a part.
        standoff, tolerance, threads
            As for `contact_toolkit.classify_motions`.
        """
        if steps < 1:
            raise ValueError(f"steps must be at least 1, not {steps}")
        positions = self._as_positions(q)
        count = max(len(positions) - 1, 0)
        at = np.linspace(0, count, count * steps + 1)
        between = np.array([np.interp(at, np.arange(len(positions)), row) for row in positions.T])
        parts = classify_motions(
            self._model,
            self.body_poses(between.T),
            standoff=standoff,
            tolerance=tolerance,
            threads=threads,
        )
        worst = parts.distance.reshape(count, steps).argmin(axis=1) if count else np.empty(0, int)
        rows = worst + steps * np.arange(count)
        return MotionClassification(
            kind=parts.kind[rows],
            distance=parts.distance[rows],
            pair=parts.pair[rows],
            time=(worst + parts.time[rows]) / steps,
        )

    def _as_positions(self, q: ArrayLike) -> Floats:
        positions = np.asarray(q, dtype=np.float64)
        wanted = self._plant.num_positions()
        if positions.ndim != 2 or positions.shape[1] != wanted:
            raise ValueError(f"q must have shape (n, {wanted}), not {positions.shape}")
        return positions
