"""The serve loop of both servers: requests in, replies out, events beside them.

A request that breaks the protocol gets an error reply, and so does one whose handler fails; nothing that a
client sends ends a server, except `shutdown`.
"""

import logging
import os
import time
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import msgspec
import zmq
from numpy.typing import NDArray

from bridge import __version__
from bridge.arrays import pack
from bridge.endpoints import CurveServer
from bridge.envelope import (
    MAX_HEADER_BYTES,
    Request,
    decode_request,
    encode_error,
    encode_reply,
)
from bridge.errors import LightsAndCameraError, ProtocolError
from bridge.lifeline import Lifeline
from bridge.memory import ReplyMemory
from bridge.messages import PROTOCOL, NoArgs
from bridge.sockets import ServerSockets

__all__ = ["Handler", "Reply", "Server", "Service", "serve"]

BURST = 16
"""Requests served between two looks at signals and the parent; chosen by hand."""

log = logging.getLogger("bridge.serve")

Handler = Callable[[Any], "Reply"]


@dataclass(frozen=True)
class Reply:
    """What a handler answers: a JSON object, and arrays of which it gives up the ownership."""

    result: Mapping[str, Any] | msgspec.Struct
    arrays: list[NDArray[Any]] = field(default_factory=list)


class Service:
    """Base of the servers: operations by name, each with the type of its arguments and its handler.

    The loop adds `hello` and `shutdown`, and a `health` where there is none. Handlers run one at a time in
    the loop's thread and raise errors of the family in `bridge.errors`.

    Attributes
    ----------
    emit
        ``emit(event, args={})`` publishes an event, from any thread; set by the loop. Returns its sequence
        number, or 0 when there is no events endpoint.
    events_endpoint
        Where events are published, ``None`` if nowhere; set by the loop before the first request.
    """

    name: str = "service"
    operations: Mapping[str, tuple[Any, Handler]]
    events_endpoint: str | None = None

    def emit(self, event: str, args: Mapping[str, Any] | None = None) -> int:
        """Outside a loop nobody listens."""
        return 0

    def close(self) -> None:
        """Free what the service holds; called once when the loop ends."""


class Server:
    """One service on one endpoint.

    Parameters
    ----------
    service
        What to serve.
    endpoint, events
        Where to listen, and where to publish events.
    curve
        Keys, required for a tcp endpoint that other machines can reach.
    lifeline
        What ends the loop from outside; a fresh one if not given.
    idle_s
        End when no request has come for so long; never, if not given.

    Raises
    ------
    BadInput
        When an endpoint cannot be bound.
    """

    def __init__(
        self,
        service: Service,
        endpoint: str,
        events: str | None = None,
        curve: CurveServer | None = None,
        lifeline: Lifeline | None = None,
        idle_s: float | None = None,
    ) -> None:
        self._idle_ms = None if idle_s is None else round(1e3 * idle_s)
        self.service = service
        self.lifeline = lifeline or Lifeline()
        self._memory = ReplyMemory()
        self._started = time.monotonic()
        self._requests = 0
        try:
            self._sockets = ServerSockets(endpoint, events, curve)
        except BaseException:
            service.close()
            self.lifeline.close()
            raise
        self.endpoint = self._sockets.endpoint
        service.events_endpoint = self._sockets.events_endpoint
        service.emit = self._emit  # type: ignore[method-assign]
        self._operations: dict[str, tuple[msgspec.json.Decoder[Any], Any, Handler]] = {
            op: (msgspec.json.Decoder(args), args, handler)
            for op, (args, handler) in {
                "hello": (NoArgs, self._hello),
                "health": (NoArgs, self._health),
                **service.operations,
                "shutdown": (NoArgs, self._shutdown),
            }.items()
        }

    def run(self) -> int:
        """Serve until `shutdown`, a signal, the parent's death, `stop` or idleness; the exit status."""
        poller = zmq.Poller()
        poller.register(self._sockets.router, zmq.POLLIN)
        poller.register(self._sockets.unsent_fileno, zmq.POLLIN)
        for fileno in self.lifeline.filenos():
            poller.register(fileno, zmq.POLLIN)
        if self._sockets.events is not None:
            poller.register(self._sockets.events, zmq.POLLIN)
        try:
            while not self.lifeline.ended():
                ready = dict(poller.poll(self._idle_ms))
                if not ready:
                    break
                if self._sockets.unsent_fileno in ready:
                    self._sockets.send_events()
                if self._sockets.events in ready:
                    self._sockets.read_subscriptions()
                if self._sockets.router in ready:
                    self._serve_burst()
            return self.lifeline.status
        finally:
            self._end()

    def stop(self) -> None:
        """End the loop after the request in hand; from any thread."""
        self.lifeline.stop(0)

    def _end(self) -> None:
        try:
            self.service.close()
        finally:
            self._sockets.close()
            self.lifeline.close()

    # --- requests ---

    def _serve_burst(self) -> None:
        for _ in range(BURST):
            try:
                frames = self._sockets.router.recv_multipart(zmq.NOBLOCK)
            except zmq.Again:  # its sender went away
                return
            self._serve_one(frames)
            if self.lifeline.ended() or not self._sockets.requests_wait():
                return

    def _serve_one(self, frames: list[bytes]) -> None:
        # A REQ socket puts an empty frame before its message and wants it back.
        start = 2 if len(frames) > 1 and not frames[1] else 1
        route, body = frames[:start], frames[start:]
        request_id: str | None = None
        try:
            request = self._checked(body)
            request_id = request.id
            known = self._memory.get(request_id)
            if known is None:
                answer = self._answer(request)
                self._memory.add(request_id, body[0], answer, sum(map(_size, answer)))
            elif known.request == body[0]:
                answer = known.frames
            else:
                raise ProtocolError(
                    "id_reused", f"The id {request_id} was used for another request.", "Count ids up."
                )
        except ProtocolError as error:
            answer = [encode_error(request_id or error.request_id, error)]
        self._send(route, answer)

    def _send(self, route: list[bytes], answer: list[Any]) -> None:
        self._sockets.send(route, answer)

    def _checked(self, body: list[bytes]) -> Request:
        if not body:
            raise ProtocolError("bad_message", "The request is empty.")
        if len(body[0]) > MAX_HEADER_BYTES:
            raise ProtocolError(
                "too_large",
                f"The request's header has {len(body[0])} bytes; at most {MAX_HEADER_BYTES} are taken.",
            )
        request = decode_request(body[0])
        if len(body) > 1:
            raise ProtocolError(
                "bad_frames",
                f"The request has {len(body) - 1} array frames; no operation takes any.",
                request_id=request.id,
            )
        return request

    def _answer(self, request: Request) -> list[Any]:
        self._requests += 1
        try:
            reply = self._handle(request)
            described, arrays = pack(reply.arrays)
            header = encode_reply(request.id, reply.result, described)
            if len(header) > MAX_HEADER_BYTES:
                raise ValueError(f"the result has {len(header)} bytes, more than {MAX_HEADER_BYTES}")
            return [header, *arrays]
        except LightsAndCameraError as error:
            return [encode_error(request.id, error)]
        except Exception as error:
            log.exception("%s: %s failed", self.service.name, request.op)
            where = traceback.extract_tb(error.__traceback__)[-1]
            internal = ProtocolError(
                "internal",
                f"The {self.service.name} failed in {request.op!r}: {type(error).__name__}: {error} "
                f"({os.path.basename(where.filename)}, line {where.lineno}).",
                "This is a defect of the server; its log has the details.",
            )
            return [encode_error(request.id, internal)]

    def _handle(self, request: Request) -> Reply:
        try:
            decoder, args_type, handler = self._operations[request.op]
        except KeyError:
            raise ProtocolError(
                "unknown_operation",
                f"The {self.service.name} has no operation {request.op!r}.",
                f"It has {', '.join(sorted(self._operations))}.",
            ) from None
        try:
            args = decoder.decode(request.args)
        except (msgspec.MsgspecError, ValueError, RecursionError) as error:
            raise ProtocolError(
                "bad_arguments",
                f"Operation {request.op!r} of the {self.service.name} cannot take these arguments: {error}.",
                _fields_of(args_type),
            ) from None
        return handler(args)

    # --- operations that every server has ---

    def _hello(self, _: NoArgs) -> Reply:
        return Reply(
            {
                "server": self.service.name,
                "version": __version__,
                "protocol": PROTOCOL,
                "operations": sorted(self._operations),
                "pid": os.getpid(),
            }
        )

    def _health(self, _: NoArgs) -> Reply:
        uptime = time.monotonic() - self._started
        return Reply({"status": "ok", "uptime_s": uptime, "requests": self._requests})

    def _shutdown(self, _: NoArgs) -> Reply:
        self.lifeline.stop(0)
        return Reply({})

    def _emit(self, event: str, args: Mapping[str, Any] | None = None) -> int:
        return self._sockets.publish(event, args or {})


def _size(frame: Any) -> int:
    return len(frame) if isinstance(frame, bytes) else int(frame.nbytes)


def _fields_of(args_type: Any) -> str:
    fields = getattr(args_type, "__struct_fields__", None)
    if fields is None:
        return ""
    return f"Its arguments are {', '.join(fields)}." if fields else "It takes no arguments."


def serve(
    service: Service,
    endpoint: str,
    events: str | None = None,
    parent_pid: int | None = None,
    curve: CurveServer | None = None,
    idle_s: float | None = None,
) -> int:
    """Serve in the main thread of a process until told to stop; returns the exit status.

    0 after `shutdown`, the parent's death or ``idle_s`` seconds without a request, 143 after SIGTERM, 130
    after SIGINT. With ``parent_pid`` SIGINT is ignored, since Ctrl-C reaches parent and child alike and it is
    the parent that decides. A handler still running two seconds after the end was asked for is cut off.

    Raises
    ------
    BadInput
        When an endpoint cannot be bound, with a plain message.
    """
    lifeline = Lifeline(parent_pid, signals=True)
    server = Server(service, endpoint, events, curve, lifeline, idle_s)
    lifeline.enforce(endpoint, events)
    return server.run()
