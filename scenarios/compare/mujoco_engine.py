"""A scenario under MuJoCo, where it is installed (extra `compare`): parts in convex pieces."""

from __future__ import annotations

import tempfile
import time
import xml.etree.ElementTree as ET
from collections.abc import Iterable
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from contact_toolkit import CollisionMesh, decompose
from scenarios.compare.outcome import Outcome, record_of
from scenarios.compare.placements import body_names, placements
from scenarios.format.errors import ScenarioError
from scenarios.format.models import surface_of
from scenarios.format.scenario import Scenario
from scenarios.parts import write_obj
from scenarios.simulation.drives import Course

_CONVEX = 1e-3  # a part that fills its convex hull to this share is convex
_STEP = 0.001  # [s] where the scenario has a continuous plant

Floats = NDArray[np.float64]


def mujoco_engine(scenario: Scenario) -> Outcome:
    """Run it; raises ScenarioError where it has models that are no parts of the scenario."""
    import mujoco

    _require_parts_only(scenario)
    outcome = Outcome("MuJoCo")
    with tempfile.TemporaryDirectory() as folder:
        model = mujoco.MjModel.from_xml_string(_model_xml(scenario, Path(folder)))
    data = mujoco.MjData(model)
    _set_velocities(mujoco, model, data, scenario)
    drives = [
        (Course(drive), int(model.joint(name.rpartition("::")[2]).dofadr[0]),
         int(model.joint(name.rpartition("::")[2]).qposadr[0]))
        for name, drive in scenario.drives.items()
    ]  # fmt: skip
    called = body_names(placements(scenario))
    moving = [name for name in called if model.body(name).dofnum[0] or _is_jointed(name, scenario)]
    every = max(1, round(scenario.record_period / model.opt.timestep))
    steps = round(scenario.simulation_duration / model.opt.timestep)
    mujoco.set_mju_user_warning(lambda _: None)  # else it writes a file where one stands
    blown_up = [getattr(mujoco.mjtWarning, f"mjWARN_BADQ{what}") for what in ("POS", "VEL", "ACC")]
    rows: list[tuple[float, list[Floats], list[Floats], float]] = []
    wall = 0.0
    for step in range(steps + 1):
        if step % every == 0:
            mujoco.mj_forward(model, data)
            rows.append(_look(mujoco, model, data, moving))
        started = time.perf_counter()
        for course, dof, position in drives:
            data.qfrc_applied[dof] = course.effort(data.time, data.qpos[position], data.qvel[dof])
        mujoco.mj_step(model, data)
        wall += time.perf_counter() - started
        if any(data.warning[warning].number for warning in blown_up):
            raise RuntimeError(f"blew up after {step * model.opt.timestep:g} s")
    outcome.wall_time = wall
    times = np.array([row[0] for row in rows])
    poses = {called[name]: np.stack([row[1][i] for row in rows]) for i, name in enumerate(moving)}
    velocities = {
        called[name]: np.stack([row[2][i] for row in rows]) for i, name in enumerate(moving)
    }
    masses = {called[name]: float(model.body(name).mass[0]) for name in moving}
    kinetic = np.array([row[3] for row in rows])
    outcome.poses = poses
    outcome.record = record_of(times, poses, velocities, masses, kinetic, scenario.gravity)
    outcome.judge(scenario)
    return outcome


def _is_jointed(name: str, scenario: Scenario) -> bool:
    return any(joint.child.partition("::")[0] == name for joint in scenario.joints.values())


def _look(
    mujoco: Any, model: Any, data: Any, moving: list[str]
) -> tuple[float, list[Floats], list[Floats], float]:
    poses, velocities = [], []
    for name in moving:
        body = model.body(name).id
        X = np.eye(4)
        X[:3, :3], X[:3, 3] = data.xmat[body].reshape(3, 3), data.xpos[body]
        V = np.zeros(6)
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, body, V, 0)
        poses.append(X)
        velocities.append(V)
    mujoco.mj_energyVel(model, data)
    return float(data.time), poses, velocities, float(data.energy[1])


def _set_velocities(mujoco: Any, model: Any, data: Any, scenario: Scenario) -> None:
    for name, joints in scenario.initial_velocity.items():
        for joint, values in joints.items():
            if joint in scenario.joints:
                data.qvel[model.joint(joint).dofadr[0]] = np.ravel(values)[0]
                continue
            w, v = np.split(np.asarray(values, np.float64), 2)
            start = int(model.body(name).dofadr[0])
            R = np.empty(9)
            mujoco.mju_quat2Mat(R, data.qpos[model.body(name).jntadr[0] + 3 :][:4].copy())
            data.qvel[start : start + 3] = v
            data.qvel[start + 3 : start + 6] = R.reshape(3, 3).T @ w  # in the body's frame
    for name, joints in scenario.initial_position.items():
        for joint, values in joints.items():
            if joint not in scenario.joints:
                raise ScenarioError(f"MuJoCo: initial_position of {name}.{joint} is not translated")
            data.qpos[model.joint(joint).qposadr[0]] = np.ravel(values)[0]


def _model_xml(scenario: Scenario, folder: Path) -> str:
    root = ET.Element("mujoco")
    ET.SubElement(root, "compiler", meshdir=str(folder), angle="radian")
    step = scenario.plant_config.time_step or _STEP
    option = {"timestep": repr(step), "gravity": _text(scenario.gravity), "cone": "elliptic",
              "integrator": "implicitfast", "noslip_iterations": "0"}  # fmt: skip
    ET.SubElement(root, "option", option)
    assets, world = ET.SubElement(root, "asset"), ET.SubElement(root, "worldbody")
    placed = placements(scenario)
    called = body_names(placed)
    solids = {
        part: _add_meshes(scenario, part, assets, folder)
        for part in dict.fromkeys(placement.part for placement in placed.values())
    }
    bodies: dict[str, ET.Element] = {}
    for name in _parents_first(scenario, placed):
        joint = next(
            ((n, j) for n, j in scenario.joints.items() if j.child.partition("::")[0] == name), None
        )
        X_WB = placed[name].X_WB
        parent, position, quaternion = world, X_WB[:3, 3], _quaternion(X_WB)
        if joint is not None:
            above = joint[1].parent.partition("::")[0]
            parent = world if above == "world" else bodies[above]
            position, quaternion = np.array(joint[1].translation), np.array([1.0, 0, 0, 0])
        body = ET.SubElement(parent, "body", name=name, pos=_text(position), quat=_text(quaternion))
        bodies[name] = body
        if joint is not None:
            kind = {"prismatic": "slide", "revolute": "hinge"}[joint[1].kind]
            ET.SubElement(body, "joint", name=joint[0], type=kind, axis=_text(joint[1].axis),
                          damping=repr(joint[1].damping))  # fmt: skip
        elif not placed[name].fixed:
            ET.SubElement(body, "freejoint", name=f"{name}_free")
        _add_solid(body, *solids[placed[name].part], *_friction(scenario, called[name]))
    _add_pair_filter(scenario, root)
    return ET.tostring(root, encoding="unicode")


def _add_meshes(
    scenario: Scenario, part: str, assets: ET.Element, folder: Path
) -> tuple[trimesh.Trimesh, list[str]]:
    """Return a part as a solid with its density, and the names of the meshes of its pieces."""
    surface = surface_of(scenario.parts[part])
    solid = trimesh.Trimesh(*surface, process=False)
    mass, density = scenario.parts[part].mass, scenario.parts[part].density
    solid.density = mass / solid.volume if mass else density
    names = []
    for number, piece in enumerate(_convex_pieces(surface, solid)):
        path = write_obj(folder / f"{part}_{number}.obj", piece)
        ET.SubElement(assets, "mesh", name=path.stem, file=path.name)
        names.append(path.stem)
    return solid, names


def _add_solid(
    body: ET.Element, solid: trimesh.Trimesh, meshes: list[str], friction: float, priority: int
) -> None:
    inertia = np.asarray(solid.moment_inertia)
    full = [inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    ET.SubElement(body, "inertial", mass=repr(float(solid.mass)), pos=_text(solid.center_mass),
                  fullinertia=_text(full))  # fmt: skip
    rubs = f"{friction} 0.005 0.0001"  # sliding, and MuJoCo's defaults of the others
    for mesh in meshes:
        ET.SubElement(body, "geom", type="mesh", mesh=mesh, friction=rubs, condim="4",
                      priority=str(priority))  # fmt: skip


def _friction(scenario: Scenario, name: str) -> tuple[float, int]:
    """Return a body's coefficient and whether it decides over the other's.

    MuJoCo takes the larger of two bodies' coefficients unless one has priority.
    """
    contact = scenario.contact
    for override in contact.overrides:
        if override.bodies[:1] == [name] and override.friction.static is not None:
            return override.friction.static, 1
    return (0.5 if contact.friction.static is None else contact.friction.static), 0


def _convex_pieces(surface: tuple[Floats, Any], solid: trimesh.Trimesh) -> list[Any]:
    if solid.volume > (1.0 - _CONVEX) * solid.convex_hull.volume:
        return [surface]
    pieces = decompose(CollisionMesh(*surface))
    return [
        (hull.vertices, hull.faces.astype(np.int32))
        for hull in (trimesh.convex.convex_hull(points) for points in pieces.pieces)
    ]


def _add_pair_filter(scenario: Scenario, root: ET.Element) -> None:
    if not scenario.contact.pairs:
        return
    wanted = {frozenset(pair) for pair in scenario.contact.pairs}
    contact = ET.SubElement(root, "contact")
    for (a, a_called), (b, b_called) in combinations(body_names(placements(scenario)).items(), 2):
        if frozenset((a_called, b_called)) not in wanted:
            ET.SubElement(contact, "exclude", body1=a, body2=b)


def _require_parts_only(scenario: Scenario) -> None:
    for directive in scenario.directives:
        if directive.add_model is None and directive.add_weld is None:
            raise ScenarioError("MuJoCo: only add_model and add_weld are translated")
    models = [d.add_model for d in scenario.directives if d.add_model is not None]
    placed = placements(scenario)
    if others := [model.file for model in models if model.name not in placed]:
        raise ScenarioError(f"MuJoCo: {others[0]} is no part of the scenario")


def _parents_first(scenario: Scenario, placed: Iterable[str]) -> list[str]:
    parents = {
        joint.child.partition("::")[0]: joint.parent.partition("::")[0]
        for joint in scenario.joints.values()
    }

    def depth(name: str) -> int:
        above = parents.get(name, "world")
        return 0 if above == "world" else 1 + depth(above)

    return sorted(placed, key=depth)


def _quaternion(X: Floats) -> Floats:
    from scipy.spatial.transform import Rotation

    return np.roll(Rotation.from_matrix(X[:3, :3]).as_quat(), 1)


def _text(values: Any) -> str:
    return " ".join(repr(float(value)) for value in values)
