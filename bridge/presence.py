"""Whether anybody is at the other end of a client's socket: what a deadline alone finds out late."""

import struct
import time
from contextlib import suppress
from itertools import pairwise
from pathlib import Path

import zmq

EVENT = struct.Struct("=hi")  # of libzmq: an event, and a value


class Presence:
    """Of one server, for as long as a client has to do with it.

    A server that works, or stands still, is there. One that has died, or was never started, is not.
    """

    def __init__(self) -> None:
        self._monitor: zmq.Socket[bytes] | None = None
        self._since: float | None = None

    @property
    def absent_s(self) -> float:
        """For how long nobody has been there, s; 0 while somebody is."""
        self._read()
        return 0.0 if self._since is None else time.monotonic() - self._since

    def _read(self) -> None:
        while self._monitor is not None and self._monitor.poll(0):
            event, _ = EVENT.unpack(self._monitor.recv_multipart()[0])
            if event == zmq.Event.CONNECTED:
                self._since = None
            elif self._since is None:
                self._since = time.monotonic()

    def watch(self, sock: "zmq.Socket[bytes]") -> None:
        """Look at a new socket from now on, before it connects."""
        self._monitor = sock.get_monitor_socket(zmq.Event.CONNECTED | zmq.Event.DISCONNECTED)
        if self._since is None:
            self._since = time.monotonic()

    def leave(self, sock: "zmq.Socket[bytes]") -> None:
        """The socket is about to be closed.

        What was told is read first: libzmq's thread, with a thousand events that nobody took, waits for
        somebody who does, and who ends the telling waits for it.
        """
        self._read()
        if self._monitor is not None:
            with suppress(zmq.ZMQError):
                sock.disable_monitor()
            self._monitor = None


def is_starting(endpoint: str) -> bool:
    """Whether a process of this machine was started to serve there, by its words; listening or not yet."""
    name = endpoint.encode()
    for file in Path("/proc").glob("[0-9]*/cmdline"):
        with suppress(OSError):  # it has ended
            words = file.read_bytes().split(b"\0")
            if b"--endpoint=" + name in words or (b"--endpoint", name) in pairwise(words):
                return True
    return False
