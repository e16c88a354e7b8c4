"""Ctrl-C and SIGTERM for a command that has files to finish: heeded between frames, and in waits."""

from __future__ import annotations

import signal
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Self, TypeVar

T = TypeVar("T")

SIGNALS = (signal.SIGINT, signal.SIGTERM)
STATUS = 128  # of a program that a signal ends a shell says this, and the signal's number


class Stopped(Exception):  # noqa: N818
    """A signal has told the command to end."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.status = STATUS + number


class Stopping:
    """`with` it, signals are only noted: an exception out of a handler may meet a compiled kernel, which it
    crashes, or a library that catches it. One that whoever started this has ignored stays so."""

    def __init__(self) -> None:
        self._number: int | None = None
        self._waits = False

    def each(self, items: Iterable[T]) -> Iterator[T]:
        """The items, one at a time; waiting for one may be interrupted.

        Raises
        ------
        Stopped : a signal has come.
        """
        coming = iter(items)
        while True:
            try:
                with self.waiting():
                    item = next(coming)
            except StopIteration:
                return
            self.heed()
            yield item

    @contextmanager
    def waiting(self) -> Iterator[None]:
        """`with` it, what is done may be interrupted; raises as `each`."""
        self._waits = True
        try:
            self.heed()
            yield
        finally:
            self._waits = False

    def heed(self) -> None:
        """Raise Stopped where a signal has come."""
        if self._number is not None:
            raise Stopped(self._number)

    def _note(self, number: int, _: FrameType | None) -> None:
        self._number = number
        if self._waits:
            raise Stopped(number)

    def __enter__(self) -> Self:
        self._before = {
            number: signal.signal(number, self._note)
            for number in SIGNALS
            if signal.getsignal(number) != signal.SIG_IGN
        }
        return self

    def __exit__(self, *_: object) -> None:
        for number, before in self._before.items():
            signal.signal(number, before)
