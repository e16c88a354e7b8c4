"""Frames of an image server: all lights, one in turn, and what answers wrongly or no more."""

import tempfile
import threading
from collections.abc import Iterator
from itertools import islice

import numpy as np
import pytest

from bridge.errors import BadInput
from bridge.messages import LightDescription
from bridge.serve import Server
from image_server.serve.server import ImageServer
from image_server.simulator.simulator import Simulator
from vision_server.serve.server import VisionServer
from vision_server.tracking.served_frames import ServedFrames, levels
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


def test_lights_are_on_in_turn() -> None:
    lights = tuple(LightDescription(name, 8) for name in "abc")
    assert levels(lights, None) == (7, 7, 7)
    assert [levels(lights, k) for k in range(4)] == [(7, 0, 0), (0, 7, 0), (0, 0, 7), (7, 0, 0)]


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
