"""Which cells go to a worker next, and how many at a time."""

import threading
from collections import deque
from collections.abc import Iterable

from experiments.plan import Cell

BATCH_S = 0.25  # a batch's time: long against a message, short against a progress bar
MOST_CELLS = 500  # of a batch, however short they are: what a dead worker gives back; chosen by hand
TRIES = 2  # deaths of a worker over a cell that was alone in its batch


class Feed:
    """Batches of cells that take about BATCH_S.

    Cells whose worker died come again, one by one, so that the one at fault is found.
    """

    def __init__(self, cells: Iterable[Cell]) -> None:
        self._cells = iter(cells)
        self._again: deque[Cell] = deque()
        self._deaths: dict[int, int] = {}
        self._seconds_per_cell: float | None = None
        self._lock = threading.Lock()

    def take(self) -> list[Cell]:
        """The next batch; empty when all cells have been given out."""
        with self._lock:
            if self._again:
                return [self._again.popleft()]
            count = 1
            if self._seconds_per_cell is not None:
                count = max(1, min(MOST_CELLS, int(BATCH_S / max(self._seconds_per_cell, 1e-9))))
            batch = []
            for cell in self._cells:
                batch.append(cell)
                if len(batch) == count:
                    break
            return batch

    def done(self, count: int, seconds: float) -> None:
        """Learn from a batch what a cell costs."""
        with self._lock:
            each = seconds / count
            known = self._seconds_per_cell
            self._seconds_per_cell = each if known is None else 0.7 * known + 0.3 * each

    def died(self, batch: list[Cell]) -> list[Cell]:
        """Give cells back whose worker died; returns those that are at fault, and do not come again."""
        with self._lock:
            if len(batch) > 1:
                self._again.extend(batch)
                return []
            key = batch[0].key
            self._deaths[key] = self._deaths.get(key, 0) + 1
            if self._deaths[key] >= TRIES:
                return batch
            self._again.append(batch[0])
            return []

    def give_back(self, batch: list[Cell]) -> None:
        """Give cells back that no one has looked at."""
        with self._lock:
            self._again.extend(batch)
