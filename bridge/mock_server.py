"""A server on a real socket whose replies and faults are scripted; `bridge.mocks` has the two there are."""

import shutil
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from threading import Thread
from typing import Any, Self

import msgspec

from bridge.envelope import Request
from bridge.errors import BadInput
from bridge.lifeline import Lifeline
from bridge.messages import NoArgs, Operation
from bridge.serve import Handler, Reply, Server, Service

GARBAGE = (b'{"v":1,"id":',)
"""What a garbled reply consists of unless told otherwise."""

Answer = Mapping[str, Any] | Reply | Exception | Callable[[Any], Any]
"""Fields of a result, the rest being as by default; a whole one; an error to reply with; or a function of the
typed arguments that returns a whole result or raises."""


@dataclass(frozen=True)
class RecordedRequest:
    """A request that arrived, with its arguments as plain JSON values; a repeated id is recorded once."""

    op: str
    args: dict[str, Any]


@dataclass
class _Script:
    """What to do with the next requests of one operation."""

    answers: list[Answer] = field(default_factory=list)
    amendments: dict[str, Any] = field(default_factory=dict)
    delay_s: float = 0.0
    drops: int = 0
    garbles: int = 0
    garbage: tuple[bytes, ...] = GARBAGE
    deadly: bool = False


class _Death(BaseException):
    """Ends the server without a reply."""


class _FaultyServer(Server):
    """A server that may lose or garble what it should send."""

    def __init__(self, mock: "MockServer", service: "_ScriptedService", lifeline: Lifeline) -> None:
        self._mock = mock
        super().__init__(service, mock.endpoint, mock.events, lifeline=lifeline)

    def _send(self, request: Request, route: list[bytes], answer: list[Any]) -> None:
        script = self._mock.script_of(request.op)
        if script.drops > 0:
            script.drops -= 1
        elif script.garbles > 0:
            script.garbles -= 1
            super()._send(request, route, list(script.garbage))
        else:
            super()._send(request, route, answer)


class _ScriptedService(Service):
    """The operations of a mock, with the scripts in front of the default handlers."""

    with_arrays = frozenset({"add", "track"})

    def __init__(self, mock: "MockServer", operations: Mapping[str, tuple[Any, Handler]]) -> None:
        self.name = mock.name
        self._mock = mock
        self.operations = {
            op: (args, self._scripted(op, default)) for op, (args, default) in operations.items()
        }

    def _scripted(self, op: str, default: Handler) -> Handler:
        def handler(args: Any) -> Reply:
            return self._mock.handle(op, args, default)

        return handler


class MockServer:
    """A server for tests, on a real ipc socket in a thread of its own.

    Parameters
    ----------
    name
        How it calls itself in `hello`.
    protocol
        The operations of such a server, with their types.
    handlers
        By operation: what answers where nothing is scripted.
    endpoint, events
        Where to listen and publish; in a folder of its own if not given.

    Attributes
    ----------
    requests
        What arrived, in order.
    """

    def __init__(
        self,
        name: str,
        protocol: Mapping[str, Operation],
        handlers: Mapping[str, Handler],
        endpoint: str | None = None,
        events: str | None = None,
    ) -> None:
        self.name = name
        self.requests: list[RecordedRequest] = []
        self._operations = {op: (protocol[op].args, handler) for op, handler in handlers.items()}
        self._results = {op: protocol[op].result for op in handlers}
        self._folder = None if endpoint and events else Path(tempfile.mkdtemp(prefix="mock-"))
        self.endpoint = endpoint or f"ipc://{self._folder}/requests"
        self.events = events or f"ipc://{self._folder}/events"
        self._scripts: dict[str, _Script] = {}
        self._server: Server | None = None
        self._thread: Thread | None = None

    # --- scripting ---

    def answer(self, op: str, *answers: Answer) -> None:
        """Answer ``op`` with these in turn, the last one again and again; with none, as by default.

        What a mapping leaves out is as by default.

        Raises
        ------
        BadInput
            There is no such operation (so in all that scripts one), or its result has no such field.
        """
        script = self._script(op)
        for answer in answers:
            if isinstance(answer, Mapping):
                self._check_fields(op, answer)
        script.answers = list(answers)

    def amend(self, op: str, **fields: Any) -> None:
        """Replace fields of the result of ``op``, whatever it is; more calls replace more fields."""
        script = self._script(op)
        self._check_fields(op, fields)
        script.amendments.update(fields)

    def delay(self, op: str, seconds: float) -> None:
        """Answer ``op`` that much later."""
        if not seconds >= 0:
            raise BadInput(f"A delay of {seconds} s cannot be.")
        self._script(op).delay_s = seconds

    def drop(self, op: str, times: int = 1) -> None:
        """Do ``op`` but lose that many of its replies."""
        self._script(op).drops = times

    def garble(self, op: str, times: int = 1, frames: tuple[bytes, ...] = GARBAGE) -> None:
        """Do ``op`` but send ``frames`` instead of that many of its replies."""
        script = self._script(op)
        script.garbles, script.garbage = times, frames

    def die(self, op: str) -> None:
        """End without a reply when ``op`` is asked for, as if killed; `start` brings the server back."""
        self._script(op).deadly = True

    def publish(self, event: str, args: Mapping[str, Any] | None = None) -> int:
        """Publish an event; returns its sequence number, 0 when the server does not run."""
        return 0 if self._server is None else self._server.service.emit(event, args)

    def requests_of(self, op: str) -> list[dict[str, Any]]:
        """Arguments of the requests of one operation, in order."""
        return [request.args for request in self.requests if request.op == op]

    def _script(self, op: str) -> _Script:
        if op not in self._operations:
            raise BadInput(
                f"The {self.name} has no operation {op!r}.", f"It has {', '.join(self._operations)}."
            )
        return self._scripts.setdefault(op, _Script())

    def _check_fields(self, op: str, fields: Mapping[str, Any]) -> None:
        config = getattr(self._results[op], "__struct_config__", None)
        if config is None or not config.forbid_unknown_fields:  # it tells what it likes
            return
        known = self._results[op].__struct_fields__
        for name in fields:
            if name not in known:
                raise BadInput(f"The result of {op!r} has no {name!r}.", f"It has {', '.join(known)}.")

    def script_of(self, op: str) -> _Script:
        """What is scripted for an operation; an empty script for one that has none."""
        return self._scripts.get(op, _Script())

    def handle(self, op: str, args: Any, default: Handler) -> Reply:
        """Answer one request by script or default; called by the serve loop."""
        self.requests.append(RecordedRequest(op, msgspec.to_builtins(args)))
        script = self.script_of(op)
        if script.deadly:
            script.deadly = False
            raise _Death
        if script.delay_s > 0:
            time.sleep(script.delay_s)
        answer: Any = default
        if script.answers:
            answer = script.answers.pop(0) if len(script.answers) > 1 else script.answers[0]
        changes = script.amendments
        if isinstance(answer, Mapping):
            answer, changes = default, {**answer, **changes}
        if callable(answer):
            answer = answer(args)
        if isinstance(answer, Exception):
            raise answer
        reply = answer if isinstance(answer, Reply) else Reply(answer)
        return Reply({**msgspec.to_builtins(reply.result), **changes}, reply.arrays) if changes else reply

    def health(self, _: NoArgs) -> Reply:
        """How many requests of each operation arrived; for clients in another process."""
        counts = Counter(request.op for request in self.requests)
        return Reply({"status": "ok", "requests": dict(counts)})

    # --- running ---

    @property
    def running(self) -> bool:
        """Whether the server answers."""
        return self._thread is not None and self._thread.is_alive()

    def run(self, lifeline: Lifeline) -> int:
        """Serve in this thread until the lifeline ends it; returns the exit status."""
        self._server = self._bound(lifeline)
        try:
            return self._server.run()
        except _Death:
            return 1

    def _bound(self, lifeline: Lifeline) -> Server:
        return _FaultyServer(self, _ScriptedService(self, self._operations), lifeline)

    def start(self) -> Self:
        """Serve in a thread, with an empty memory of replies."""
        self.stop()
        self._server = self._bound(Lifeline())
        self._thread = Thread(target=self._run, args=(self._server,), name=self.name, daemon=True)
        self._thread.start()
        return self

    def _run(self, server: Server) -> None:
        try:
            server.run()
        except _Death:
            return

    def stop(self) -> None:
        """Stop serving; scripts and records stay."""
        if self._server is not None and self._thread is not None:
            self._server.stop()
            self._thread.join()
        self._server = self._thread = None

    def __enter__(self) -> Self:
        return self.start()

    def __exit__(self, *_: object) -> None:
        self.stop()
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
