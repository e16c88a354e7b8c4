"""Fixtures of the bridge's tests: the mocks, and a small service on a real socket."""

import shutil
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from bridge.errors import BadInput, DeviceError
from bridge.image_messages import ImageCaptureArgs
from bridge.messages import NoArgs
from bridge.mocks import mock_image_server, mock_vision_server
from bridge.serve import Reply, Server, Service
from bridge.vision_messages import ParametersArgs

__all__ = ["mock_image_server", "mock_vision_server"]


class Counter(Service):
    """A service that counts what it does."""

    name = "counter"

    def __init__(self) -> None:
        self.count = 0
        self.closed = 0
        self.released = threading.Event()
        self.operations = {
            "count": (NoArgs, self._count),
            "wait": (NoArgs, self._wait),
            "echo": (ParametersArgs, Reply),
            "capture": (ImageCaptureArgs, self._capture),
            "sort": (NoArgs, lambda _: Reply({}, [np.array(["text"])])),
            "refuse": (NoArgs, self._refuse),
            "fail": (NoArgs, self._fail),
            "jam": (NoArgs, self._jam),
            "not_finite": (NoArgs, lambda _: Reply({"a": [1.0, float("nan")]})),
            "numpy": (NoArgs, lambda _: Reply({"a": np.float32(0.5), "b": np.arange(3)})),
            "huge": (NoArgs, lambda _: Reply({"a": "x" * 2_000_000})),
        }

    def close(self) -> None:
        self.closed += 1

    def _count(self, _: NoArgs) -> Reply:
        self.count += 1
        self.emit("sun_changed", {"count": self.count})
        return Reply({"count": self.count})

    def _wait(self, _: NoArgs) -> Reply:
        self.count += 1
        self.released.wait(120)
        return Reply({"count": self.count})

    def _capture(self, args: ImageCaptureArgs) -> Reply:
        image = np.arange(12, dtype=np.uint8).reshape(3, 4)
        return Reply({"settings": args.settings}, [image, image.T.astype(np.float32)])

    def _refuse(self, _: NoArgs) -> Reply:
        raise BadInput("The file é is missing.", "Make one.")

    def _fail(self, _: NoArgs) -> Reply:
        raise KeyError("surprise")

    def _jam(self, _: NoArgs) -> Reply:
        raise DeviceError("The shutter is stuck.")


class Running:
    """A server in a thread."""

    def __init__(self, service: Counter, server: Server) -> None:
        self.service = service
        self.server = server
        self.endpoint = server.endpoint
        self.status: int | None = None
        self.thread = threading.Thread(target=self._run)
        self.thread.start()

    def _run(self) -> None:
        self.status = self.server.run()

    def stop(self) -> None:
        self.service.released.set()
        self.server.stop()
        self.thread.join()


@pytest.fixture
def folder() -> Iterator[Path]:
    """A folder whose name is short enough for sockets."""
    path = Path(tempfile.mkdtemp(prefix="b-"))
    yield path
    shutil.rmtree(path, ignore_errors=True)


@pytest.fixture
def counter(folder: Path) -> Iterator[Running]:
    """A counter on ipc sockets, with events."""
    service = Counter()
    running = Running(service, Server(service, f"ipc://{folder}/s", events=f"ipc://{folder}/e"))
    yield running
    running.stop()


def wait_until(condition, deadline_s: float = 60.0) -> bool:  # type: ignore[no-untyped-def]
    """Poll a condition; whether it came true before the (generous) deadline."""
    end = time.monotonic() + deadline_s
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.01)
    return False
