"""The gate of a server without keys: connections are accepted, counted and bounded here, then passed on.

libzmq bounds a frame, and counts only whole messages: the frames of a message that never ends pile up in it
without a limit (1 GB a second), and what a client does not read stays until its connection ends. So bytes are
passed on to libzmq through here, and ZMTP's frames are counted as they pass.
"""

from __future__ import annotations

import logging
import math
import socket
import struct
import threading
import time
from collections.abc import Callable
from contextlib import suppress

from bridge.endpoints import same_user
from bridge.envelope import MAX_MESSAGE_BYTES
from bridge.frame_meter import FrameMeter, TooMuchError

MAX_CONNECTIONS = 128
"""At a time; three descriptors each, and a process has 1024."""
MAX_UNFINISHED_BYTES = 2 * MAX_MESSAGE_BYTES
"""Sum of all messages that are not complete yet."""
STALLED_S = 10
"""A client that sends nothing amid a message, or takes nothing of a reply, for so long is cut off."""
LAST_WORDS_S = 1.0
"""How long a gate that closes waits for replies to be passed on; chosen by hand."""
CHUNK_BYTES = 128 * 1024  # read at once; chosen by hand

log = logging.getLogger("bridge.gate")


class Gate:
    """Passes connections of a listening socket on to an ipc endpoint of libzmq in this process.

    Parameters
    ----------
    listener
        Bound and listening; the gate closes it.
    inner
        Abstract name of the socket behind the gate.
    most_bytes
        That one connection may send in all; without a bound, if not given.

    Attributes
    ----------
    cuts
        How many connections broke a bound so far.
    """

    def __init__(self, listener: socket.socket, inner: str, most_bytes: float = math.inf) -> None:
        self.cuts = 0
        self._left_at = time.monotonic()
        self.most_bytes = most_bytes
        self._listener = listener
        self._inner = inner
        self._lock = threading.Lock()
        self._connections: set[_Connection] = set()
        self._closed = False
        self._thread = threading.Thread(target=self._accept, name="gate", daemon=True)
        self._thread.start()

    @property
    def alone_s(self) -> float:
        """For how long nobody has been connected, s; 0 while somebody is."""
        with self._lock:
            return 0.0 if self._connections else time.monotonic() - self._left_at

    def close(self) -> None:
        """Accept nobody any more, and end what is connected, once what libzmq has sent is passed on."""
        self._closed = True
        with suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        self._listener.close()
        with self._lock:
            open_now = list(self._connections)
        deadline = time.monotonic() + LAST_WORDS_S
        for connection in open_now:
            connection.drain(deadline)
        for connection in open_now:
            connection.cut()
        for connection in open_now:
            connection.join()

    def _accept(self) -> None:
        while True:
            try:
                outer, _ = self._listener.accept()
            except OSError:
                if self._closed:
                    return
                time.sleep(0.1)  # out of descriptors: some come back
                continue
            try:
                self._admit(outer)
            except (OSError, RuntimeError) as error:  # out of descriptors or threads
                log.warning("a connection could not be taken: %s", error)
                outer.close()

    def _admit(self, outer: socket.socket) -> None:
        if not same_user(outer):
            log.warning("a connection of another user was refused")
            outer.close()
            return
        inner = socket.socket(socket.AF_UNIX)
        try:
            inner.connect(f"\0{self._inner}")
            connection = _Connection(self, outer, inner)
        except BaseException:
            inner.close()
            raise
        with self._lock:
            crowd = list(self._connections) if len(self._connections) >= MAX_CONNECTIONS else []
            self._connections.add(connection)
        if crowd:
            min(crowd, key=lambda other: other.heard).cut()  # silent for longest; it may come again
        try:
            connection.start()
        except RuntimeError:
            connection.cut()
            self.left(connection)
            inner.close()
            raise

    def check_sum(self) -> None:
        """Cut off whoever has sent most of unfinished messages, where they are too much together."""
        with self._lock:
            if sum(each.meter.unfinished for each in self._connections) <= MAX_UNFINISHED_BYTES:
                return
            most = max(self._connections, key=lambda each: each.meter.unfinished)
        log.warning("unfinished messages are too much together; the largest is given up")
        self.cuts += 1
        most.cut()

    def left(self, connection: _Connection) -> None:
        """Forget a connection that has ended."""
        with self._lock:
            self._connections.discard(connection)
            self._left_at = time.monotonic()


class _Connection:
    """Two threads that pass bytes on, one for each direction."""

    def __init__(self, gate: Gate, outer: socket.socket, inner: socket.socket) -> None:
        self.meter = FrameMeter()
        self._received = 0
        self.heard = time.monotonic()
        self._gate = gate
        self._outer, self._inner = outer, inner
        for option in (socket.SO_RCVTIMEO, socket.SO_SNDTIMEO):
            outer.setsockopt(socket.SOL_SOCKET, option, struct.pack("ll", STALLED_S, 0))
        self._still = 2
        self._closing = threading.Lock()
        self._threads = [
            threading.Thread(target=self._run, args=(pump,), name="gate", daemon=True)
            for pump in (self._inward, self._outward)
        ]

    def start(self) -> None:
        for thread in self._threads:
            thread.start()

    def join(self) -> None:
        for thread in self._threads:
            thread.join()

    def drain(self, deadline: float) -> None:
        """Wait until all is passed on that the socket behind the gate, which has closed, sent."""
        self._threads[1].join(max(0.0, deadline - time.monotonic()))

    def cut(self) -> None:
        """End both directions."""
        with self._closing:
            if self._still:
                for end in (self._outer, self._inner):
                    with suppress(OSError):
                        end.shutdown(socket.SHUT_RDWR)

    def _run(self, pump: Callable[[], None]) -> None:
        try:
            pump()
        except TooMuchError as error:
            log.warning("a client was cut off: it sent %s", error)
            self._gate.cuts += 1
        except OSError:
            pass  # it went, stalled, or was cut off
        self.cut()
        with self._closing:
            self._still -= 1
            if self._still:
                return
            self._outer.close()
            self._inner.close()
        self._gate.left(self)

    def _inward(self) -> None:
        buffer = memoryview(bytearray(CHUNK_BYTES))
        while True:
            try:
                count = self._outer.recv_into(buffer)
            except BlockingIOError:
                if self.meter.midway:
                    raise TooMuchError("only a part of a message") from None
                continue
            if not count:
                return
            self._received += count
            self.heard = time.monotonic()
            self.meter.feed(buffer[:count])
            if self._received > self._gate.most_bytes:
                raise TooMuchError(f"{self._received} bytes where it has nothing to say")
            if self.meter.unfinished:
                self._gate.check_sum()
            self._inner.sendall(buffer[:count])

    def _outward(self) -> None:
        buffer = memoryview(bytearray(CHUNK_BYTES))
        while count := self._inner.recv_into(buffer):
            try:
                self._outer.sendall(buffer[:count])
            except BlockingIOError:
                raise TooMuchError("requests, and did not read the replies") from None
