"""Work of many callers side by side: one thing at a time for each of them, in the order it came."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from threading import Condition, Thread

MAX_WAITING = 16
"""Pieces of work of one caller that may wait, the one under way included; a client has one at a time."""
MAX_LANES = 128
"""Callers at a time, a thread each; as many as may be connected."""
MAX_WAITING_BYTES = 256 * 1024 * 1024
"""Sum of what waits, of all callers."""


class Lanes:
    """Threads that run while there is something to do."""

    def __init__(self) -> None:
        self._lanes: dict[bytes, deque[tuple[Callable[[], None], int]]] = {}
        self._bytes = 0
        self._changed = Condition()

    def __len__(self) -> int:
        return len(self._lanes)

    def put(self, caller: bytes, work: Callable[[], None], size: int) -> bool:
        """Have ``work``, which holds ``size`` bytes, done; False where too much waits already."""
        with self._changed:
            lane = self._lanes.get(caller)
            if self._bytes and self._bytes + size > MAX_WAITING_BYTES:
                return False
            if lane is not None:
                if len(lane) >= MAX_WAITING:
                    return False
                lane.append((work, size))
            else:
                if len(self._lanes) >= MAX_LANES:
                    return False
                self._lanes[caller] = deque([(work, size)])
                Thread(target=self._run, args=(caller,), name="lane", daemon=True).start()
            self._bytes += size
            return True

    def join(self) -> None:
        """Wait until all is done."""
        with self._changed:
            self._changed.wait_for(lambda: not self._lanes)

    def _run(self, caller: bytes) -> None:
        lane = self._lanes[caller]
        while True:
            work, size = lane[0]
            work()
            del work  # it holds arrays
            with self._changed:
                lane.popleft()
                self._bytes -= size
                if not lane:
                    del self._lanes[caller]
                    self._changed.notify_all()
                    return
