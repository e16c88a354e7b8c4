"""Signals end a command between two frames, and in a wait, never elsewhere."""

from __future__ import annotations

import signal
from collections.abc import Iterator

import pytest

from bridge.stopping import Stopped, Stopping


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_while_something_is_done_ends_it_when_it_is_done(
    number: signal.Signals, status: int
) -> None:
    done = []
    with Stopping() as stopping, pytest.raises(Stopped) as stopped:
        for item in stopping.each(range(9)):
            if item == 2:
                signal.raise_signal(number)
            done.append(item)
    assert done == [0, 1, 2]
    assert stopped.value.status == status


def test_a_signal_ends_a_wait_at_once() -> None:
    def coming() -> Iterator[int]:
        yield 0
        signal.raise_signal(signal.SIGINT)
        raise AssertionError("it waits on")

    with Stopping() as stopping, pytest.raises(Stopped):
        list(stopping.each(coming()))


def test_a_signal_that_is_ignored_stays_so() -> None:
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with Stopping() as stopping:
            signal.raise_signal(signal.SIGINT)
            stopping.heed()
    finally:
        signal.signal(signal.SIGINT, before)


def test_afterwards_signals_are_as_before() -> None:
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    with Stopping() as stopping:
        assert list(stopping.each("ab")) == ["a", "b"]
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == before
