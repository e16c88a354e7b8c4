"""A server's memory of its last replies, so that a repeated request is answered, not done twice.

And memory that was freed, which goes back to the system.
"""

import ctypes
from collections import OrderedDict
from dataclasses import dataclass
from typing import Any

MAX_CLIENTS, MAX_REPLIES_PER_CLIENT = 64, 32  # of protocol version 1, and:
MAX_BYTES = 16 * 1024 * 1024
TIDY_MS = 500
"""Quiet time after a large message or a client's end before freed memory is given back; chosen by hand."""
LARGE_BYTES = 4 * 1024 * 1024
"""A message of this size leaves a gap in memory that is worth giving back."""


@dataclass(frozen=True)
class Remembered:
    """One reply as it was sent, and the request that it answers."""

    request: bytes
    frames: list[Any]
    size: int


class ReplyMemory:
    """The last replies of the last clients, bounded in number and in bytes.

    The newest reply is always kept, however large; silent clients and old replies are forgotten first.
    """

    def __init__(
        self, clients: int = MAX_CLIENTS, replies: int = MAX_REPLIES_PER_CLIENT, size: int = MAX_BYTES
    ) -> None:
        self._max_clients = clients
        self._max_replies = replies
        self._max_bytes = size
        self._clients: OrderedDict[str, OrderedDict[str, Remembered]] = OrderedDict()
        self.bytes = 0

    def __len__(self) -> int:
        return sum(len(replies) for replies in self._clients.values())

    def get(self, request_id: str) -> Remembered | None:
        """The reply to this request id, if it is still known."""
        replies = self._clients.get(request_id.rpartition("/")[0])
        return None if replies is None else replies.get(request_id)

    def add(self, request_id: str, request: bytes, frames: list[Any], size: int) -> None:
        """Remember a reply; forgets the oldest ones where a bound is exceeded."""
        client = request_id.rpartition("/")[0]
        replies = self._clients.get(client)
        if replies is None:
            replies = self._clients[client] = OrderedDict()
            if len(self._clients) > self._max_clients:
                self._forget_client()
        else:
            self._clients.move_to_end(client)
        size += len(request)
        replies[request_id] = Remembered(request, frames, size)
        self.bytes += size
        if len(replies) > self._max_replies:
            self._forget_oldest(replies)
        while self.bytes > self._max_bytes and len(self) > 1:
            oldest = next(iter(self._clients))
            self._forget_oldest(self._clients[oldest])
            if not self._clients[oldest]:
                del self._clients[oldest]

    def _forget_client(self) -> None:
        _, replies = self._clients.popitem(last=False)
        self.bytes -= sum(reply.size for reply in replies.values())

    def _forget_oldest(self, replies: OrderedDict[str, Remembered]) -> None:
        _, forgotten = replies.popitem(last=False)
        self.bytes -= forgotten.size


def give_back_freed() -> None:
    """Give freed memory back to the system, which the C library would keep for the next image."""
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)
