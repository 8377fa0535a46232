"""WitnessPairVisualizer: what a playback shows, frame by frame, read from the page itself."""

from __future__ import annotations

import base64
import re

import numpy as np
import pytest
import umsgpack
from pydrake.geometry import Box, Meshcat, MeshcatParams, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from systems import AddNonlinearDamperContact, ContactConfig, WitnessPairVisualizer

RATE = 64.0
FOLDER = "/drake/contact"


@pytest.fixture(scope="module")
def server() -> Meshcat:
    return Meshcat(MeshcatParams(host="localhost"))


@pytest.fixture
def meshcat(server: Meshcat) -> Meshcat:
    server.Delete()
    server.DeleteRecording()
    return server


class Drop:
    """A ball dropped from 50 mm onto a soft plate; it touches for several frames."""

    def __init__(self, meshcat: Meshcat, **settings) -> None:
        builder = DiagramBuilder()
        plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
        ball = plant.AddRigidBody("ball", SpatialInertia.SolidSphereWithMass(1.0, 0.05))
        slippery = CoulombFriction(0, 0)
        plant.RegisterCollisionGeometry(ball, RigidTransform(), Sphere(0.05), "ball", slippery)
        plant.RegisterCollisionGeometry(
            plant.world_body(), RigidTransform([0, 0, -0.05]), Box(1, 1, 0.1), "plate", slippery
        )
        plant.Finalize()
        config = ContactConfig(web="facet", standoff=0.03, k=100.0, alpha=0.0)
        self.contact = AddNonlinearDamperContact(builder, plant, scene_graph, config=config)
        WitnessPairVisualizer.AddToBuilder(
            builder, self.contact, meshcat, publish_period=1 / RATE, **settings
        )
        self.simulator = Simulator(builder.Build())
        context = self.simulator.get_mutable_context()
        plant.SetFreeBodyPose(
            plant.GetMyContextFromRoot(context), ball, RigidTransform([0.01, 0.02, 0.1])
        )
        self.contact_context = self.contact.GetMyContextFromRoot(context)

    def frames_in_contact(self, last: int) -> list[int]:
        """Advance frame by frame; return the frames in which springs are loaded."""
        found = []
        for frame in range(last + 1):
            self.simulator.AdvanceTo(frame / RATE)
            if len(self.contact.get_contacts_output_port().Eval(self.contact_context)):
                found.append(frame)
        return found


def page_messages(meshcat: Meshcat) -> list[dict]:
    """Return what the self-contained page sends its viewer."""
    chunks = re.findall(r"base64,([A-Za-z0-9+/=]{20,})", meshcat.StaticHtml())
    messages = []
    for chunk in chunks:
        try:
            message = umsgpack.unpackb(base64.b64decode(chunk))
        except (umsgpack.UnpackException, ValueError):
            continue  # the page's own pictures
        if isinstance(message, dict):
            messages.append(message)
    return messages


def shown(meshcat: Meshcat, frames: int) -> list[list[int]]:
    """Return the drawings visible at each frame of the playback."""
    (animation,) = [m for m in page_messages(meshcat) if m["type"] == "set_animation"]
    visible: list[list[int]] = [[] for _ in range(frames)]
    for track in animation["animations"]:
        if track["path"].startswith(FOLDER):
            (keys,) = [t["keys"] for t in track["clip"]["tracks"] if t["name"] == ".visible"]
            assert keys[0]["time"] == 0, "an object without a key at frame 0 shows too early"
            assert track["clip"]["fps"] == RATE
            states = {key["time"]: key["value"] for key in keys}
            state = False
            for frame in range(frames):
                state = states.get(frame, state)
                if state:
                    visible[frame].append(int(track["path"].removeprefix(FOLDER + "/")))
    return visible


def test_playback_shows_each_frame_its_own_web_and_none_without_contact(meshcat):
    meshcat.StartRecording(frames_per_second=RATE)
    drop = Drop(meshcat)
    in_contact = drop.frames_in_contact(40)
    meshcat.StopRecording()
    meshcat.PublishRecording()
    assert 2 <= len(in_contact) <= 20
    expected = [[frame] if frame in in_contact else [] for frame in range(41)]
    assert shown(meshcat, 41) == expected


def test_second_run_starts_with_a_clean_slate(meshcat):
    meshcat.StartRecording(frames_per_second=RATE)
    for _ in range(2):
        meshcat.DeleteRecording()
        drop = Drop(meshcat)
        first, *_ = drop.frames_in_contact(12)
    drop.simulator.get_mutable_context().SetTime(0)
    drop.simulator.Initialize()
    assert not meshcat.HasPath(f"contact/{first:06d}")


def test_without_recording_only_the_present_is_kept(meshcat):
    """Else a long live session fills the browser's memory."""
    drop = Drop(meshcat, record=False)
    assert drop.frames_in_contact(12)
    drawn = {m["path"] for m in page_messages(meshcat) if m.get("path", "").startswith(FOLDER)}
    assert drawn == {f"{FOLDER}/now/web"}


def test_lines_join_witness_points_and_arrows_are_as_long_as_forces(meshcat):
    scale = 1e-3
    drop = Drop(meshcat, record=False, force_scale=scale)
    assert drop.frames_in_contact(6)[-1] == 6
    contacts = drop.contact.get_contacts_output_port().Eval(drop.contact_context)
    web, arrows = (line_segments(meshcat, f"{FOLDER}/now/{name}") for name in ("web", "forces"))
    np.testing.assert_allclose(web[:, 0], contacts.p_FCa, rtol=1e-6)
    np.testing.assert_allclose(web[:, 1], contacts.p_FCb, rtol=1e-6)
    shafts = arrows[: len(contacts), 1] - arrows[: len(contacts), 0]
    np.testing.assert_allclose(
        np.linalg.norm(shafts, axis=1), scale * contacts.normal_force, atol=1e-6
    )
    # The first body of the pair is the plate: it is pushed down.
    assert (shafts[:, 2] < 0).all()
    assert len(arrows) == 3 * len(contacts)


def line_segments(meshcat: Meshcat, path: str) -> np.ndarray:
    """Return the segments (n, 2, 3) of an object on the page."""
    (message,) = [
        m for m in page_messages(meshcat) if m["type"] == "set_object" and m["path"] == path
    ]
    (geometry,) = message["object"]["geometries"]
    position = geometry["data"]["attributes"]["position"]["array"]
    return np.frombuffer(position.data, dtype=np.float32).reshape(-1, 2, 3)


def test_period_must_be_positive(meshcat):
    with pytest.raises(ValueError, match="publish_period"):
        WitnessPairVisualizer(meshcat, publish_period=0.0)
