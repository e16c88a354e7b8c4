"""Work of many callers side by side: one thing at a time for each of them, in the order it came.

What must not run side by side takes turns.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from threading import Condition, Lock, Thread

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

    def put(self, caller: bytes, work: Callable[[], None], size: int, prompt: bool = False) -> bool:
        """Have ``work``, which holds ``size`` bytes, done; False where too much waits already, or runs.

        Work that is ``prompt``, done in no time, may have a lane however many there are.
        """
        with self._changed:
            lane = self._lanes.get(caller)
            if self._bytes and self._bytes + size > MAX_WAITING_BYTES:
                return False
            if lane is not None:
                if len(lane) >= MAX_WAITING:
                    return False
                lane.append((work, size))
            else:
                if len(self._lanes) >= MAX_LANES and not prompt:
                    return False
                self._lanes[caller] = deque([(work, size)])
                try:
                    Thread(target=self._run, args=(caller,), name="lane", daemon=True).start()
                except RuntimeError:  # the system gives no more threads
                    del self._lanes[caller]
                    return False
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


class Turns:
    """A lock that is had in the order in which it was asked for.

    One that has work upon work would have a plain lock again before another, who waits, has woken up.
    """

    def __init__(self) -> None:
        self._guard = Lock()
        self._taken = False
        self._waiting: deque[Lock] = deque()

    def __enter__(self) -> None:
        with self._guard:
            if not self._taken:
                self._taken = True
                return
            turn = Lock()
            turn.acquire()
            self._waiting.append(turn)
        turn.acquire()  # until the one before passes it on

    def __exit__(self, *_: object) -> None:
        with self._guard:
            if self._waiting:
                self._waiting.popleft().release()
            else:
                self._taken = False
