"""Workers on this machine: processes that each have one warm worker and a pipe."""

import ctypes
import multiprocessing
import signal
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path

from bridge.errors import DeviceError
from experiments.computing import OtherVersion, died_row, timed_rows
from experiments.feed import Feed
from experiments.kinds import Row
from experiments.plan import Cell

PR_SET_PDEATHSIG = 1  # prctl(2)
AHEAD = 2  # batches a worker has: one to compute, one to go on with
STARTS_WITHOUT_A_ROW = 4  # deaths in a row before any worker has given one


@dataclass
class _Hand:
    process: BaseProcess
    pipe: Connection
    batches: deque[list[Cell]] = field(default_factory=deque)


class LocalPool:
    """Processes on this machine.

    Parameters
    ----------
    workers : how many.
    keep : folder for run folders, as of `Worker`.
    """

    def __init__(self, workers: int, version: str, keep: Path | None = None) -> None:
        self.workers = workers
        self._version, self._keep = version, keep
        self._context = multiprocessing.get_context("spawn")
        self._hands: list[_Hand] = []
        self._idle_deaths = 0

    @property
    def where(self) -> str:
        """For people: where cells are computed."""
        return f"{self.workers} {'process' if self.workers == 1 else 'processes'}"

    def rows(self, feed: Feed) -> Iterator[list[Row]]:
        """Compute what the feed gives; rows as they come."""
        self._hands = [self._started() for _ in range(self.workers)]
        for hand in self._hands:
            self._supply(hand, feed)
        while busy := [hand for hand in self._hands if hand.batches]:
            ready = wait([hand.pipe for hand in busy])
            for hand in busy:
                if hand.pipe in ready:
                    yield from self._received(hand, feed)

    def _received(self, hand: _Hand, feed: Feed) -> Iterator[list[Row]]:
        try:
            answer = hand.pipe.recv()
        except (EOFError, OSError):
            yield from self._buried(hand, feed)
            return
        if isinstance(answer, OtherVersion):
            raise DeviceError(f"A worker has version {answer}, not {self._version}.", "Was the code changed?")
        rows, seconds = answer
        self._idle_deaths = 0
        feed.done(len(hand.batches.popleft()), seconds)
        self._supply(hand, feed)
        yield rows

    def _buried(self, hand: _Hand, feed: Feed) -> Iterator[list[Row]]:
        """Replace a worker that died; its first batch is what it was at."""
        hand.process.join()
        hand.pipe.close()
        self._idle_deaths += 1
        if self._idle_deaths >= STARTS_WITHOUT_A_ROW * self.workers:
            raise DeviceError(
                f"Workers die before they compute anything (exit status {hand.process.exitcode}).",
                "Their words are above.",
            )
        self._hands[self._hands.index(hand)] = fresh = self._started()
        at_fault = feed.died(hand.batches.popleft())
        for batch in hand.batches:
            feed.give_back(batch)
        self._supply(fresh, feed)
        for other in self._hands:  # one that has nothing left can have what came back
            self._supply(other, feed)
        if at_fault:
            yield [died_row(cell) for cell in at_fault]

    def _supply(self, hand: _Hand, feed: Feed) -> None:
        while len(hand.batches) < AHEAD and (batch := feed.take()):
            hand.batches.append(batch)
            try:
                hand.pipe.send(batch)
            except OSError:  # it has died; its pipe will say so
                return

    def _started(self) -> _Hand:
        ours, theirs = self._context.Pipe()
        process = self._context.Process(
            target=_work, args=(theirs, self._version, self._keep), name="experiments worker", daemon=False
        )
        process.start()
        theirs.close()
        return _Hand(process, ours)

    def close(self) -> None:
        """End the workers; what they compute is given up."""
        for hand in self._hands:
            hand.process.terminate()
        for hand in self._hands:
            hand.process.join(5.0)
            if hand.process.is_alive():
                hand.process.kill()
                hand.process.join()
            hand.pipe.close()
        self._hands = []


def _work(pipe: Connection, version: str, keep: Path | None) -> None:
    """What a worker's process does until its parent is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the engine decides
    signal.signal(signal.SIGTERM, _leave)
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)
    while True:
        try:
            cells = pipe.recv()
        except (EOFError, OSError):
            return
        try:
            answer: object = timed_rows(cells, version, keep)
        except OtherVersion as error:
            answer = error
        try:
            pipe.send(answer)
        except OSError:
            return


def _leave(signum: int, frame: object) -> None:
    raise SystemExit(128 + signum)  # atexit removes the scratch folder
