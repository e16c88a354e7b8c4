"""The examples of docs/tracking.md and docs/protocol.md against a vision server on a real socket."""

import re
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bridge.client import Client
from bridge.errors import BadInput, BridgeAbsent, ServerError
from bridge.keys import make_keys, server_keys
from bridge.mocks import MockVisionServer
from bridge.serve import Server
from geometry.model import TARGETS, load_model
from geometry.pose import Pose
from tests.vision_server.synthetic import CAMERA, linear_picture, photographed
from vision_server.client import Vision
from vision_server.serve.server import VisionServer

MODEL = load_model(TARGETS / "cube.cao")
GREYS = (0.3, 0.7, 0.2, 0.9, 0.5, 0.8)
FIRST = Pose(np.array([0.5, 0.7, 0.1]), np.array([0.01, 0.0, 5.0 * MODEL.diameter]))
STEP = np.array([0.0, 0.002, 0.003]) * MODEL.diameter


@pytest.fixture
def endpoint() -> Iterator[str]:
    with tempfile.TemporaryDirectory(prefix="t") as folder:
        server = Server(VisionServer(), f"ipc://{folder}/vision")
        thread = threading.Thread(target=server.run)
        thread.start()
        yield f"ipc://{folder}/vision"
        server.stop()
        thread.join(60)


def frames(count: int) -> tuple[list[Pose], list[Any]]:
    poses = [Pose(FIRST.rotation_vector, FIRST.translation + k * STEP) for k in range(count)]
    greys = np.resize(GREYS, len(MODEL.faces))
    return poses, [
        photographed(linear_picture(MODEL, CAMERA, pose, greys), 0.8, seed=k) for k, pose in enumerate(poses)
    ]


def test_a_time_beyond_all_clocks_is_refused_by_its_name(endpoint: str) -> None:
    _, shown = frames(2)
    with Vision(endpoint, TARGETS / "cube.cao", CAMERA.to_dict(), FIRST.to_dict()) as vision:
        assert vision.track(shown[0], time_s=1.7e18)["frame"] == 0  # ns since 1970
        with pytest.raises(ServerError, match="time_s") as refused:
            vision.track(shown[1], time_s=1e300)
        assert refused.value.code == "bad_arguments"
        assert vision.track(shown[1], time_s=1.7e18 + 3e7)["frame"] == 1


def test_the_example_of_the_docs_follows_a_target_and_judges_its_pose(endpoint: str, root: Path) -> None:
    text = (root / "docs" / "tracking.md").read_text()
    (example,) = (code for code in re.findall(r"```python\n(.*?)```", text, re.S) if "Vision(" in code)
    assert example.index("    verdict") > 0
    poses, shown = frames(4)
    names: dict[str, Any] = {"camera": CAMERA.to_dict(), "seed_pose": FIRST.to_dict(), "frames": shown}
    code = example.replace("ipc:///tmp/vision", endpoint).replace(
        "targets/cube.cao", str(TARGETS / "cube.cao")
    )
    exec(code, names)
    told, verdict = names["told"], names["verdict"]
    assert told["frame"] == 3
    assert told["state"] == "sure"
    assert Pose.from_dict(told["pose"]).error_to(poses[-1]).within(0.3, 0.003)
    assert verdict["state"] == "ok"
    assert verdict["probability"] > 0.8


def test_the_example_of_the_protocol_finds_a_pose(endpoint: str, root: Path) -> None:
    text = (root / "docs" / "protocol.md").read_text()
    (example,) = (code for code in re.findall(r"```python\n(.*?)```", text, re.S) if "Vision(" in code)
    greys = np.resize(GREYS, len(MODEL.faces))
    picture = linear_picture(MODEL, CAMERA, FIRST, greys)
    images = [photographed(exposure * picture, 0.8, seed=k) for k, exposure in enumerate((1.0, 0.25))]
    near = Pose(FIRST.rotation_vector + np.array([0.0, 0.1, 0.0]), FIRST.translation)
    names: dict[str, Any] = {"camera": CAMERA.to_dict(), "seed_pose": near.to_dict()}
    names |= {"images": images, "exposures": (1.0, 0.25)}
    code = example.replace("ipc:///tmp/vision", endpoint).replace(
        "targets/cube.cao", str(TARGETS / "cube.cao")
    )
    exec(code, names)
    assert Pose.from_dict(names["estimate"]["pose"]).error_to(FIRST).within(0.2, 0.002)
    assert names["estimate"]["score"] > 0.9


def test_images_do_not_stay_and_each_has_an_exposure(endpoint: str) -> None:
    _, (frame,) = frames(1)
    with Vision(endpoint, TARGETS / "cube.cao", CAMERA.to_dict(), FIRST.to_dict()) as vision:
        first = vision.estimate(frame)
        assert vision.estimate(frame)["pose"] == first["pose"]
        with pytest.raises(BadInput, match="1 images and 2 exposures"):
            vision.estimate(frame, exposures=(1.0, 2.0))
        with pytest.raises(ServerError, match="6"):
            vision.estimate(frame, np.zeros((6, 8), np.uint8))
        assert vision.estimate(frame)["pose"] == first["pose"]


def test_a_wrong_pose_is_not_ok_and_a_frame_of_another_size_is_refused(endpoint: str) -> None:
    _, (frame,) = frames(1)
    wrong = Pose(FIRST.rotation_vector + np.array([0.0, 0.12, 0.0]), FIRST.translation)
    with Vision(endpoint, TARGETS / "cube.cao", CAMERA.to_dict(), FIRST.to_dict()) as vision:
        verdict = vision.check(wrong.to_dict(), frame)
        assert verdict["state"] != "ok"
        assert verdict["better"] is not None
        assert 5.0 < verdict["difference"]["rotation_deg"] < 9.0
        with pytest.raises(ServerError, match="Frame 0 has 8x6 px"):
            vision.track(np.zeros((6, 8), np.uint8))
        assert vision.track(frame)["state"] == "sure"


def test_without_a_seed_pose_the_target_is_looked_for_everywhere() -> None:
    with MockVisionServer() as mock, Vision(mock.endpoint, TARGETS / "cube.cao", CAMERA.to_dict()):
        (args,) = mock.requests_of("start")
    assert args["first_sight"] is True
    assert args["seed_pose"] is None


def test_a_server_that_dies_is_said_once_and_soon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vision_server.client.ABSENT_S", 0.5)
    _, (frame,) = frames(1)
    with tempfile.TemporaryDirectory(prefix="t") as folder:
        server = Server(VisionServer(), f"ipc://{folder}/vision")
        thread = threading.Thread(target=server.run)
        thread.start()
        with (
            pytest.raises(BridgeAbsent) as caught,
            Vision(f"ipc://{folder}/vision", TARGETS / "cube.cao", CAMERA.to_dict()) as vision,
        ):
            server.stop()
            thread.join(60)
            vision.check(FIRST.to_dict(), frame)
    assert caught.value.__context__ is None or not isinstance(caught.value.__context__, BridgeAbsent)


def test_with_keys_a_server_that_has_keys_is_reached(tmp_path: Path) -> None:
    make_keys(tmp_path / "keys")
    with tempfile.TemporaryDirectory(prefix="t") as folder:
        curve = server_keys(tmp_path / "keys", "vision_server")
        server = Server(VisionServer(), f"ipc://{folder}/vision", curve=curve)
        thread = threading.Thread(target=server.run)
        thread.start()
        place = f"ipc://{folder}/vision"
        with Vision(place, TARGETS / "cube.cao", CAMERA.to_dict(), keys=tmp_path / "keys"):
            pass
        server.stop()
        thread.join(60)


def test_of_a_lost_frame_there_is_no_pose_to_check(endpoint: str) -> None:
    _, (frame,) = frames(1)
    with (
        Vision(endpoint, TARGETS / "cube.cao", CAMERA.to_dict()) as vision,
        pytest.raises(BadInput, match="None is no pose"),
    ):
        vision.check(None, frame)


@pytest.mark.parametrize("pose", [np.eye(4), "seed.toml", [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]])
def test_what_is_no_mapping_is_no_pose(pose: Any) -> None:
    with MockVisionServer() as mock, Vision(mock.endpoint, "m.cao", CAMERA.to_dict()) as vision:
        with pytest.raises(BadInput, match=r"a mapping, not a \w+\. Give rotation_vector"):
            Vision(mock.endpoint, "m.cao", CAMERA.to_dict(), pose)
        with pytest.raises(BadInput, match=r"a mapping, not a \w+\. Give rotation_vector"):
            vision.check(pose, np.zeros((480, 640), np.uint8))


@pytest.mark.parametrize(
    ("image", "said"),
    [
        (None, "None is no image. cv2.imread gives it"),
        ("photo.png", "an array .*, not of <U9"),
        (np.zeros((480, 640), np.int16), "an array .*, not of int16"),
    ],
)
def test_what_is_no_array_of_greys_is_no_image(image: Any, said: str) -> None:
    """It was said that arrays of objects cannot be sent."""
    with MockVisionServer() as mock, Vision(mock.endpoint, "m.cao", CAMERA.to_dict()) as vision:
        with pytest.raises(BadInput, match=said):
            vision.track(image)
        with pytest.raises(BadInput, match=said):
            vision.estimate(image)


def test_a_session_that_has_ended_says_so(endpoint: str) -> None:
    with Vision(endpoint, TARGETS / "cube.cao", CAMERA.to_dict()) as vision:
        pass
    with pytest.raises(BadInput, match="has been closed"):
        vision.track(np.zeros((480, 640), np.uint8))
    with pytest.raises(BadInput, match="has been closed"), vision:
        pass


def test_a_model_that_is_not_there_is_told_with_the_folder_that_was_looked_in(endpoint: str) -> None:
    with pytest.raises(ServerError, match=re.escape(f"Cannot read {Path.cwd() / 'none.cao'}:")):
        Vision(endpoint, "none.cao", CAMERA.to_dict())


def test_a_start_without_a_model_does_not_blame_an_image_server(endpoint: str) -> None:
    with Client(endpoint, 20.0) as client, pytest.raises(ServerError, match="No model is given"):
        client.request("start", {})
