"""Frames that a client gives, in place of an image server."""

from pathlib import Path
from typing import Any

import cv2
import msgspec
import numpy as np
import pytest

from bridge.client import Client
from bridge.errors import ServerError
from bridge.messages import Settings
from bridge.vision_messages import VisionCaptureResult
from geometry.pose import Pose
from image_server.simulator.simulator import Simulator
from stack.read import recorded_frames
from tests.vision_server.serve.running import SETTINGS, Running, asked


def started_with(simulator: Simulator) -> dict[str, Any]:
    """What a session on the simulator's target starts with: model, camera and seed pose."""
    described = simulator.describe()
    assert described.target is not None and described.camera is not None
    target = described.target
    return msgspec.to_builtins(  # type: ignore[no-any-return]
        {"model": target.model, "camera": described.camera, "seed_pose": target.seed_pose}
    )


def test_frames_can_be_given_as_arrays(
    vision: Client, images: Running, simulator: Simulator, tmp_path: Path
) -> None:
    values = started_with(simulator)
    pixels = simulator.capture(msgspec.convert(SETTINGS, Settings)).pixels
    asked(vision, "start", **values, out=str(tmp_path))
    told, _ = vision.request("add", {"image": "a", "settings": SETTINGS}, arrays=[pixels])
    assert msgspec.convert(told, VisionCaptureResult).moved is None
    pose = asked(vision, "estimate", images=["a"])["pose"]
    assert Pose.from_dict(pose).error_to(simulator.true_pose).within(1.0, 0.01)
    assert recorded_frames(tmp_path / "images")["a"].settings().shutter_s == pytest.approx(1 / 60)
    for arrays, said in (
        ([], "one array"),
        ([pixels, pixels], "one array"),
        ([pixels.astype(np.float32)], "one array"),
        ([np.zeros((4, 4, 3), np.uint8)], "one array"),
        ([np.zeros((4, 4), np.uint8)], "640"),
    ):
        with pytest.raises(ServerError, match=said):
            vision.request("add", {"image": "b", "settings": SETTINGS}, arrays=arrays)
    with pytest.raises(ServerError, match="taken by another image"):
        vision.request("add", {"image": "a", "settings": SETTINGS}, arrays=[pixels])
    for image, shift in (("same", 0), ("moved", 12)):
        rolled = np.ascontiguousarray(np.roll(pixels, (shift, -shift), axis=(0, 1)))
        told, _ = vision.request("add", {"image": image, "settings": SETTINGS}, arrays=[rolled])
        moved = told["moved"]
        assert (moved is not None) == (shift != 0)
    assert np.allclose(moved["shift_px"], (-12, 12), atol=1.5)
    with pytest.raises(ServerError, match="no image server"):
        asked(vision, "capture", image="c", settings=SETTINGS)
    with pytest.raises(ServerError, match="takes none"):
        vision.request("best", arrays=[pixels])
    with pytest.raises(ServerError, match="Both camera and camera_file"):
        asked(vision, "start", **values, camera_file="x.toml")


def test_what_a_request_gives_wrongly_is_its_own(vision: Client, simulator: Simulator) -> None:
    values = started_with(simulator)
    with pytest.raises(ServerError, match="Argument camera: camera distortion must be") as caught:
        asked(vision, "start", **{**values, "camera": {**values["camera"], "distortion": [0.0] * 6}})
    assert "image server" not in str(caught.value)
    with pytest.raises(ServerError, match=r"Invalid enum value 'ft'.*There are cm, in, m, mm"):
        asked(vision, "start", **values, unit="ft")
    with pytest.raises(ServerError, match=r"unknown field `modle`.*Did you mean model"):
        asked(vision, "start", modle="cube.cao")


def test_without_an_image_server_other_exposures_are_foreseen(vision: Client, simulator: Simulator) -> None:
    pixels = simulator.capture(msgspec.convert(SETTINGS, Settings)).pixels
    asked(vision, "start", **started_with(simulator))
    dark = {**SETTINGS, "lights": []}
    vision.request("add", {"image": "a", "settings": dark}, arrays=[pixels])
    assert asked(vision, "estimate", images=["a"])["pose"] is not None
    told = asked(vision, "predict", settings=[dark, {**dark, "shutter_s": 1.0}])["gains"]
    assert told[0]["bits"] > told[1]["bits"]  # where all is saturated
    with pytest.raises(ServerError, match=r"3 light levels, and 0 lights are described.*lights = \[\], in"):
        asked(vision, "predict", settings=[SETTINGS])
    vision.request("add", {"image": "b", "settings": SETTINGS}, arrays=[pixels])
    with pytest.raises(ServerError, match="0 lights are described"):
        asked(vision, "predict", settings=[dark])


def test_frames_of_more_bits_keep_them_on_the_way_through(
    vision: Client, images: Running, simulator: Simulator, tmp_path: Path
) -> None:
    values = started_with(simulator)
    values["camera"]["bits"] = 12
    pixels = simulator.capture(msgspec.convert(SETTINGS, Settings)).pixels.astype(np.uint16)
    deep = 1000 + 4 * pixels  # of 4095: less than a third of the contrast
    asked(vision, "start", **values, out=str(tmp_path))
    vision.request("add", {"image": "a", "settings": SETTINGS}, arrays=[deep])
    found = asked(vision, "estimate", images=["a"])
    assert Pose.from_dict(found["pose"]).error_to(simulator.true_pose).within(1.0, 0.01)
    saved = cv2.imread(str(tmp_path / "images" / "a.png"), cv2.IMREAD_UNCHANGED)
    assert saved is not None and saved.dtype == np.uint16
    np.testing.assert_array_equal(saved, deep)
    with pytest.raises(ServerError, match="more than 12 bits"):
        vision.request("add", {"image": "b", "settings": SETTINGS}, arrays=[16 * deep])
    asked(vision, "restore", **values, out=str(tmp_path), images=["a"])
    assert asked(vision, "estimate", images=["a"])["pose"] == found["pose"]
