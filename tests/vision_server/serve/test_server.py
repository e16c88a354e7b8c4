"""The vision server on real sockets, with a replayed or simulated image server behind it."""

import shutil
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bridge.client import Client
from bridge.errors import ServerError
from bridge.serve import Server, Service
from geometry.pose import Pose
from image_server.replay import Replay
from image_server.serve.server import ImageServer
from image_server.simulator import Simulator
from stack.read import load_stack, recorded_frames
from stack.write import write_png
from vision_server.serve.server import VisionServer

SETTINGS: dict[str, Any] = {"lights": [5, 5, 5], "shutter_s": 1 / 60, "aperture": 4.0}


class Running:
    """A service in a thread of its own."""

    def __init__(self, service: Service, endpoint: str) -> None:
        self.endpoint = endpoint
        self._server = Server(service, endpoint)
        self._thread = threading.Thread(target=self._server.run)
        self._thread.start()

    def stop(self) -> None:
        self._server.stop()
        self._thread.join(20)


@pytest.fixture(scope="module")
def sockets() -> Iterator[Path]:
    folder = Path(tempfile.mkdtemp(prefix="v"))
    yield folder
    shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture(scope="module")
def simulator() -> Simulator:
    return Simulator("cube", "nominal", seed=4)


@pytest.fixture(scope="module")
def images(sockets: Path, simulator: Simulator) -> Iterator[Running]:
    running = Running(ImageServer(simulator), f"ipc://{sockets}/images")
    yield running
    running.stop()


@pytest.fixture
def vision(sockets: Path) -> Iterator[Client]:
    running = Running(VisionServer(), f"ipc://{sockets}/vision")
    with Client(running.endpoint, timeout_s=60) as client:
        yield client
    running.stop()


def asked(client: Client, op: str, **args: Any) -> dict[str, Any]:
    return client.request(op, args)[0]


def test_a_session_from_start_to_best(
    vision: Client, images: Running, simulator: Simulator, tmp_path: Path
) -> None:
    started = asked(vision, "start", image_server=images.endpoint, seed=3, out=str(tmp_path))
    assert started["model"] == {"name": "cube", "lines": 12, "faces": 6}
    assert [light["name"] for light in started["describe"]["lights"]] == ["left", "right", "top"]
    assert asked(vision, "best")["pose"] is None
    captured = asked(vision, "capture", image="i1", settings=SETTINGS)
    assert captured["verified"]
    assert captured["applied"]["lights"] == SETTINGS["lights"]
    statistics = captured["statistics"]
    assert 0 <= statistics["p05"] <= statistics["p50"] <= statistics["p95"] <= 1
    assert statistics["frame"]["dark_fraction"] > statistics["dark_fraction"]
    assert statistics["blur_px"] is None or statistics["blur_px"] < 2
    assert captured["seconds"]["capture"] > 0
    estimate = asked(vision, "estimate", images=["i1"])
    pose = Pose.from_dict(estimate["pose"])
    assert pose.error_to(simulator.true_pose).within(1.0, 0.01)
    assert np.array(estimate["covariance"]).shape == (6, 6)
    assert {line["image"] for line in estimate["lines"]} <= {"i1", None}
    assert asked(vision, "estimate", images=["i1"]) == estimate
    assert asked(vision, "best")["pose"] == estimate["pose"]
    assert asked(vision, "discard", image="i1")["images"] == []
    with pytest.raises(ServerError, match="i1"):
        asked(vision, "estimate", images=["i1"])
    with pytest.raises(ServerError, match="i1"):
        asked(vision, "capture", image="i1", settings=SETTINGS)


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


def test_parameters_are_checked_and_the_seed_pose_follows(vision: Client, images: Running) -> None:
    asked(vision, "start", image_server=images.endpoint)
    known = asked(vision, "parameters")
    assert {
        "matcher", "rotation_range_deg", "translation_range_px", "generations", "population",
        "edge_contrast_grey", "refinement_scale_px", "seed_pose",
    } <= set(known)  # fmt: skip
    assert asked(vision, "parameters", generations=20, matcher="genetic")["generations"] == 20
    for bad in (
        {"generation": 3}, {"generations": 0}, {"generations": 2.5}, {"matcher": "luck"},
        {"population": True},
        {"refinement_scale_px": 3.0}, {"seed_pose": "worst"}, {"seed_pose": {"best_at_range_m": -1}},
        {"seed_pose": {"rotation_vector": [0, 0, 0], "translation": [0, 0, -1]}},
    ):  # fmt: skip
        with pytest.raises(ServerError):
            asked(vision, "parameters", **bad)
    assert asked(vision, "parameters")["generations"] == 20
    with pytest.raises(ServerError, match="estimate"):
        asked(vision, "parameters", seed_pose="best")
    asked(vision, "capture", image="i1", settings=SETTINGS)
    seed = asked(vision, "parameters", seed_pose={"best_at_range_m": 0.5})["seed_pose"]
    assert float(np.linalg.norm(seed["translation"])) == pytest.approx(0.5)
    with pytest.raises(ServerError, match="i1"):
        asked(vision, "estimate", images=["i1"])
    asked(vision, "discard", image="i1")


def test_nothing_works_before_start_and_bad_starts_are_named(
    vision: Client, images: Running, tmp_path: Path
) -> None:
    for op, args in (("best", {}), ("estimate", {"images": ["i1"]}), ("discard", {"image": "i1"})):
        with pytest.raises(ServerError, match="start"):
            asked(vision, op, **args)
    with pytest.raises(ServerError, match=r"nowhere\.cao"):
        asked(vision, "start", image_server=images.endpoint, model=str(tmp_path / "nowhere.cao"))
    (tmp_path / "pose.toml").write_text(
        "[target.seed_pose]\nrotation_vector = [0, nan, 0]\ntranslation = [0, 0, 1]"
    )
    with pytest.raises(ServerError, match="finite"):
        asked(vision, "start", image_server=images.endpoint, seed_pose_file=str(tmp_path / "pose.toml"))
    (tmp_path / "file").write_text("")
    with pytest.raises(ServerError, match="file"):
        asked(vision, "start", image_server=images.endpoint, out=str(tmp_path / "file"))
    with pytest.raises(ServerError):
        asked(vision, "best")


def test_a_refused_capture_leaves_the_set_as_it_was(vision: Client, images: Running) -> None:
    asked(vision, "start", image_server=images.endpoint)
    with pytest.raises(ServerError):
        asked(vision, "capture", image="i1", settings={**SETTINGS, "lights": [99, 0, 0]})
    asked(vision, "capture", image="i1", settings=SETTINGS)
