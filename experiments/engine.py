"""Running a plan: the cells that have no row yet, on a pool of workers, into a table."""

import os
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from experiments.feed import Feed
from experiments.kinds import Row
from experiments.plan import Plan
from experiments.scratch import sweep
from experiments.table import ResultsTable
from experiments.version import code_version


class Pool(Protocol):
    """Where cells are computed."""

    @property
    def where(self) -> str:
        """For people."""

    def rows(self, feed: Feed) -> Iterator[list[Row]]:
        """Compute what the feed gives; rows as they come, each safe to be written at once."""

    def close(self) -> None:
        """Stop."""


@dataclass(frozen=True)
class Start:
    """What a run begins with: cells in all, those that have their row, and where the others go."""

    cells: int
    finished: int
    where: str


Watch = Callable[[list[Row]], None]


def run_plan(
    plan: Plan,
    out: Path,
    make_pool: Callable[[str], Pool],
    begun: Callable[[Start], Watch],
    each: Callable[[Iterable[list[Row]]], Iterable[list[Row]]] = iter,
    again: bool = False,
) -> None:
    """Compute the cells of a plan that have no row yet.

    Parameters
    ----------
    out : folder of the table.
    make_pool : given the version that its workers must have.
    begun : told how it begins; gives what is told of rows that have been written.
    each : goes through the rows, and may end between them.
    again : compute cells that failed once more.

    Raises
    ------
    BadInput : the folder or the pool cannot be used.
    DeviceError : the disk or the workers failed for good; rows so far are safe.
    """
    version = code_version()
    table = ResultsTable(out, plan.description, version, again)
    try:
        finished = table.finished(without_failed=again)
        missing = sum(cell.key not in finished for cell in plan.cells())
        if missing == 0:
            table.merge()
            begun(Start(len(plan), len(plan), "nowhere: nothing is left"))
            return
        sweep()
        pool = make_pool(version)
        try:
            watch = begun(Start(len(plan), len(plan) - missing, pool.where))
            feed = Feed(cell for cell in plan.cells() if cell.key not in finished)
            for rows in each(pool.rows(feed)):
                table.append(rows)
                watch(rows)
        finally:
            pool.close()
            table.merge()
    finally:
        table.close()


def cores() -> int:
    """How many this process may use."""
    return len(os.sched_getaffinity(0))
