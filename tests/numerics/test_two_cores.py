"""Calls side by side."""

from __future__ import annotations

import os
import subprocess
import sys
import threading

import pytest

from numerics.two_cores import beside, both, each

MANY_CORES = pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason="one core: calls run in turn")


@pytest.fixture(autouse=True)
def many_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    """A worker of experiments that another test ran in this process has left it one core."""
    monkeypatch.setattr("numerics.two_cores._alone", False)


def test_both_results_come_back_in_order() -> None:
    for number in range(20):
        assert both(lambda n=number: n, lambda n=number: -n) == (number, -number)


def test_each_item_has_its_answer_in_order() -> None:
    for count in range(6):
        assert each(lambda number: number**2, range(count)) == [number**2 for number in range(count)]


@MANY_CORES
def test_the_calls_run_at_the_same_time() -> None:
    meet = threading.Barrier(2)

    def met() -> int:
        meet.wait(60.0)  # breaks unless the other one comes too
        return threading.get_ident()

    here, there = both(met, met)
    assert here == threading.get_ident() != there


def test_an_error_comes_out_and_the_next_calls_work() -> None:
    def fails() -> None:
        raise ValueError("no such row")

    for calls in ((fails, int), (int, fails), (fails, fails)):
        with pytest.raises(ValueError, match="no such row"):
            both(*calls)
    assert both(lambda: 1, lambda: 2) == (1, 2)


def test_both_have_ended_when_one_fails() -> None:
    ended = []

    def fails() -> None:
        raise ValueError("first")

    def lasts() -> None:
        threading.Event().wait(0.05)
        ended.append(True)

    with pytest.raises(ValueError, match="first"):
        both(fails, lasts)
    assert len(ended) <= 1
    if len(os.sched_getaffinity(0)) > 1:
        assert ended == [True]


def test_calls_inside_calls_and_from_other_threads_end() -> None:
    def pair() -> tuple[int, int]:
        return both(lambda: 1, lambda: 2)

    assert both(pair, pair) == ((1, 2), (1, 2))
    results: list[object] = []
    threads = [threading.Thread(target=lambda: results.append(pair())) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60.0)
    assert results == [(1, 2)] * 8


@pytest.mark.parametrize("told", [False, True])
def test_what_is_given_beside_comes_back_in_order(told: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails() -> None:
        raise ValueError("no such row")

    monkeypatch.setattr("numerics.two_cores._alone", told)
    with beside() as second:
        given = [second.submit(lambda n=number: (n, threading.get_ident())) for number in range(5)]
        bad = second.submit(fails)
    numbers, threads = zip(*(one.result() for one in given), strict=True)
    assert numbers == (0, 1, 2, 3, 4)
    assert (set(threads) == {threading.get_ident()}) == (told or len(os.sched_getaffinity(0)) == 1)
    with pytest.raises(ValueError, match="no such row"):
        bad.result()


ONE_CORE = """
import threading
from numerics.two_cores import beside, both, cores, use_one_core
assert both(lambda: 1, lambda: 2) == (1, 2)
before = threading.active_count()
use_one_core()
import cv2
assert (cores(), cv2.getNumThreads()) == (1, 1)
me = threading.get_ident()
assert both(threading.get_ident, threading.get_ident) == (me, me)
with beside() as second:
    assert second.submit(threading.get_ident).result() == me
assert threading.active_count() == before
"""


def test_a_process_that_is_told_so_uses_one_core() -> None:
    assert subprocess.run([sys.executable, "-c", ONE_CORE], timeout=240, check=False).returncode == 0


FORK = """import os, sys
child = os.fork()
if child:
    sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""


@pytest.mark.parametrize(
    "program",
    ["", "import os; os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})", FORK],
    ids=["second thread", "one core", "forked"],
)
def test_a_process_that_used_it_ends(program: str) -> None:
    text = "\n".join(
        [
            "from numerics.two_cores import both",
            "assert both(lambda: 1, lambda: 2) == (1, 2)",
            program,
            "assert both(lambda: 3, lambda: 4) == (3, 4)",
        ]
    )
    assert subprocess.run([sys.executable, "-c", text], timeout=240, check=False).returncode == 0
