"""What a person sees of a run: a bar with rate and time left, and the page of the results so far."""

import time
from collections import Counter
from collections.abc import Callable
from contextlib import AbstractContextManager, suppress
from typing import Self

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from bridge.command_line import counted
from bridge.errors import LightsAndCameraError
from experiments.engine import Start, Watch
from experiments.kinds import Row
from experiments.table import FAILED

LEAST_PAGE_S = 10.0  # between two pages
PAGE_SHARE = 0.02  # of the engine's time, that pages may take


class Progressing(AbstractContextManager["Progressing"]):
    """A bar on standard error while cells are computed.

    Parameters
    ----------
    quiet : show nothing.
    page : writes the page of the results so far; called now and then.
    """

    def __init__(self, quiet: bool, page: Callable[[], None]) -> None:
        self._console = Console(stderr=True, quiet=quiet)
        self._page = page
        self._next_page = time.monotonic() + LEAST_PAGE_S
        self._began = time.monotonic()
        self._computed = 0
        self._statuses: Counter[str] = Counter()
        self._said: str | None = None
        self._bar = Progress(
            TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(),
            TextColumn("{task.fields[rate]}"), TimeElapsedColumn(), TextColumn("left"),
            TimeRemainingColumn(), TextColumn("{task.fields[statuses]}"), console=self._console,
        )  # fmt: skip

    def begun(self, start: Start) -> Watch:
        """Say how it begins; gives what is told of new rows."""
        known = counted(start.cells, "cell")
        known += f", {start.finished} of them finished" if start.finished else ""
        self._console.print(f"{known}; on {start.where}", highlight=False, soft_wrap=True)
        self._began = time.monotonic()
        self._left = start.cells - start.finished
        self._task = self._bar.add_task(
            "cells", total=start.cells, completed=start.finished, rate="", statuses=""
        )
        self._bar.start()
        return self._watch

    def _watch(self, rows: list[Row]) -> None:
        self._computed += len(rows)
        self._statuses.update(row["status"] for row in rows)
        self._said = self._said or next((row["message"] for row in rows if row.get("message")), None)
        statuses = ", ".join(f"{count} {status}" for status, count in self._statuses.most_common())
        self._bar.update(self._task, advance=len(rows), rate=self.rate(), statuses=statuses)
        now = time.monotonic()
        if now >= self._next_page:
            with suppress(LightsAndCameraError):  # it is written once more at the end
                self._page()
            took = time.monotonic() - now
            self._next_page = time.monotonic() + max(LEAST_PAGE_S, took / PAGE_SHARE)

    def rate(self) -> str:
        """Cells computed in the time so far."""
        seconds = max(time.monotonic() - self._began, 1e-9)
        per_second = self._computed / seconds
        return f"{per_second:.1f}/s" if per_second >= 1.0 else f"{60 * per_second:.1f}/min"

    def end(self, words: str) -> None:
        """The last line."""
        self._bar.stop()
        if self._said is not None:
            said = " ".join(self._said.split())
            self._console.print(f"The first cell that failed: {said}", highlight=False, soft_wrap=True)
        self._console.print(words, highlight=False, soft_wrap=True)

    @property
    def computed(self) -> int:
        """Cells of this run."""
        return self._computed

    @property
    def failed(self) -> int:
        """Those of them that failed, or came to their deadline."""
        return sum(self._statuses[status] for status in FAILED)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()
