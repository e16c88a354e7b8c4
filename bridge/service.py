"""What a server serves: operations by name, and what their handlers are given and answer."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextvars import ContextVar
from dataclasses import dataclass, field
from typing import Any

import msgspec
from numpy.typing import NDArray

__all__ = ["Handler", "Reply", "Service"]

CALLER: ContextVar[str] = ContextVar("caller", default="")
ARRAYS: ContextVar[list[NDArray[Any]]] = ContextVar("arrays")

Handler = Callable[[Any], "Reply"]


@dataclass(frozen=True)
class Reply:
    """What a handler answers: a JSON object, and arrays of which it gives up the ownership."""

    result: Mapping[str, Any] | msgspec.Struct
    arrays: list[NDArray[Any]] = field(default_factory=list)


class Service:
    """Base of the servers: operations by name, each with the type of its arguments and its handler.

    The loop adds `hello` and `shutdown`, and a `health` where there is none. Handlers run beside the loop and
    raise errors of the family in `bridge.errors`.

    Attributes
    ----------
    exclusive
        Whether one handler runs at a time, whoever asks. If not, one for each client that is connected.
    prompt
        Operations of an exclusive service that only tell: they wait for none that is under way.
    with_arrays
        Operations that take arrays, which their handlers find in `arrays`.
    emit
        ``emit(event, args={})`` publishes an event, from any thread; set by the loop. Returns its sequence
        number, or 0 when there is no events endpoint.
    events_endpoint
        Where events are published, ``None`` if nowhere; set by the loop before the first request.
    """

    name: str = "service"
    exclusive: bool = True
    prompt: frozenset[str] = frozenset()
    with_arrays: frozenset[str] = frozenset()
    operations: Mapping[str, tuple[Any, Handler]]
    events_endpoint: str | None = None

    @property
    def caller(self) -> str:
        """Name of the client whose request is being handled; the part of its id before the slash."""
        return CALLER.get()

    @property
    def arrays(self) -> list[NDArray[Any]]:
        """Arrays of the request that is being handled, over the memory of the message."""
        return ARRAYS.get()

    def emit(self, event: str, args: Mapping[str, Any] | None = None) -> int:
        """Outside a loop nobody listens."""
        return 0

    def close(self) -> None:
        """Free what the service holds; called once when the loop ends."""
