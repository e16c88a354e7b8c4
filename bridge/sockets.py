"""The sockets of a server: one for requests, one for events, guarded by keys where there are any."""

import math
import os
from collections import deque
from contextlib import suppress
from queue import SimpleQueue
from threading import Lock
from typing import TYPE_CHECKING, Any

import msgspec
import zmq

from bridge.endpoints import CurveServer, bind, listen, remove_ipc_file
from bridge.envelope import MAX_FRAME_BYTES
from bridge.gate import Gate
from bridge.messages import PROTOCOL

if TYPE_CHECKING:
    from zmq.auth.thread import ThreadAuthenticator

LINGER_MS = 500
"""How long a stopping server waits for its last reply to leave; chosen by hand."""
HANDSHAKE_MS = 5000
"""Longest that a peer may take to say who it is; chosen by hand."""
MOST_MESSAGES = 16
"""Requests and replies of one client that libzmq keeps; what it does not read beyond them is dropped."""
MOST_WAITING_BYTES = 256 * 1024 * 1024
"""Sum of the arrays in replies that have not left."""
MOST_OF_A_SUBSCRIBER = 1024 * 1024
"""Bytes that one subscriber may send while it is connected: it has to subscribe, no more."""
ZAP_DOMAIN = "lights-and-camera"
"""Name under which client keys are checked."""
WELCOME = msgspec.json.encode({"event": "welcome", "v": PROTOCOL, "args": {}, "sequence": 0})
"""What a subscriber gets first. It begins unlike an event: it can be sent to one alone."""
EVENT_HEAD = msgspec.json.encode({"v": PROTOCOL})[:-1]
"""What every event begins with: who subscribes to all is subscribed to this."""
SUBSCRIBE, UNSUBSCRIBE = b"\x01", b"\x00"
"""First byte of what a subscriber sends; its topic follows (ZMTP 3.1)."""


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
    wake_fileno
        Readable when there are events to send, and after `wake`.

    Raises
    ------
    BadInput
        When an endpoint cannot be bound.
    """

    def __init__(self, endpoint: str, events: str | None, curve: CurveServer | None) -> None:
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._context.linger = LINGER_MS
        self._guard: ThreadAuthenticator | None = None
        self._gates: list[Gate] = []
        self._bound: list[str] = []
        self._publishing = Lock()
        self._sequence = 0
        self._unsent: SimpleQueue[bytes] = SimpleQueue()
        self._leaving: deque[tuple[zmq.MessageTracker, int]] = deque()
        self.wake_fileno, self._wake = os.pipe()
        os.set_blocking(self.wake_fileno, False)
        os.set_blocking(self._wake, False)
        self.events: zmq.Socket[bytes] | None = None
        self.events_endpoint: str | None = None
        try:
            self.router = self._socket(zmq.ROUTER, curve)
            self.router.rcvhwm = self.router.sndhwm = MOST_MESSAGES
            self.endpoint = self._listen(self.router, endpoint, curve)
            if events is not None:
                self.events = self._socket(zmq.XPUB, curve)
                # ZeroMQ's own welcome leaves before it has read the subscription: an event between is lost
                self.events.setsockopt(zmq.XPUB_MANUAL, 1)
                self.events_endpoint = self._listen(self.events, events, curve, MOST_OF_A_SUBSCRIBER)
        except BaseException:
            self.close()
            raise

    def _socket(self, kind: int, curve: CurveServer | None) -> "zmq.Socket[bytes]":
        sock = self._context.socket(kind)
        sock.maxmsgsize = MAX_FRAME_BYTES
        sock.handshake_ivl = HANDSHAKE_MS
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

    def _listen(
        self, sock: "zmq.Socket[bytes]", endpoint: str, curve: CurveServer | None, most: float = math.inf
    ) -> str:
        if curve is not None:
            resolved = bind(sock, endpoint)
        else:
            listener, resolved = listen(endpoint)
            inner = f"lights-and-camera-{os.getpid()}-{os.urandom(8).hex()}"
            sock.setsockopt(zmq.IPC_FILTER_PID, os.getpid())  # behind the gate there is nobody else
            sock.bind(f"ipc://@{inner}")
            self._gates.append(Gate(listener, inner, most))
        self._bound.append(resolved)
        return resolved

    @property
    def cuts(self) -> int:
        """How many clients were cut off so far since they broke a bound."""
        return sum(gate.cuts for gate in self._gates)

    @property
    def alone_s(self) -> float:
        """For how long nobody has been connected, s; infinite where that is not known, as with keys."""
        return min((gate.alone_s for gate in self._gates), default=math.inf)

    def wake(self) -> None:
        """Make `wake_fileno` readable, from any thread."""
        with suppress(OSError):  # a full pipe wakes as well; a closed one nobody
            os.write(self._wake, b"!")

    def woken(self) -> None:
        """Make `wake_fileno` unreadable; only by who then looks after all that it may have been woken for."""
        with suppress(BlockingIOError):
            os.read(self.wake_fileno, 65536)

    def publish(self, event: str, args: object) -> int:
        """Publish an event, from any thread; returns its sequence number, 0 where events go nowhere."""
        with self._publishing:
            if self.events is None:
                return 0
            self._sequence += 1
            message = {"v": PROTOCOL, "event": event, "args": args, "sequence": self._sequence}
            self._unsent.put(msgspec.json.encode(message))
            self.wake()
            return self._sequence

    def send_events(self) -> None:
        """Send what was published; by the thread that serves, since a ZeroMQ socket belongs to one."""
        while self.events is not None and not self._unsent.empty():
            self.events.send(self._unsent.get())

    def read_subscriptions(self) -> None:
        """Do what subscribers ask for, and welcome each that is known from then on."""
        with suppress(zmq.Again):
            while self.events is not None:
                asked = self.events.recv(zmq.NOBLOCK)
                action, topic = asked[:1], asked[1:]
                if EVENT_HEAD.startswith(topic):
                    topic = EVENT_HEAD
                # Options of a manual socket are for the subscriber whose message was read last
                if action == SUBSCRIBE:
                    self.events.setsockopt(zmq.SUBSCRIBE, topic)
                    self.events.setsockopt(zmq.SUBSCRIBE, WELCOME)
                    self.events.send(WELCOME)
                    self.events.setsockopt(zmq.UNSUBSCRIBE, WELCOME)
                elif action == UNSUBSCRIBE:
                    self.events.setsockopt(zmq.UNSUBSCRIBE, topic)

    def requests_wait(self) -> bool:
        """Whether another request has come in."""
        return bool(int(self.router.get(zmq.EVENTS)) & zmq.POLLIN)

    def room_for(self, answer: list[Any]) -> bool:
        """Whether a reply may wait to be read beside those that do; without arrays it takes no room."""
        if len(answer) == 1:
            return True
        while self._leaving and self._leaving[0][0].done:
            self._leaving.popleft()
        waiting = sum(bytes_ for tracker, bytes_ in self._leaving if not tracker.done)
        return not waiting or waiting + sum(map(frame_bytes, answer)) <= MOST_WAITING_BYTES

    def send(self, route: list[bytes], answer: list[Any]) -> None:
        """Send a reply, after the events before it; its frames are no longer the caller's."""
        self.send_events()
        # Without arrays a copy is cheaper than keeping track of who still reads the frames.
        if len(answer) == 1:
            self.router.send_multipart([*route, *answer])
        else:
            tracker = self.router.send_multipart([*route, *answer], copy=False, track=True)
            assert tracker is not None
            self._leaving.append((tracker, sum(map(frame_bytes, answer))))

    def close(self) -> None:
        """Close all, after the last reply has left, and remove the socket files."""
        with self._publishing:
            if self._wake < 0:
                return
            self.send_events()
            self.events = None
            os.close(self._wake)
            os.close(self.wake_fileno)
            self._wake = -1
        if self._guard is not None:
            self._guard.stop()
        for endpoint in self._bound:
            remove_ipc_file(endpoint)
        self._context.destroy(linger=LINGER_MS)
        for gate in self._gates:
            gate.close()


def frame_bytes(frame: Any) -> int:
    """Bytes of a frame: a header, or an array."""
    return len(frame) if isinstance(frame, bytes) else int(frame.nbytes)


class _Allowed:
    """Says which client keys may connect; what pyzmq's authenticator asks."""

    def __init__(self, keys: frozenset[str]) -> None:
        self._keys = keys

    def callback(self, domain: str, key: bytes) -> bool:
        return key.decode("ascii") in self._keys
