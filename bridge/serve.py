"""The serve loop of both servers: requests in, replies out, events beside them.

A request that breaks the protocol gets an error reply, and so does one whose handler fails; nothing that a
client sends ends a server, except `shutdown`. Handlers run beside the loop: a slow one holds up nobody else.
"""

import logging
import os
import time
from collections.abc import Mapping
from dataclasses import dataclass
from queue import SimpleQueue
from typing import Any

import zmq

from bridge import __version__
from bridge.endpoints import CurveServer, open_to_all
from bridge.envelope import Request, encode_error
from bridge.errors import ProtocolError
from bridge.lanes import Lanes
from bridge.lifeline import Lifeline
from bridge.messages import PROTOCOL, NoArgs
from bridge.operations import Operations
from bridge.reply_memory import LARGE_BYTES, TIDY_MS, ReplyMemory, give_back_freed
from bridge.service import Handler, Reply, Service
from bridge.sockets import ServerSockets, frame_bytes

__all__ = ["Handler", "Reply", "Server", "Service", "serve"]

BURST = 16
"""Requests served between two looks at signals and the parent; chosen by hand."""

log = logging.getLogger("bridge.serve")


@dataclass
class _Job:
    """A request that is being handled: what it said, and where its reply goes."""

    request: Request
    body: list[zmq.Frame]
    route: list[bytes]
    answer: list[Any]
    fatal: BaseException | None = None


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
        End when for so long no request has come and nobody was connected; never, if not given.

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
        self.service, self._idle_s = service, idle_s
        self.lifeline = lifeline or Lifeline()
        self._memory = ReplyMemory()
        self._started = time.monotonic()
        self._requests = 0
        self._heard = time.monotonic()
        self._lanes = Lanes()
        self._jobs: dict[str, _Job] = {}
        self._done: SimpleQueue[_Job] = SimpleQueue()
        self._untidy, self._cuts = False, 0
        try:
            self._sockets = ServerSockets(endpoint, events, curve)
        except BaseException:
            service.close()
            self.lifeline.close()
            raise
        self.endpoint = self._sockets.endpoint
        service.events_endpoint = self._sockets.events_endpoint
        service.emit = self._emit  # type: ignore[method-assign]
        own: dict[str, tuple[Any, Handler]] = {
            "hello": (NoArgs, self._hello),
            "health": (NoArgs, self._health),
        }
        self._operations = Operations(
            service, {**own, **service.operations, "shutdown": (NoArgs, self._shutdown)}
        )
        # What only tells of the loop is answered by it, however busy the service is.
        self._at_once = set(own) - set(service.operations)

    def run(self) -> int:
        """Serve until `shutdown`, a signal, the parent's death, `stop` or idleness; the exit status."""
        poller = zmq.Poller()
        poller.register(self._sockets.router, zmq.POLLIN)
        poller.register(self._sockets.wake_fileno, zmq.POLLIN)
        for fileno in self.lifeline.filenos():
            poller.register(fileno, zmq.POLLIN)
        if self._sockets.events is not None:
            poller.register(self._sockets.events, zmq.POLLIN)
        try:
            while not self.lifeline.ended():
                ready = dict(poller.poll(self._patience_ms()))
                if not ready:
                    if self._idle_s is not None and self._idle_for() >= self._idle_s:
                        break
                    self._tidy()
                if self._sockets.wake_fileno in ready:
                    self._sockets.woken()
                    self._sockets.send_events()
                    self._send_done()
                if self._sockets.events in ready:
                    self._sockets.read_subscriptions()
                if self._sockets.router in ready:
                    self._serve_burst()
            return self.lifeline.status
        finally:
            self._end()

    def stop(self) -> None:
        """End the loop after the requests in hand; from any thread."""
        self.lifeline.stop(0)

    def _idle_for(self) -> float:
        return 0.0 if self._jobs else min(time.monotonic() - self._heard, self._sockets.alone_s)

    def _patience_ms(self) -> int | None:
        """How long to wait for whatever comes; a millisecond at least: a poll may end a little early."""
        self._untidy |= self._sockets.cuts != self._cuts
        waits = [TIDY_MS] if self._untidy else []
        if self._idle_s is not None:
            waits.append(max(1, round(1e3 * (self._idle_s - self._idle_for()))))
        return min(waits, default=None)

    def _tidy(self) -> None:
        if self._untidy:
            give_back_freed()
        self._untidy, self._cuts = False, self._sockets.cuts

    def _end(self) -> None:
        try:
            self._lanes.join()
            self._send_done()
            self.service.close()
        finally:
            self._sockets.close()
            self.lifeline.close()

    # --- requests ---

    def _serve_burst(self) -> None:
        for _ in range(BURST):
            try:
                frames = self._sockets.router.recv_multipart(zmq.NOBLOCK, copy=False)
            except zmq.Again:  # its sender went away
                return
            self._heard = time.monotonic()
            self._serve_one(frames)
            if self.lifeline.ended() or not self._sockets.requests_wait():
                return

    def _serve_one(self, frames: list[zmq.Frame]) -> None:
        # A REQ socket puts an empty frame before its message and wants it back.
        start = 2 if len(frames) > 1 and not len(frames[1]) else 1
        route, body = [frame.bytes for frame in frames[:start]], frames[start:]
        request_id: str | None = None
        try:
            request = self._operations.checked(body)
            request_id = request.id
            header = body[0].bytes
            job, known = self._jobs.get(request_id), self._memory.get(request_id)
            if header != (job.body[0].bytes if job else known.request if known else header):
                raise ProtocolError(
                    "id_reused", f"The id {request_id} was used for another request.", "Count ids up."
                )
            if job is not None:
                job.route = route  # its sender has lost patience, and waits on another socket now
            elif known is not None:
                self._send(request, route, known.frames)
            else:
                self._begin(_Job(request, body, route, []))
        except ProtocolError as error:
            self._sockets.send(route, [encode_error(request_id or error.request_id, error)])

    def _begin(self, job: _Job) -> None:
        self._requests += 1
        if job.request.op in self._at_once:
            job.answer = self._operations.answer(job.request, job.body)
            self._remember(job)
            return
        size = sum(map(len, job.body))
        self._untidy |= size > LARGE_BYTES
        self._jobs[job.request.id] = job
        prompt = job.request.op in self.service.prompt
        if not self._lanes.put(job.route[0], lambda: self._work(job), size, prompt):
            del self._jobs[job.request.id]
            raise ProtocolError(
                "busy",
                f"The {self.service.name} has too many requests of this client, or of all.",
                "Wait for a reply before the next request.",
            )

    def _work(self, job: _Job) -> None:
        """Handle a request, in the thread of its sender's lane."""
        try:
            job.answer = self._operations.answer(job.request, job.body)
        except BaseException as error:  # for the loop to end with
            job.fatal = error
        self._done.put(job)
        self._sockets.wake()

    def _send_done(self) -> None:
        while not self._done.empty():
            job = self._done.get()
            del self._jobs[job.request.id]
            if job.fatal is not None:
                raise job.fatal
            self._remember(job)

    def _remember(self, job: _Job) -> None:
        size = sum(map(frame_bytes, job.answer))
        self._untidy |= size > LARGE_BYTES
        if not self._sockets.room_for(job.answer):
            busy = ProtocolError(
                "busy", "Too many replies wait to be read.", "Ask again when others have read theirs."
            )
            self._sockets.send(job.route, [encode_error(job.request.id, busy)])
            return
        self._memory.add(job.request.id, job.body[0].bytes, job.answer, size)
        self._send(job.request, job.route, job.answer)

    def _send(self, request: Request, route: list[bytes], answer: list[Any]) -> None:
        self._sockets.send(route, answer)

    # --- operations that every server has ---

    def _hello(self, _: NoArgs) -> Reply:
        return Reply(
            {
                "server": self.service.name,
                "version": __version__,
                "protocol": PROTOCOL,
                "operations": sorted(self._operations.names),
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


def serve(
    service: Service,
    endpoint: str,
    events: str | None = None,
    parent_pid: int | None = None,
    curve: CurveServer | None = None,
    idle_s: float | None = None,
) -> int:
    """Serve in the main thread of a process until told to stop; returns the exit status.

    0 after `shutdown`, the parent's death or ``idle_s`` seconds without a client, 143 after SIGTERM, 130
    after SIGINT. With ``parent_pid`` SIGINT is ignored, since Ctrl-C reaches parent and child alike and it is
    the parent that decides. A handler still running two seconds after the end was asked for is cut off.

    Raises
    ------
    BadInput
        When an endpoint cannot be bound, with a plain message.
    """
    lifeline = Lifeline(parent_pid, signals=True)
    server = Server(service, endpoint, events, curve, lifeline, idle_s)
    if curve is None and open_to_all(endpoint):
        told = "every user of this machine can call %s; on ipc:// only its own user can"
        log.warning(told, server.endpoint)
    lifeline.enforce(endpoint, events)
    return server.run()
