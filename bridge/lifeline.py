"""What ends a program from outside: a signal; of a server its parent's death or another thread."""

import os
import select
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from threading import Event, Thread, current_thread, main_thread
from types import FrameType
from typing import Any, NoReturn

GRACE_S = 2.0
"""How long a handler may go on after the end was asked for."""


class Lifeline:
    """File descriptors that become readable when a server should end.

    Parameters
    ----------
    parent_pid
        End when this process does.
    signals
        End on SIGTERM and SIGINT (SIGINT is ignored where there is a parent); in the main thread only.
    """

    def __init__(self, parent_pid: int | None = None, signals: bool = False) -> None:
        self.status = 0
        self._stopped = False
        self._closed = Event()
        self._wake_read, self._wake_write = os.pipe()
        os.set_blocking(self._wake_write, False)
        self._parent: int | None = None
        self._restore: list[Callable[[], Any]] = []
        self._watch: Thread | None = None
        if signals and current_thread() is main_thread():
            self._take_signals(parent_pid is not None)
        if parent_pid is not None:
            try:
                self._parent = os.pidfd_open(parent_pid)
            except ProcessLookupError:
                self.stop(0)

    def _take_signals(self, has_parent: bool) -> None:
        # The wake-up descriptor is written by the C handler, so no signal is lost between two polls.
        old_fd = signal.set_wakeup_fd(self._wake_write, warn_on_full_buffer=False)
        self._restore.append(partial(signal.set_wakeup_fd, old_fd))
        interrupt: Any = signal.SIG_IGN if has_parent else self._on_signal
        for signum, handler in ((signal.SIGTERM, self._on_signal), (signal.SIGINT, interrupt)):
            old = signal.signal(signum, handler)
            self._restore.append(partial(signal.signal, signum, old))

    def _on_signal(self, signum: int, frame: FrameType | None) -> None:
        self.stop(128 + signum)

    def filenos(self) -> list[int]:
        """Descriptors to poll; never read them, they stay readable."""
        return [self._wake_read] if self._parent is None else [self._wake_read, self._parent]

    def stop(self, status: int) -> None:
        """End with this exit status; the first word counts."""
        if not self._stopped:
            self._stopped = True
            self.status = status
            with suppress(OSError):
                os.write(self._wake_write, b"\0")

    def ended(self) -> bool:
        """Whether the server should end."""
        return self._stopped or (self._parent is not None and bool(_readable([self._parent], 0)))

    def enforce(self, *endpoints: str | None) -> None:
        """From now on end the whole process when a handler outlives the grace; ipc sockets are removed."""
        from bridge.endpoints import remove_ipc_file  # late: who has no sockets of ZeroMQ need not load it

        self._watch = Thread(
            target=self._enforce, args=(endpoints, remove_ipc_file), name="lifeline", daemon=True
        )
        self._watch.start()

    def _enforce(self, endpoints: tuple[str | None, ...], remove: Callable[[str], None]) -> None:
        _readable(self.filenos(), None)
        if self._closed.wait(GRACE_S):
            return
        for endpoint in endpoints:
            if endpoint is not None:
                remove(endpoint)
        if not self._stopped and _readable([self._wake_read], 0):
            # The signal arrived, but the interpreter has not come round to its handler yet.
            self.status = 128 + os.read(self._wake_read, 1)[0]
        os._exit(self.status)

    def close(self) -> None:
        """Give the signals back and close the descriptors."""
        if self._closed.is_set():
            return
        self._closed.set()
        self.stop(0)
        for restore in reversed(self._restore):
            restore()
        if self._watch is not None:
            self._watch.join()
        os.close(self._wake_read)
        os.close(self._wake_write)
        if self._parent is not None:
            os.close(self._parent)


def leave_at_signals() -> None:
    """From now on SIGINT and SIGTERM end the process at once and without a word, as a shell's 130 and 143.

    An exception out of a handler, as KeyboardInterrupt, may meet a compiled kernel, which it crashes, or a
    library that catches it. What has to be finished first has handlers of its own: `Lifeline`, `Stopping`. A
    signal that whoever started this has ignored stays so.

    The interpreter calls a handler when it comes round to it: not while compiled code runs, nor where the
    signal came just before a read that waits for ever. So a thread hears of it, too.
    """
    for signum in (signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(signum) != signal.SIG_IGN:
            signal.signal(signum, _leave_by)
    heard, told = os.pipe()
    os.set_blocking(told, False)
    signal.set_wakeup_fd(told, warn_on_full_buffer=False)  # written by the C handler
    os.register_at_fork(after_in_child=partial(signal.set_wakeup_fd, -1))  # what a copy is told is its own
    Thread(target=_leave_when_told, args=(heard,), name="signals", daemon=True).start()


def _leave_by(signum: int, _: FrameType | None) -> None:
    os._exit(128 + signum)


def _leave_when_told(heard: int) -> None:
    while True:
        signum = os.read(heard, 1)[0]
        if signal.getsignal(signum) is _leave_by:  # no other handler has taken its place
            _leave_by(signum, None)


def _readable(descriptors: list[int], timeout_ms: int | None) -> list[tuple[int, int]]:
    poll = select.poll()
    for descriptor in descriptors:
        poll.register(descriptor, select.POLLIN)
    return poll.poll(timeout_ms)


def leave(status: int) -> NoReturn:
    """End the process when all that counts is closed.

    Taking apart an interpreter that has loaded numba takes a third of a second, and who asked for the end
    would wait for it.
    """
    if "logging" in sys.modules:  # who has not loaded it has logged nothing
        sys.modules["logging"].shutdown()
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError):  # `run_command` has said so
            stream.flush()
    os._exit(status)
