"""A client of the servers, for Python: one request at a time, with a deadline and retries."""

import itertools
import math
import os
import time
from collections.abc import Sequence
from typing import Any, Self

import zmq
from numpy.typing import NDArray

from bridge.arrays import pack, unpack
from bridge.endpoints import CurveClient, is_ipv6
from bridge.envelope import MAX_FRAME_BYTES, decode_reply, encode_request
from bridge.errors import BadInput, BridgeAbsent, BridgeRefused, BridgeTimeout, ServerError
from bridge.presence import Presence, is_starting

RECONNECT_MS = 10
"""Between two tries to connect: a server that is starting is there at any moment."""
PROBE_S = 0.6
"""For a handshake to succeed or fail twice; chosen by hand, it takes milliseconds."""
PROBE_AGAIN_MS = 100
"""Between its tries; chosen by hand."""
ABSENT_S = 5.0
"""How long a server that starts may take to be there, for a person who waits; chosen by hand."""
ASKED_MS = 200
"""Between two looks whether somebody is there; chosen by hand."""
STILL_S = 1.0
"""A look that comes later than that: this process stood still, as one that is suspended; chosen by hand."""


class Client:
    """Requests to one server.

    Parameters
    ----------
    endpoint
        Where the server listens.
    timeout_s
        Deadline of a request in all, retries included; `request` may set another. Time in which this process
        is suspended does not count.
    retries
        How often a request without an answer is sent again, on a fresh socket and with the same id, so that a
        server that has done it already answers from memory.
    curve
        Keys, for a server that wants them.
    absent_s
        How long nobody may be there until a request is given up, see `ABSENT_S`, where no process is about to
        serve there; None: until its deadline.
    """

    def __init__(
        self,
        endpoint: str,
        timeout_s: float = 10.0,
        retries: int = 2,
        curve: CurveClient | None = None,
        absent_s: float | None = None,
    ) -> None:
        self.endpoint = endpoint
        self.timeout_s = timeout_s
        self._retries = retries
        self._curve = curve
        self._name = os.urandom(8).hex()
        self._numbers = itertools.count(1)
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._socket: zmq.Socket[bytes] | None = None
        self._let_in = False
        self._absent_s = math.inf if absent_s is None else absent_s
        self._presence = Presence()
        self._still_s = 0.0  # of the request under way

    def request(
        self,
        op: str,
        args: object | None = None,
        timeout_s: float | None = None,
        arrays: Sequence[NDArray[Any]] = (),
    ) -> tuple[dict[str, Any], list[NDArray[Any]]]:
        """Do one operation, which may take ``arrays``; returns its result and arrays.

        Raises
        ------
        ServerError
            The server's error reply.
        BridgeTimeout
            No answer within the deadline.
        BridgeAbsent
            Nobody has been there for ``absent_s``.
        BridgeRefused
            The server does not let this client in.
        ProtocolError
            An answer that is none.
        BadInput
            The endpoint is malformed, or this client is closed.
        """
        if self._context.closed:
            raise BadInput(f"The connection to {self.endpoint} has been closed.", "Open another one.")
        total = self.timeout_s if timeout_s is None else timeout_s
        request_id = f"{self._name}/{next(self._numbers)}"
        described, frames = pack(arrays)
        header = encode_request(request_id, op, {} if args is None else args, described)
        started, self._still_s = time.monotonic(), 0.0
        try:
            for attempt in range(1, self._retries + 2):
                sock = self._connected()
                deadline = started + total * attempt / (self._retries + 1)
                if self._sent(sock, [header, *(frame.data for frame in frames)], deadline):
                    reply = self._answer(sock, request_id, deadline)
                    if reply is not None:
                        self._let_in = True
                        return reply
                self._disconnect()
                if self._refused():
                    raise BridgeRefused(self.endpoint)
        except BaseException as error:
            if not isinstance(error, ServerError):
                self._disconnect()
            raise
        raise BridgeTimeout(self.endpoint, op, total)

    def _sent(self, sock: "zmq.Socket[bytes]", message: list[Any], deadline: float) -> bool:
        """Send a message as soon as there is a way; never where a handshake has been refused."""
        while self._ready(sock, zmq.POLLOUT, deadline):
            try:
                sock.send_multipart(message, zmq.NOBLOCK)
                return True
            except zmq.Again:  # the way was there a moment ago
                continue
        return False

    def _answer(
        self, sock: "zmq.Socket[bytes]", request_id: str, deadline: float
    ) -> tuple[dict[str, Any], list[NDArray[Any]]] | None:
        while self._ready(sock, zmq.POLLIN, deadline):
            frames = sock.recv_multipart(copy=False)
            reply = decode_reply(frames[0].bytes)
            if reply.error is not None and reply.id in (request_id, None):
                raise ServerError(reply.error.code, reply.error.message, reply.error.hint)
            if reply.id == request_id:
                return reply.result or {}, unpack(reply.arrays, frames[1:])
        return None

    def _ready(self, sock: "zmq.Socket[bytes]", event: int, deadline: float) -> bool:
        """Wait until the socket can be read or written; False at the deadline."""
        while (left := deadline + self._still_s - (asked := time.monotonic())) > 0:
            wait_ms = min(max(1, int(left * 1000)), ASKED_MS)
            if sock.poll(wait_ms, event):
                return True
            late_s = time.monotonic() - asked - wait_ms / 1000
            self._still_s += late_s if late_s > STILL_S else 0.0
            if self._given_up():
                if self._refused():  # after such a handshake libzmq does not connect again
                    raise BridgeRefused(self.endpoint)
                raise BridgeAbsent(self.endpoint, self._absent_s)
        return False

    def _given_up(self) -> bool:
        """Nobody has been there for too long, and nobody is about to be: a server that is being loaded is."""
        return self._presence.absent_s > self._absent_s and not is_starting(self.endpoint)

    def _refused(self) -> bool:
        """Does something listen there that ends handshakes, or hangs up in them again and again?

        A server that has let this client in, is not there, or stands still, does not refuse. One that has
        another key than we think cannot read what is said to it, and hangs up.
        """
        if self._let_in:
            return False
        from zmq.utils.monitor import recv_monitor_message  # late: asyncio comes with it

        sock = self._new_socket(PROBE_AGAIN_MS)
        failed = zmq.Event.HANDSHAKE_FAILED_PROTOCOL | zmq.Event.HANDSHAKE_FAILED_AUTH
        hung_up = zmq.Event.HANDSHAKE_FAILED_NO_DETAIL
        told = zmq.Event.CONNECTED | zmq.Event.HANDSHAKE_SUCCEEDED | failed | hung_up
        monitor = sock.get_monitor_socket(told)
        try:
            sock.connect(self.endpoint)
            deadline, times = time.monotonic() + PROBE_S, 0
            if not monitor.poll(PROBE_AGAIN_MS):  # nobody is there
                return False
            while monitor.poll(max(0, int((deadline - time.monotonic()) * 1000))):
                event = recv_monitor_message(monitor)["event"]
                times += event == hung_up
                if event & failed or times > 1:
                    return True
                if event == zmq.Event.HANDSHAKE_SUCCEEDED:
                    return False
            return False
        finally:
            sock.disable_monitor()
            sock.close()

    def _new_socket(self, reconnect_ms: int) -> "zmq.Socket[bytes]":
        sock = self._context.socket(zmq.DEALER)
        sock.linger = 0
        sock.maxmsgsize = MAX_FRAME_BYTES
        sock.reconnect_ivl = reconnect_ms
        sock.ipv6 = is_ipv6(self.endpoint)
        if self._curve is not None:
            self._curve.apply(sock)
        return sock

    def _connected(self) -> "zmq.Socket[bytes]":
        if self._socket is None:
            sock = self._new_socket(RECONNECT_MS)
            if self._absent_s < math.inf:
                self._presence.watch(sock)
            try:
                sock.connect(self.endpoint)
            except zmq.ZMQError as error:
                self._presence.leave(sock)
                sock.close()
                raise BadInput(
                    f"Cannot connect to {self.endpoint!r}: {error.strerror}.",
                    "Use ipc:///path/to/socket or tcp://HOST:PORT.",
                ) from error
            self._socket = sock
        return self._socket

    def _disconnect(self) -> None:
        if self._socket is not None:
            self._presence.leave(self._socket)
            self._socket.close()
            self._socket = None

    def close(self) -> None:
        """Close the connection; what was under way is given up."""
        self._disconnect()
        self._context.term()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
