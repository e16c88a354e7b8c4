"""The sockets of a server: one for requests, one for events, guarded by keys where there are any."""

import os
from contextlib import suppress
from queue import SimpleQueue
from threading import Lock
from typing import TYPE_CHECKING, Any

import msgspec
import zmq

from bridge.endpoints import CurveServer, bind, remove_ipc_file
from bridge.envelope import MAX_FRAME_BYTES
from bridge.messages import PROTOCOL

if TYPE_CHECKING:
    from zmq.auth.thread import ThreadAuthenticator

LINGER_MS = 500
"""How long a stopping server waits for its last reply to leave; chosen by hand."""
ZAP_DOMAIN = "lights-and-camera"
"""Name under which client keys are checked."""
WELCOME = msgspec.json.encode({"v": PROTOCOL, "event": "welcome", "args": {}, "sequence": 0})
"""What a subscriber gets first."""


class ServerSockets:
    """Sockets bound for one server.

    Parameters
    ----------
    endpoint, events
        Where to listen, and where to publish events.
    curve
        Keys, required for a tcp endpoint that other machines can reach.

    Attributes
    ----------
    router
        Where requests come in.
    endpoint, events_endpoint
        As they were resolved: a port of ``*`` is a number.
    unsent_fileno
        Readable when there are events to send.

    Raises
    ------
    BadInput
        When an endpoint cannot be bound.
    """

    def __init__(self, endpoint: str, events: str | None, curve: CurveServer | None) -> None:
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._context.linger = LINGER_MS
        self._guard: ThreadAuthenticator | None = None
        self._bound: list[str] = []
        self._publishing = Lock()
        self._sequence = 0
        self._unsent: SimpleQueue[bytes] = SimpleQueue()
        self.unsent_fileno, self._wake = os.pipe()
        os.set_blocking(self.unsent_fileno, False)
        os.set_blocking(self._wake, False)
        self.events: zmq.Socket[bytes] | None = None
        self.events_endpoint: str | None = None
        try:
            self.router = self._socket(zmq.ROUTER, curve)
            self.endpoint = self._bind(self.router, endpoint, curve)
            if events is not None:
                self.events = self._socket(zmq.XPUB, curve)
                self.events.setsockopt(zmq.XPUB_WELCOME_MSG, WELCOME)
                self.events_endpoint = self._bind(self.events, events, curve)
        except BaseException:
            self.close()
            raise

    def _socket(self, kind: int, curve: CurveServer | None) -> "zmq.Socket[bytes]":
        sock = self._context.socket(kind)
        sock.maxmsgsize = MAX_FRAME_BYTES
        if curve is not None:
            if self._guard is None:
                # asyncio and ssl come with it: only where there are keys
                from zmq.auth.thread import ThreadAuthenticator

                self._guard = ThreadAuthenticator(self._context)
                self._guard.start()
                self._guard.configure_curve_callback(ZAP_DOMAIN, _Allowed(curve.allowed))
            sock.zap_domain = ZAP_DOMAIN.encode("ascii")
            sock.curve_server = True
            sock.curve_publickey = curve.public_key.encode("ascii")
            sock.curve_secretkey = curve.secret_key.encode("ascii")
        return sock

    def _bind(self, sock: "zmq.Socket[bytes]", endpoint: str, curve: CurveServer | None) -> str:
        self._bound.append(bind(sock, endpoint, curve is not None))
        return self._bound[-1]

    def publish(self, event: str, args: object) -> int:
        """Publish an event, from any thread; returns its sequence number, 0 where events go nowhere."""
        with self._publishing:
            if self.events is None:
                return 0
            self._sequence += 1
            message = {"v": PROTOCOL, "event": event, "args": args, "sequence": self._sequence}
            self._unsent.put(msgspec.json.encode(message))
            with suppress(BlockingIOError):  # a full pipe wakes as well
                os.write(self._wake, b"!")
            return self._sequence

    def send_events(self) -> None:
        """Send what was published; by the thread that serves, since a ZeroMQ socket belongs to one."""
        with suppress(BlockingIOError):
            os.read(self.unsent_fileno, 65536)
        while self.events is not None and not self._unsent.empty():
            self.events.send(self._unsent.get())

    def read_subscriptions(self) -> None:
        """Take what subscribers sent; ZeroMQ has welcomed them already."""
        with suppress(zmq.Again):
            while self.events is not None:
                self.events.recv(zmq.NOBLOCK)

    def requests_wait(self) -> bool:
        """Whether another request has come in."""
        return bool(int(self.router.get(zmq.EVENTS)) & zmq.POLLIN)

    def send(self, route: list[bytes], answer: list[Any]) -> None:
        """Send a reply, after the events before it; its frames are no longer the caller's."""
        self.send_events()
        # Without arrays a copy is cheaper than keeping track of who still reads the frames.
        self.router.send_multipart([*route, *answer], copy=len(answer) == 1)

    def close(self) -> None:
        """Close all, after the last reply has left, and remove the socket files."""
        with self._publishing:
            if self._wake < 0:
                return
            self.send_events()
            self.events = None
            os.close(self._wake)
            os.close(self.unsent_fileno)
            self._wake = -1
        if self._guard is not None:
            self._guard.stop()
        self._context.destroy(linger=LINGER_MS)
        for endpoint in self._bound:
            remove_ipc_file(endpoint)


class _Allowed:
    """Says which client keys may connect; what pyzmq's authenticator asks."""

    def __init__(self, keys: frozenset[str]) -> None:
        self._keys = keys

    def callback(self, domain: str, key: bytes) -> bool:
        return key.decode("ascii") in self._keys
