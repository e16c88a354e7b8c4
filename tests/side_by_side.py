"""Files of tests in several processes that share what one of them has collected: `pytest --beside 3`.

To read the files of tests, have their assertions rewritten and import what they test takes longer than most
of them take to run, and pytest-xdist has every worker do all of it. Here one process collects and is then
forked; a file goes to one of the others, whose tests share what it prepares.
"""

from __future__ import annotations

import atexit
import os
import signal
import time
import warnings
from collections import deque
from contextlib import suppress
from itertools import groupby, zip_longest
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from typing import Any, NamedTuple

import pytest

Location = tuple[str, int | None, str]

END_S = 60.0  # for a worker that is told to stop; chosen by hand


def pytest_addoption(parser: pytest.Parser) -> None:
    """Tell pytest of the option."""
    words = "Run the files of tests in so many processes, which share what one has collected."
    parser.addoption("--beside", type=int, default=0, metavar="N", help=words)


@pytest.hookimpl(tryfirst=True)
def pytest_runtestloop(session: pytest.Session) -> bool | None:
    """Run what was collected; as pytest does where the option is not given or not all could be collected."""
    count: int = session.config.getoption("beside")
    if not count or session.testsfailed or session.config.getoption("collectonly"):
        return None
    house = House(session)
    try:
        if all(house.start() for _ in range(count)):
            house.listen()
    finally:
        house.close()
    return True


class Share(NamedTuple):
    """The tests of a file, by its number, from this one on."""

    file: int
    first: int = 0


class Worker:
    """A process as its parent knows it: what it has, until it is told to end, and at which test it is."""

    def __init__(self, pid: int, pipe: Connection) -> None:
        self.pid, self.pipe = pid, pipe
        self.share: Share | None = None
        self.at: tuple[str, Location] | None = None


class House:
    """The files that nobody has yet, and those who run them."""

    def __init__(self, session: pytest.Session) -> None:
        self._session, self._config = session, session.config
        self._files = [list(items) for _, items in groupby(session.items, key=lambda item: item.path)]
        self._waiting = deque(map(Share, range(len(self._files))))
        self._workers: list[Worker] = []

    def start(self) -> bool:
        """Start a worker. False is what the worker itself is told, when it has run its share."""
        ours, theirs = Pipe()
        pid = os.fork()
        if pid:
            theirs.close()
            self._workers.append(Worker(pid, ours))
            return True
        for pipe in (ours, *(worker.pipe for worker in self._workers)):
            pipe.close()
        self._workers = []
        _work(self._session, self._files, theirs)
        return False

    def listen(self) -> None:
        """Hand out files and pass on what is said of their tests, until all have been run."""
        while self._workers:
            pipes = {worker.pipe: worker for worker in self._workers}
            ready = wait(list(pipes))
            for pipe, worker in pipes.items():
                if pipe not in ready:
                    continue
                try:
                    told = pipe.recv()
                except (EOFError, OSError):
                    if not self._buried(worker):
                        return
                    break  # the workers are others now
                self._heard(worker, *told)
                if self._session.shouldfail:
                    raise self._session.Failed(self._session.shouldfail)
                if self._session.shouldstop:
                    raise self._session.Interrupted(self._session.shouldstop)

    def _heard(self, worker: Worker, word: str, *told: Any) -> None:
        hook = self._config.hook
        if word == "next":
            worker.share, worker.at = self._waiting.popleft() if self._waiting else None, None
            worker.pipe.send(worker.share)
        elif word == "started":
            worker.at = told[0], told[1]
            hook.pytest_runtest_logstart(nodeid=told[0], location=told[1])
        elif word == "warned":
            text, file, line, when, nodeid = told
            message = warnings.WarningMessage(UserWarning(text), UserWarning, file, line)
            known = {"warning_message": message, "when": when, "nodeid": nodeid, "location": None}
            hook.pytest_warning_recorded.call_historic(kwargs=known)
        else:
            report = hook.pytest_report_from_serializable(config=self._config, data=told[0])
            hook.pytest_runtest_logreport(report=report)

    def _buried(self, worker: Worker) -> bool:
        """One has ended: in the middle of a test, that one has failed, and another goes on. As `start`."""
        status = os.waitstatus_to_exitcode(os.waitpid(worker.pid, 0)[1])
        worker.pipe.close()
        self._workers.remove(worker)
        if worker.share is None and status == 0:
            return True
        file, first = worker.share or (
            len(self._files) - 1,
            -1,
        )  # leaving what is the session's
        names = [item.nodeid for item in self._files[file]]
        nodeid, location = worker.at or (names[first], ("", None, ""))
        words = f"the process that ran it ended, exit status {status}"
        failed = pytest.TestReport(nodeid, location, {}, "failed", words, "call")
        self._config.hook.pytest_runtest_logreport(report=failed)
        if nodeid != names[-1]:
            self._waiting.appendleft(Share(file, names.index(nodeid) + 1))
        return self.start() if self._waiting else True

    def close(self) -> None:
        """End those who are left, as of a run that is broken off."""
        for worker in self._workers:
            with suppress(ProcessLookupError):
                os.kill(worker.pid, signal.SIGINT)
            worker.pipe.close()
        deadline = time.monotonic() + END_S
        for worker in self._workers:
            while os.waitpid(worker.pid, os.WNOHANG)[0] == 0:
                if time.monotonic() > deadline:
                    os.kill(worker.pid, signal.SIGKILL)
                time.sleep(0.02)
        self._workers = []


class _Teller:
    """A worker's plugin that says what happens to its parent."""

    def __init__(self, config: pytest.Config, pipe: Connection) -> None:
        self._config, self._pipe = config, pipe

    def pytest_runtest_logstart(self, nodeid: str, location: Location) -> None:
        self._pipe.send(("started", nodeid, location))

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        data = self._config.hook.pytest_report_to_serializable(config=self._config, report=report)
        self._pipe.send(("report", data))

    def pytest_warning_recorded(
        self, warning_message: warnings.WarningMessage, when: str, nodeid: str
    ) -> None:
        one = warning_message
        text = f"{one.category.__name__}: {one.message}"
        self._pipe.send(("warned", text, one.filename, one.lineno, when, nodeid))


def _work(session: pytest.Session, files: list[list[pytest.Item]], pipe: Connection) -> None:
    """Run the files that the parent gives, in a process that pytest and our hooks know for a worker."""
    atexit._clear()  # what the parent made is the parent's to remove
    config = session.config
    config.workerinput = {}  # type: ignore[attr-defined]  # as pytest-xdist calls it
    capture = config.pluginmanager.getplugin("capturemanager")
    if capture is not None:
        capture.stop_global_capturing()  # whose files are shared with the others
        capture.start_global_capturing()
    config.pluginmanager.unregister(name="terminalreporter")
    config.pluginmanager.register(_Teller(config, pipe))
    while True:
        pipe.send(("next",))
        share: Share | None = pipe.recv()
        if share is None:
            session.testsfailed = 0  # they have been told: its exit status is that of what ends now
            return
        items = files[share.file][share.first :]
        # what is the session's stays from file to file
        for item, following in zip_longest(items, items[1:], fillvalue=session):
            config.hook.pytest_runtest_protocol(item=item, nextitem=following)
