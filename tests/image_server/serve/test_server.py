"""The image server behind the protocol."""

import shutil
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from bridge.client import Client
from bridge.serve import Server
from image_server.serve.server import ImageServer
from image_server.simulator.scenario import load_scenario
from image_server.simulator.simulator import Simulator

SETTINGS = {"lights": [5, 5, 5], "shutter_s": 1 / 60, "aperture": 4.0}


@pytest.fixture
def sockets() -> Iterator[Path]:
    """A folder whose name is short enough for sockets."""
    folder = Path(tempfile.mkdtemp(prefix="i-"))
    yield folder
    shutil.rmtree(folder, ignore_errors=True)


def test_how_it_is_can_be_asked_while_an_image_is_taken(
    sockets: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    device = Simulator("cube", load_scenario("nominal"), 1)
    begun, may_end, capture = threading.Event(), threading.Event(), device.capture

    def slow(settings):  # type: ignore[no-untyped-def]
        begun.set()
        may_end.wait(120)
        return capture(settings)

    monkeypatch.setattr(device, "capture", slow)
    server = Server(ImageServer(device), f"ipc://{sockets}/s")
    serving = threading.Thread(target=server.run)
    serving.start()
    with Client(server.endpoint, timeout_s=120) as taking, Client(server.endpoint, timeout_s=60) as asking:
        waiting = threading.Thread(target=taking.request, args=("capture", {"settings": SETTINGS}))
        waiting.start()
        assert begun.wait(60)
        assert asking.request("health")[0]["captures"] == 0
        assert waiting.is_alive()
        may_end.set()
        waiting.join()
        assert asking.request("health")[0]["captures"] == 1
    server.stop()
    serving.join()
