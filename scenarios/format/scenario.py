"""The scenario format: YAML in the style of Drake's hardware_sim, plus contact and acceptance.

Loaded by `scenarios.format.loading`; every field has a default: a file says only what it changes.
"""

# No `from __future__ import annotations`: the loader reads the annotations as types.
import dataclasses

import numpy as np
from pydrake.multibody.parsing import ModelDirective
from pydrake.multibody.plant import MultibodyPlantConfig
from pydrake.systems.analysis import SimulatorConfig

from scenarios.format.acceptance import Acceptance, Limit
from scenarios.format.joint import Drive, Joint
from scenarios.format.part import Part
from systems import ContactConfig

__all__ = ["Acceptance", "Drive", "Joint", "Limit", "Part", "Scenario", "Visualization"]


@dataclasses.dataclass
class Visualization:
    """What the playback shows.

    Attributes
    ----------
    frame_rate
        Recorded frames a simulated second [1/s].
    web
        Whether to draw the proximity edges, the lines between witness points.
    arrows
        Whether to draw the forces: an arrow for the normal and one for the friction force.
    force_scale
        Length of the arrows [m/N]; 0 finds one from the scene's size and the weights in it.
    camera, target
        Where the camera stands and what it looks at, (3,) in the world [m]; empty looks at the
        moving bodies from a distance that fits their size.
    key_frame
        The moment [s] that `contact-toolkit gallery` draws; unless set, the end.
    """

    frame_rate: float = 32.0
    web: bool = True
    arrows: bool = True
    force_scale: float = 0.0
    camera: np.ndarray = dataclasses.field(default_factory=lambda: np.empty(0))
    target: np.ndarray = dataclasses.field(default_factory=lambda: np.empty(0))
    key_frame: float | None = None


@dataclasses.dataclass
class Scenario:
    """One experiment, from the models to its verdict.

    Attributes
    ----------
    description
        One line for `contact-toolkit list`.
    long
        Whether it takes more than half a minute; `list` says so, and `run --all` beforehand.
    cannot
        What other engines cannot do here, by engine, for `contact-toolkit compare`.
    random_seed
        Of the initial state, where a model declares distributions.
    simulation_duration
        [s]
    simulator_config, plant_config, directives
        Drake's own; `time_step: 0` and runge_kutta3 unless said otherwise. Directives reach the
        generated parts as `package://parts/NAME.sdf`; other paths are relative to the file.
    packages
        Further packages for `package://NAME/…`, name to folder: relative to the file, or within an
        installed Python package, as `python://MODULE/folder`.
    gravity
        (3,) in the world [m/s²].
    without_gravity
        Models that gravity does not act on, as robots compensate theirs.
    joints
        Joints between bodies beside those of the models, by name.
    drives
        What drives joints, by joint name, as `model::joint` where that is ambiguous.
    initial_position
        Model instance name to joint name to positions, over the models' defaults.
    initial_velocity
        The same for velocities; those of a free body are angular, then linear [rad/s, m/s].
    parts
        Bodies to generate, by name.
    contact
        Pairs and law, see `systems.ContactConfig`.
    swept_monitor
        What to do when bodies pass through each other within a step.
    record_period
        Time between two rows of the time series [s].
    visualization, acceptance
        See there.
    """

    description: str = ""
    long: bool = False
    cannot: dict[str, str] = dataclasses.field(default_factory=dict)
    random_seed: int = 0
    simulation_duration: float = 1.0
    simulator_config: SimulatorConfig = dataclasses.field(
        default_factory=lambda: SimulatorConfig(integration_scheme="runge_kutta3", accuracy=1e-4)
    )
    plant_config: MultibodyPlantConfig = dataclasses.field(
        default_factory=lambda: MultibodyPlantConfig(time_step=0.0)
    )
    parts: dict[str, Part] = dataclasses.field(default_factory=dict)
    packages: dict[str, str] = dataclasses.field(default_factory=dict)
    directives: list[ModelDirective] = dataclasses.field(default_factory=list)
    gravity: np.ndarray = dataclasses.field(default_factory=lambda: np.array([0.0, 0.0, -9.81]))
    without_gravity: list[str] = dataclasses.field(default_factory=list)
    joints: dict[str, Joint] = dataclasses.field(default_factory=dict)
    drives: dict[str, Drive] = dataclasses.field(default_factory=dict)
    initial_position: dict[str, dict[str, np.ndarray]] = dataclasses.field(default_factory=dict)
    initial_velocity: dict[str, dict[str, np.ndarray]] = dataclasses.field(default_factory=dict)
    contact: ContactConfig = dataclasses.field(default_factory=ContactConfig)
    swept_monitor: str = "off"
    record_period: float = 0.005
    visualization: Visualization = dataclasses.field(default_factory=Visualization)
    acceptance: Acceptance = dataclasses.field(default_factory=Acceptance)
