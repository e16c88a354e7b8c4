"""Frames from an image server to its client over ipc, against the same bytes over plain ZeroMQ."""

import tempfile
import time
from collections.abc import Callable
from threading import Thread
from typing import Any

import numpy as np
import zmq

from benchmarks.lines import Show
from bridge.client import Client
from bridge.messages import Describe, Settings
from bridge.serve import Server
from image_server.serve.device import Device, Frame
from image_server.serve.server import ImageServer

WIDTH, HEIGHT = 4000, 3000
FRAMES = 40
SETTINGS = Settings(lights=(), shutter_s=1 / 60, aperture=4.0)
DEADLINE_S = 60.0


class Still(Device):
    """A camera that has its frame ready, so that only the transport takes time."""

    name = "still"

    def __init__(self) -> None:
        self._pixels = np.random.default_rng(1).integers(0, 255, (HEIGHT, WIDTH), np.uint8)

    def describe(self) -> Describe:
        """One setting."""
        return Describe(device=self.name, lights=(), shutters_s=(1 / 60,), apertures=(4.0,))

    def capture(self, settings: Settings) -> Frame:
        """The frame."""
        return Frame(self._pixels, settings, settings, True, 1, time.time())

    def health(self) -> dict[str, Any]:
        """Always sound."""
        return {"status": "ok"}


def transport(show: Show) -> None:
    """Throughput of `capture` for 12-megapixel frames, checksum included."""
    with tempfile.TemporaryDirectory() as folder:
        ours = _captures(f"ipc://{folder}/ours")
        peer = _plain(f"ipc://{folder}/peer")
    show(
        "transport/frame_over_ipc", float(np.median(ours)), "GB/s", best_gb_per_s=max(ours),
        plain_zmq_gb_per_s=float(np.median(peer)), ratio=float(np.median(ours) / np.median(peer)),
    )  # fmt: skip


def _captures(endpoint: str) -> list[float]:
    server = Server(ImageServer(Still()), endpoint)
    thread = Thread(target=server.run)
    thread.start()
    try:
        with Client(endpoint, timeout_s=DEADLINE_S) as client:
            return _rates(lambda: client.request("capture", {"settings": SETTINGS})[1][0].nbytes)
    finally:
        server.lifeline.stop(0)
        thread.join()


def _plain(endpoint: str) -> list[float]:
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    frame = np.random.default_rng(1).integers(0, 255, WIDTH * HEIGHT, np.uint8)
    served = context.socket(zmq.REP)
    served.bind(endpoint)

    def answer() -> None:
        while served.recv():
            served.send(zmq.Frame(frame.data), copy=False)

    thread = Thread(target=answer)
    thread.start()
    asking = context.socket(zmq.REQ)
    asking.connect(endpoint)

    def ask() -> int:
        asking.send(b"frame")
        return len(asking.recv(copy=False))

    rates = _rates(ask)
    asking.send(b"")
    thread.join()
    context.destroy(linger=0)
    return rates


def _rates(ask: Callable[[], int]) -> list[float]:
    """GB/s of single frames, after one that does not count."""
    ask()
    rates = []
    for _ in range(FRAMES):
        began = time.perf_counter()
        size = ask()
        rates.append(1e-9 * size / (time.perf_counter() - began))
    return rates
