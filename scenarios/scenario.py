"""The scenario format: YAML in the style of Drake's hardware_sim, plus contact and acceptance.

Loaded by `scenarios.loading`; every field has a default, so a file says only what it changes.
"""

# No `from __future__ import annotations`: the loader reads the annotations as types.
import dataclasses
import math

import numpy as np
from pydrake.multibody.parsing import ModelDirective
from pydrake.multibody.plant import MultibodyPlantConfig
from pydrake.systems.analysis import SimulatorConfig

from scenarios.errors import ScenarioError
from systems import ContactConfig


@dataclasses.dataclass
class Part:
    """A body made by one of our own generators, at `package://parts/NAME.sdf`.

    Attributes
    ----------
    generator, parameters
        A function of `scenarios.parts` and its arguments.
    density
        [kg/m³]; mass and inertia are those of the faceted solid.
    rgba
        Colour, red, green, blue and opacity from 0 to 1.
    """

    generator: str = ""
    parameters: dict[str, float] = dataclasses.field(default_factory=dict)
    density: float = 1000.0
    rgba: list[float] = dataclasses.field(default_factory=lambda: [0.7, 0.7, 0.7, 1.0])


@dataclasses.dataclass
class Visualization:
    """What the playback shows.

    Attributes
    ----------
    frame_rate
        Recorded frames a simulated second [1/s].
    web
        Whether to draw the proximity edges, the lines between witness points.
    camera, target
        Where the camera stands and what it looks at, (3,) in the world [m].
    """

    frame_rate: float = 32.0
    web: bool = True
    camera: np.ndarray = dataclasses.field(default_factory=lambda: np.array([0.5, -0.5, 0.4]))
    target: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros(3))


@dataclasses.dataclass
class Limit:
    """Bounds on one measured figure; those left out do not apply.

    Attributes
    ----------
    near, within
        The expected value and the largest deviation from it.
    at_least, at_most
        One-sided bounds.
    """

    near: float | None = None
    within: float | None = None
    at_least: float | None = None
    at_most: float | None = None

    def check(self, name: str) -> None:
        """Raise ScenarioError if the bounds do not make sense."""
        if (self.near is None) != (self.within is None):
            raise ScenarioError(f"{name} needs both near and within")
        if not str(self):
            raise ScenarioError(f"{name} bounds nothing")

    def holds(self, value: float) -> bool:
        """Whether a measured value meets every bound given; NaN meets none."""
        return not math.isnan(value) and all(
            (
                self.near is None or self.within is None or abs(value - self.near) <= self.within,
                self.at_least is None or value >= self.at_least,
                self.at_most is None or value <= self.at_most,
            )
        )

    def __str__(self) -> str:
        bounds = []
        if self.near is not None:
            bounds.append(f"{self.near:g} ± {self.within:g}")
        if self.at_least is not None:
            bounds.append(f"≥ {self.at_least:g}")
        if self.at_most is not None:
            bounds.append(f"≤ {self.at_most:g}")
        return ", ".join(bounds)


@dataclasses.dataclass
class Acceptance:
    """How a run is judged.

    Attributes
    ----------
    measure
        A function of `scenarios.measures` that turns a finished run into named figures.
    body
        The body it looks at.
    window
        The last part of the run that counts as the end state [s].
    limits
        Bounds on some of the figures; the run passes if all hold.
    """

    measure: str = ""
    body: str = ""
    window: float = 0.5
    limits: dict[str, Limit] = dataclasses.field(default_factory=dict)


@dataclasses.dataclass
class Scenario:
    """One experiment, from the models to its verdict.

    Attributes
    ----------
    description
        One line for `contact-toolkit list`.
    random_seed
        Of the initial state, where a model declares distributions.
    simulation_duration
        [s]
    simulator_config, plant_config, directives
        Drake's own; `time_step: 0` and runge_kutta3 unless said otherwise. Directives reach the
        generated parts as `package://parts/NAME.sdf`.
    initial_position
        Model instance name to joint name to positions, over the models' defaults.
    parts
        Bodies to generate, by name.
    contact
        Pairs and law, see `systems.ContactConfig`.
    record_period
        Time between two rows of the time series [s].
    visualization, acceptance
        See there.
    """

    description: str = ""
    random_seed: int = 0
    simulation_duration: float = 1.0
    simulator_config: SimulatorConfig = dataclasses.field(
        default_factory=lambda: SimulatorConfig(integration_scheme="runge_kutta3", accuracy=1e-4)
    )
    plant_config: MultibodyPlantConfig = dataclasses.field(
        default_factory=lambda: MultibodyPlantConfig(time_step=0.0)
    )
    parts: dict[str, Part] = dataclasses.field(default_factory=dict)
    directives: list[ModelDirective] = dataclasses.field(default_factory=list)
    initial_position: dict[str, dict[str, np.ndarray]] = dataclasses.field(default_factory=dict)
    contact: ContactConfig = dataclasses.field(default_factory=ContactConfig)
    record_period: float = 0.005
    visualization: Visualization = dataclasses.field(default_factory=Visualization)
    acceptance: Acceptance = dataclasses.field(default_factory=Acceptance)

    def check(self) -> None:
        """Raise ScenarioError for values no run can have; models and contact check their own."""
        if not self.directives:
            raise ScenarioError("directives are empty: there is no model to simulate")
        for name, value in {
            "simulation_duration": self.simulation_duration,
            "record_period": self.record_period,
            "visualization.frame_rate": self.visualization.frame_rate,
            "acceptance.window": self.acceptance.window,
            **{f"parts.{name}.density": part.density for name, part in self.parts.items()},
        }.items():
            if not (math.isfinite(value) and value > 0.0):
                raise ScenarioError(f"{name} must be positive, not {value}")
        for name, vector in {
            "camera": self.visualization.camera,
            "target": self.visualization.target,
        }.items():
            if np.shape(vector) != (3,):
                raise ScenarioError(f"visualization.{name} must be three coordinates [m]")
        for name, part in self.parts.items():
            if len(part.rgba) != 4 or not all(0.0 <= channel <= 1.0 for channel in part.rgba):
                raise ScenarioError(f"parts.{name}.rgba must be four numbers from 0 to 1")
        for name, limit in self.acceptance.limits.items():
            limit.check(f"acceptance.limits.{name}")
