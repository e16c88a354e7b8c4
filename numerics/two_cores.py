"""Two calls side by side: one here, one in a second thread that waits for such calls.

Meant for calls of compiled kernels, which let go of the interpreter's lock. Handing a call over and back
takes some 50 us, so it pays for calls of several times that, and the second should rather be the shorter one.
On a machine with one core, and while the second thread works for somebody else, the calls run one after the
other. So they do in a process that was told to use one core, since others compute on the rest.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from queue import SimpleQueue
from typing import Any, TypeVar

First = TypeVar("First")
Second = TypeVar("Second")
Item = TypeVar("Item")
Answer = tuple[Any, BaseException | None]  # what a call returned, or raised


class _Worker:
    """The second thread, started at its first call."""

    def __init__(self) -> None:
        self.free = threading.Lock()
        self._calls: SimpleQueue[tuple[Callable[[], Any], SimpleQueue[Answer]]] = SimpleQueue()
        self._started = False

    def begin(self, call: Callable[[], Any]) -> SimpleQueue[Answer]:
        """Hand a call over; where its answer will be."""
        if not self._started:
            threading.Thread(target=self._run, name="second core", daemon=True).start()
            self._started = True
        answer: SimpleQueue[Answer] = SimpleQueue()
        self._calls.put((call, answer))
        return answer

    def _run(self) -> None:
        while True:
            call, answer = self._calls.get()
            try:
                answer.put((call(), None))
            except BaseException as error:
                answer.put((None, error))
            del call, answer  # they hold arrays


_worker = _Worker()
_alone = False


def use_one_core() -> None:
    """From now on this process computes in the thread that asks, whatever the machine has."""
    import cv2  # it has threads of its own, and takes 50 ms to load

    global _alone  # noqa: PLW0603
    _alone = True
    cv2.setNumThreads(1)


def cores() -> int:
    """How many this process may compute on."""
    return 1 if _alone else len(os.sched_getaffinity(0))


class _AtOnce(Executor):
    """Does what it is given before it returns."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        done: Future[Any] = Future()
        try:
            done.set_result(fn(*args, **kwargs))
        except BaseException as error:
            done.set_exception(error)
        return done


@contextmanager
def beside() -> Iterator[Executor]:
    """One more thread, for calls in the order in which they are given; this one where there is one core."""
    if cores() == 1:
        yield _AtOnce()
    else:
        with ThreadPoolExecutor(1) as second:
            yield second


def _forget_worker() -> None:
    """A forked process has the object but not its thread."""
    global _worker  # noqa: PLW0603
    _worker = _Worker()


os.register_at_fork(after_in_child=_forget_worker)


def both(first: Callable[[], First], second: Callable[[], Second]) -> tuple[First, Second]:
    """What two independent calls return; ``second`` runs in another thread if it can.

    Both have ended when this returns or raises.

    Raises
    ------
    Whatever one of the calls raises, the first one's before the second one's.
    """
    worker = _worker
    if cores() == 1 or not worker.free.acquire(blocking=False):
        return first(), second()
    try:
        answer = worker.begin(second)
        try:
            here = first()
        finally:
            there, error = answer.get()
    finally:
        worker.free.release()
    if error is not None:
        raise error
    return here, there


def each(call: Callable[[Item], First], items: Sequence[Item]) -> list[First]:
    """What a call returns for each item, as of `map`: the second half of them side by side with the first."""
    middle = (len(items) + 1) // 2
    halves = items[:middle], items[middle:]
    here, there = both(*(partial(_of_all, call, half) for half in halves))
    return here + there


def _of_all(call: Callable[[Item], First], items: Sequence[Item]) -> list[First]:
    return [call(one) for one in items]
