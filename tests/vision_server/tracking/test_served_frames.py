"""Frames of an image server: all lights, one in turn, and what answers wrongly or no more."""

import tempfile
import threading
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from bridge.errors import BadInput, BridgeAbsent, DeviceError
from bridge.keys import client_keys, make_keys, server_keys
from bridge.serve import Server
from image_server.serve.server import ImageServer
from image_server.simulator.simulator import Simulator
from vision_server.serve.server import VisionServer
from vision_server.tracking.served_frames import ServedFrames
from vision_server.tracking.sources import Source

SIMULATOR = Simulator("cube", "nominal", 1)


@pytest.fixture(params=[ImageServer])
def endpoint(request: pytest.FixtureRequest) -> Iterator[str]:
    with tempfile.TemporaryDirectory(prefix="t") as folder:
        service = ImageServer(SIMULATOR) if request.param is ImageServer else VisionServer()
        server = Server(service, f"ipc://{folder}/s")
        thread = threading.Thread(target=server.run)
        thread.start()
        yield f"ipc://{folder}/s"
        server.stop()
        thread.join(60)


def test_frames_are_of_the_cameras_size_and_differ_under_other_lights(endpoint: str) -> None:
    camera = SIMULATOR.camera
    shown = {}
    for switch in (False, True):
        frames = list(islice(Source([endpoint], switch=switch), 4))
        assert {frame.pixels.shape for frame in frames} == {(camera.height, camera.width)}
        times = [frame.time_s for frame in frames if frame.time_s is not None]
        assert len(times) == 4
        assert times == sorted(times)
        greys = [frame.pixels.astype(float) for frame in frames]
        shown[switch] = np.abs(greys[1] - greys[0]).mean(), np.abs(greys[3] - greys[0]).mean()
    assert shown[True][0] > 3.0 * shown[False][0]
    assert shown[True][0] > 2.0 * shown[True][1]  # the fourth frame has the first one's light


@pytest.mark.parametrize("endpoint", [VisionServer], indirect=True)
def test_another_server_is_refused(endpoint: str) -> None:
    with pytest.raises(BadInput, match="is no image server"):
        ServedFrames(endpoint)


def test_lights_of_files_cannot_be_switched() -> None:
    with pytest.raises(BadInput, match="Only an image server's lights"):
        Source(["some.mp4"], switch=True)


def test_a_server_that_is_not_there_is_not_waited_for_long(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vision_server.tracking.served_frames.ABSENT_S", 0.5)
    with pytest.raises(BridgeAbsent, match="nobody"):
        ServedFrames(f"ipc://{tmp_path}/nobody")


def test_a_server_that_dies_is_an_error_and_said_soon(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vision_server.tracking.served_frames.ABSENT_S", 0.5)
    with tempfile.TemporaryDirectory(prefix="t") as folder:
        server = Server(ImageServer(SIMULATOR), f"ipc://{folder}/s")
        thread = threading.Thread(target=server.run)
        thread.start()
        frames = iter(Source([f"ipc://{folder}/s"]))
        next(frames)
        server.stop()
        thread.join(60)
        with pytest.raises(DeviceError, match="ends after 1 frames: Nobody has listened"):
            next(frames)


def test_a_server_with_keys_is_asked_with_keys(tmp_path: Path) -> None:
    make_keys(tmp_path / "keys")
    with tempfile.TemporaryDirectory(prefix="t") as folder:
        curve = server_keys(tmp_path / "keys", "image_server")
        server = Server(ImageServer(SIMULATOR), f"ipc://{folder}/s", curve=curve)
        thread = threading.Thread(target=server.run)
        thread.start()
        keys = client_keys(tmp_path / "keys", "vision_server", "image_server")
        assert len(list(islice(Source([f"ipc://{folder}/s"], curve=keys), 1))) == 1
        server.stop()
        thread.join(60)
