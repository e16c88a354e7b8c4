"""The crowd of `tests.bridge.hostile` in small; its 10^6 messages are a command of their own."""

import pytest

from image_server.serve.server import ImageServer
from image_server.simulator.simulator import Simulator
from vision_server.serve.server import VisionServer

from .hostile import BACK_MB, COMMANDS, attack
from .hostile_requests import IMAGE_REQUESTS, VISION_REQUESTS

MESSAGES = {"vision": 1500, "image": 1500, "mock-vision": 500, "mock-image": 500}
"""To each; the mock ones have the serving loop of the others, and little else."""
WAIT_S = 50.0
"""Of a client that behaves: no reply of its is lost. How long it waits at rest, the command says."""


@pytest.mark.slow
@pytest.mark.parametrize("kind", COMMANDS)
def test_a_hostile_crowd_leaves_a_server_as_it_was(kind: str) -> None:
    told = attack(kind, MESSAGES[kind], seed=7, first=MESSAGES[kind])
    assert told["serving"]
    assert told["messages"] >= MESSAGES[kind] - 3
    assert told["internal"] == {}
    assert told["tracebacks"] == 0
    assert told["longest_wait_s"] < WAIT_S
    assert told["memory_mb"]["after"] - told["memory_mb"]["before"] < BACK_MB


def test_every_operation_is_asked_for() -> None:
    camera = Simulator()
    for server, requests in ((VisionServer(), VISION_REQUESTS), (ImageServer(camera), IMAGE_REQUESTS)):
        assert requests.keys() >= server.operations.keys()
