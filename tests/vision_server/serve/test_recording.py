"""What a vision server leaves in the run folder, and takes up again."""

import time
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from bridge.client import Client
from bridge.errors import ServerError
from bridge.messages import Settings
from bridge.start_messages import CauseTold, EstimateTold
from bridge.vision_messages import VisionCaptureResult
from geometry.camera import Camera
from geometry.drawn_wireframes import WIREFRAMES, Wireframes
from geometry.model import load_model
from geometry.pose import Pose
from geometry.wireframe import visible_runs
from image_server.replay import Replay
from image_server.simulator.simulator import Simulator
from stack.read import load_stack, recorded_frames
from stack.write import write_png
from tests.vision_server.serve.running import SETTINGS, Running, asked


def test_saved_frames_can_be_replayed_and_restored(vision: Client, images: Running, tmp_path: Path) -> None:
    asked(vision, "start", image_server=images.endpoint, out=str(tmp_path))
    for number, level in enumerate((3, 6), start=1):
        asked(vision, "capture", image=f"i{number}", settings={**SETTINGS, "lights": [level] * 3})
    before = asked(vision, "estimate", images=["i1", "i2"])
    arguments = {"image_server": images.endpoint, "out": str(tmp_path)}
    asked(vision, "start", image_server=images.endpoint)  # ends the session and writes what is left
    asked(vision, "restore", **arguments, images=["i1", "i2"], discarded=["i3"])
    after = asked(vision, "estimate", images=["i1", "i2"])
    assert after["pose"] == before["pose"]
    with pytest.raises(ServerError, match="i3"):
        asked(vision, "capture", image="i3", settings=SETTINGS)
    with pytest.raises(ServerError, match="i7"):
        asked(vision, "restore", **arguments, images=["i7"])
    stack = load_stack(tmp_path / "images")
    replay = Replay(stack, 0)
    assert replay.describe().lights[0].levels == 8


def test_a_capture_that_is_answered_is_on_the_disk(
    vision: Client, images: Running, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def slow(*args: Any) -> None:
        time.sleep(0.5)
        write_png(*args)

    monkeypatch.setattr("vision_server.serve.recorder.write_png", slow)
    asked(vision, "start", image_server=images.endpoint, out=str(tmp_path))
    asked(vision, "capture", image="i1", settings=SETTINGS)
    assert set(recorded_frames(tmp_path / "images")) == {"i1"}
    assert (tmp_path / "images" / "i1.png").is_file()


def test_a_capture_whose_frame_cannot_be_written_is_an_error(
    vision: Client, images: Running, tmp_path: Path
) -> None:
    asked(vision, "start", image_server=images.endpoint, out=str(tmp_path))
    (tmp_path / "images" / "i1.png").mkdir()
    with pytest.raises(ServerError, match="Cannot write"):
        asked(vision, "capture", image="i1", settings=SETTINGS)


def test_a_restored_session_measures_where_the_best_pose_is(
    vision: Client, images: Running, tmp_path: Path
) -> None:
    arguments = {"image_server": images.endpoint, "out": str(tmp_path)}
    asked(vision, "start", **arguments)
    asked(vision, "capture", image="i1", settings=SETTINGS)
    fix = asked(vision, "estimate", images=["i1"])
    keys = (
        "pose", "covariance", "rms_px", "uncertainty", "supported_fraction", "score", "ambiguity",
    )  # fmt: skip
    told = [{"estimate": {key: fix[key] for key in keys}}, {"parameters": {"seed_pose": "best"}}]
    asked(vision, "restore", **arguments, images=["i1"], told=told)
    assert {key: asked(vision, "best")[key] for key in keys} == {key: fix[key] for key in keys}
    assert asked(vision, "parameters")["seed_pose"] == fix["pose"]
    asked(vision, "restore", **arguments, images=["i1"], told=told[:1])
    assert asked(vision, "parameters")["seed_pose"] != fix["pose"]


def test_a_restored_session_holds_images_against_what_was_foreseen_and_knows_what_has_happened(
    vision: Client, images: Running, simulator: Simulator, tmp_path: Path
) -> None:
    arguments = {"image_server": images.endpoint, "out": str(tmp_path)}
    asked(vision, "start", **arguments)
    for image in ("i1", "i2"):
        asked(vision, "capture", image=image, settings=SETTINGS)
    fix = asked(vision, "estimate", images=["i1", "i2"])
    keys = EstimateTold.__struct_fields__
    told: list[dict[str, Any]] = [{"estimate": {key: fix[key] for key in keys}}, {"predicted": True}]
    pixels = simulator.capture(msgspec.convert(SETTINGS, Settings)).pixels
    shifted = np.roll(pixels, (5, 6), (0, 1))

    def restored(*more: dict[str, Any]) -> VisionCaptureResult:
        asked(vision, "restore", **arguments, images=["i1", "i2"], told=[*told, *more])
        answer, _ = vision.request("add", {"image": "i3", "settings": SETTINGS}, arrays=[shifted])
        return msgspec.convert(answer, VisionCaptureResult)

    moved = restored()
    assert moved.surprise == CauseTold(cause="target_moved", since="i3")
    again = restored({"happened": {"cause": "target_moved", "since": "i2"}})
    assert again.surprise is None  # nothing was foreseen since
    assert asked(vision, "best")["pose"] is None
    with pytest.raises(ServerError, match="no light torch"):
        restored({"happened": {"cause": "light_dead", "lights": ["torch"]}})


def test_a_restored_session_remembers_discarded_images_as_the_first_did(
    vision: Client, images: Running, tmp_path: Path
) -> None:
    arguments = {"image_server": images.endpoint, "out": str(tmp_path)}
    asked(vision, "start", **arguments)
    for image in ("i1", "i2", "i3"):
        asked(vision, "capture", image=image, settings=SETTINGS)
    told = [{"predicted": True}, {"discarded": "i2"}, {"happened": {"cause": "sun_changed", "since": "i2"}}]
    asked(vision, "restore", **arguments, images=["i1", "i3"], discarded=["i2"], told=told)
    assert asked(vision, "discard", image="i3")["images"] == ["i1"]
    with pytest.raises(ServerError, match="i2 is taken"):
        asked(vision, "capture", image="i2", settings=SETTINGS)
    with pytest.raises(ServerError, match="since i9"):
        asked(vision, "restore", **arguments, told=[{"happened": {"cause": "sun_changed", "since": "i9"}}])


def test_what_is_seen_of_the_model_is_written_with_each_pose(
    vision: Client, images: Running, simulator: Simulator, tmp_path: Path
) -> None:
    asked(vision, "start", image_server=images.endpoint, out=str(tmp_path))
    for image in ("i1", "i2"):
        asked(vision, "capture", image=image, settings=SETTINGS)
    poses = [asked(vision, "estimate", images=names)["pose"] for names in (["i1"], ["i1"], ["i1", "i2"])]
    asked(vision, "end")
    lines = (tmp_path / "images" / WIREFRAMES).read_bytes().splitlines()
    assert [msgspec.json.decode(line)["pose"] for line in lines] == [
        poses[0],
        poses[2],
    ]  # once for each question
    describe = simulator.describe()
    assert describe.camera is not None and describe.target is not None
    camera = Camera.from_dict(msgspec.to_builtins(describe.camera))
    runs = visible_runs(load_model(Path(describe.target.model)), camera, Pose.from_dict(poses[2]))
    told = Wireframes(lines).at(Pose.from_dict(poses[2]))
    assert told is not None and [one.line for one in told] == [run.line for run in runs]
    for one, run in zip(told, runs, strict=True):
        assert np.allclose(one.points, run.points, atol=0.006)
