"""A vision server and a simulated image server on real sockets."""

import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from bridge.client import Client
from image_server.serve.server import ImageServer
from image_server.simulator.simulator import Simulator
from tests.vision_server.serve.running import Running
from vision_server.serve.server import VisionServer


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
