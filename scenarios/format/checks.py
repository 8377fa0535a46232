"""Everything about a scenario that can be found wrong before its models are read."""

from __future__ import annotations

import dataclasses
import difflib
import itertools
import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from scenarios.format.choices import choices_at
from scenarios.format.errors import ScenarioError
from scenarios.format.joint import Drive, Joint
from scenarios.format.part import Part
from scenarios.format.scenario import Scenario

MOST_FRAMES = 20_000  # a recording of more is larger than a browser opens
MOST_ROWS = 5_000_000  # rows of the time series


def check(scenario: Scenario) -> None:
    """Raise ScenarioError naming the key for values no run can have; models check their own."""
    if not scenario.directives:
        raise ScenarioError("directives are empty: there is no model to simulate")
    _check_words(scenario)
    _check_positive(scenario)
    _check_counts(scenario)
    _check_vector("gravity", scenario.gravity)
    for name in ("camera", "target"):
        if np.size(getattr(scenario.visualization, name)):
            _check_vector(f"visualization.{name}", getattr(scenario.visualization, name))
    for name, part in scenario.parts.items():
        _check_part(f"parts.{name}", part)
    for name, joint in scenario.joints.items():
        _check_joint(f"joints.{name}", joint)
    for name, drive in scenario.drives.items():
        _check_drive(f"drives.{name}", drive)
    for name, limit in scenario.acceptance.limits.items():
        limit.check(f"acceptance.limits.{name}")


def _check_words(scenario: Scenario) -> None:
    for place, value in _words(scenario, ""):
        allowed = choices_at(place)
        if allowed and value not in allowed:
            near = difflib.get_close_matches(value, allowed, 1)
            hint = f"; did you mean '{near[0]}'?" if near else ""
            raise ScenarioError(f"{place} must be one of {', '.join(allowed)}, not '{value}'{hint}")


def _words(node: Any, place: str) -> Iterator[tuple[str, str]]:
    """Yield the place and value of every text in a tree of dataclasses, mappings and lists."""
    if isinstance(node, str):
        yield place, node
        return
    children: dict[Any, Any] = {}
    if dataclasses.is_dataclass(node):
        children = {field.name: getattr(node, field.name) for field in dataclasses.fields(node)}
    elif isinstance(node, dict):
        children = node
    elif isinstance(node, list):
        children = dict(enumerate(node))
    elif hasattr(node, "integration_scheme"):
        children = {"integration_scheme": node.integration_scheme}
    elif hasattr(node, "contact_model"):
        keys = ("contact_model", "discrete_contact_approximation")
        children = {key: getattr(node, key) for key in keys}
    for key, child in children.items():
        yield from _words(child, f"{place}.{key}" if place else str(key))


def _check_positive(scenario: Scenario) -> None:
    positive = {
        "simulation_duration": scenario.simulation_duration,
        "record_period": scenario.record_period,
        "visualization.frame_rate": scenario.visualization.frame_rate,
        "acceptance.window": scenario.acceptance.window,
        "simulator_config.max_step_size": scenario.simulator_config.max_step_size,
        "simulator_config.accuracy": scenario.simulator_config.accuracy,
    }
    for name, value in positive.items():
        if not (math.isfinite(value) and value > 0.0):
            raise ScenarioError(f"{name} must be positive, not {value}")
    not_negative = {
        "plant_config.time_step": scenario.plant_config.time_step,
        "visualization.force_scale": scenario.visualization.force_scale,
        "visualization.key_frame": scenario.visualization.key_frame or 0.0,
        "random_seed": scenario.random_seed,
        "simulator_config.target_realtime_rate": scenario.simulator_config.target_realtime_rate,
    }
    for name, value in not_negative.items():
        if not (math.isfinite(value) and value >= 0.0):
            raise ScenarioError(f"{name} must not be negative, as {value} is")
    if not 0 <= scenario.random_seed < 2**32:
        raise ScenarioError(f"random_seed must be below 2³², not {scenario.random_seed}")


def _check_counts(scenario: Scenario) -> None:
    duration = scenario.simulation_duration
    frames = duration * scenario.visualization.frame_rate
    if frames > MOST_FRAMES:
        raise ScenarioError(
            f"visualization.frame_rate of {scenario.visualization.frame_rate:g} 1/s makes "
            f"{frames:.0f} frames in {duration:g} s, more than {MOST_FRAMES}: no browser plays "
            f"that; choose at most {MOST_FRAMES / duration:.3g} 1/s"
        )
    rows = duration / scenario.record_period
    if rows > MOST_ROWS:
        raise ScenarioError(
            f"record_period of {scenario.record_period:g} s makes {rows:.0f} rows in "
            f"{duration:g} s, more than {MOST_ROWS}; choose at least {duration / MOST_ROWS:.2g} s"
        )


def _check_vector(name: str, vector: Any) -> None:
    if np.shape(vector) != (3,) or not np.isfinite(vector).all():
        raise ScenarioError(f"{name} must be three finite numbers, not {np.asarray(vector)}")


def _check_part(name: str, part: Part) -> None:
    if bool(part.generator) == bool(part.mesh):
        raise ScenarioError(f"{name} needs either a generator or a mesh")
    if part.mesh and part.parameters:
        raise ScenarioError(f"{name}.parameters belong to a generator, not to a mesh")
    for key, value in {"density": part.density, "scale": part.scale}.items():
        if not (math.isfinite(value) and value > 0.0):
            raise ScenarioError(f"{name}.{key} must be positive, not {value}")
    if not (math.isfinite(part.mass) and part.mass >= 0.0):
        raise ScenarioError(f"{name}.mass must not be negative, as {part.mass} is")
    if len(part.rgba) != 4 or not all(0.0 <= channel <= 1.0 for channel in part.rgba):
        raise ScenarioError(f"{name}.rgba must be four numbers from 0 to 1")


def _check_joint(name: str, joint: Joint) -> None:
    _check_vector(f"{name}.axis", joint.axis)
    _check_vector(f"{name}.translation", joint.translation)
    if not np.any(joint.axis):
        raise ScenarioError(f"{name}.axis must not be zero")
    if not joint.child:
        raise ScenarioError(f"{name}.child is missing: the frame or body that moves")
    if not joint.lower <= joint.upper:
        raise ScenarioError(f"{name}.lower must not be above upper")
    if not (math.isfinite(joint.damping) and joint.damping >= 0.0):
        raise ScenarioError(f"{name}.damping must not be negative, as {joint.damping} is")


def _check_drive(name: str, drive: Drive) -> None:
    corners = drive.schedule
    if any(len(corner) != 2 or not np.isfinite(corner).all() for corner in corners):
        raise ScenarioError(f"{name}.schedule must be pairs of a time [s] and a value")
    if any(b[0] <= a[0] for a, b in itertools.pairwise(corners)):
        raise ScenarioError(f"{name}.schedule: times must increase")
    if not corners and not drive.amplitude:
        raise ScenarioError(f"{name} needs a schedule or an amplitude")
    if drive.amplitude and not drive.frequency > 0.0:
        raise ScenarioError(f"{name}.frequency must be positive, not {drive.frequency}")
    if drive.follows == "position" and not (drive.stiffness > 0.0 or drive.damping > 0.0):
        raise ScenarioError(f"{name}.stiffness must be positive to follow a position")
