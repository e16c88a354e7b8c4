"""Workers of a dask cluster: another machine's, a hundred machines', or processes of this one."""

import logging
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

from bridge.errors import BadInput, DeviceError
from experiments.computing import OtherVersion, died_row, timed_rows
from experiments.feed import Feed
from experiments.kinds import Row
from experiments.plan import Cell

CONNECT_S = 10.0  # for a scheduler to answer at first; chosen by hand
PATIENCE_S = 300.0  # for a scheduler that went away, and for a first worker; chosen by hand
POLL_S = 0.5  # between two looks at what is done, or at whether it is back; chosen by hand
AHEAD = 2  # batches for each thread of a worker: one is computed, one waits
LOCAL = "local:"


class DaskPool:
    """A cluster by the address of its scheduler, or ``local:N`` for N processes here.

    Raises
    ------
    BadInput : no such package, no such address, or nobody answers there.
    """

    def __init__(self, address: str, version: str, keep: Path | None) -> None:
        try:
            import dask.config
            import distributed
        except ImportError:
            raise BadInput(
                "--cluster needs the package distributed.", "pip install 'lights-and-camera[experiments]'"
            ) from None
        logging.getLogger("distributed").setLevel(logging.CRITICAL)  # what counts is said by messages here
        self._distributed: Any = distributed
        self._config: Any = dask.config
        self._version, self._keep = version, keep
        self._ending = ExitStack()
        self._address = address
        if address.startswith(LOCAL):
            self._address = self._local_cluster(address.removeprefix(LOCAL))
        self._client = self._connected(CONNECT_S)

    @property
    def where(self) -> str:
        """For people: where cells are computed, and what to look at."""
        return f"cluster {self._address}, dashboard {self._client.dashboard_link}"

    def rows(self, feed: Feed) -> Iterator[list[Row]]:
        """Compute what the feed gives; rows as they come. A scheduler that goes away may come back."""
        running: dict[Any, list[Cell]] = {}
        lost_since: float | None = None
        while True:
            try:
                self._supply(feed, running)
                if not running:
                    return
                finished = self._finished(running)
                lost_since = None
            except (OSError, self._distributed.CancelledError, RuntimeError) as error:
                lost_since = time.monotonic() if lost_since is None else lost_since
                self._reconnect(feed, running, lost_since, error)
                continue
            for future in finished:
                yield from self._received(future, running.pop(future), feed)

    def _supply(self, feed: Feed, running: dict[Any, list[Cell]]) -> None:
        while len(running) < self._wanted() and (batch := feed.take()):
            try:
                future = self._client.submit(timed_rows, batch, self._version, self._keep, pure=False)
            except BaseException:
                feed.give_back(batch)
                raise
            running[future] = batch

    def _wanted(self) -> int:
        """Batches to have under way; a worker that comes while it runs is given its share."""
        return max(AHEAD, AHEAD * int(sum(self._client.nthreads().values())))

    def _finished(self, running: dict[Any, list[Cell]]) -> list[Any]:
        with suppress(TimeoutError, self._distributed.TimeoutError):
            self._distributed.wait(list(running), timeout=POLL_S, return_when="FIRST_COMPLETED")
        if self._client.status != "running":
            raise OSError("the connection to the scheduler is lost")
        return [future for future in running if future.done()]

    def _received(self, future: Any, batch: list[Cell], feed: Feed) -> Iterator[list[Row]]:
        if future.status in {"cancelled", "lost"}:
            feed.give_back(batch)
            return
        error = future.exception()
        if isinstance(error, OtherVersion):
            raise DeviceError(
                f"A worker of {self._address} has version {error} of the project; this is {self._version}.",
                "Bring all machines to one version. The rows so far are safe.",
            )
        if isinstance(error, self._distributed.KilledWorker):
            if at_fault := feed.died(batch):
                yield [died_row(cell) for cell in at_fault]
            return
        if error is not None:
            raise DeviceError(f"A worker of {self._address} failed: {type(error).__name__}: {error}.")
        try:
            rows, seconds = future.result()
        except (OSError, self._distributed.CancelledError):  # the scheduler went away with them
            feed.give_back(batch)
            return
        feed.done(len(batch), seconds)
        yield rows

    def _reconnect(
        self, feed: Feed, running: dict[Any, list[Cell]], lost_since: float, error: BaseException
    ) -> None:
        """Give back what was under way, and look for the scheduler again."""
        for batch in running.values():
            feed.give_back(batch)
        running.clear()
        with suppress(Exception):
            self._client.close(timeout=1.0)
        if time.monotonic() - lost_since > PATIENCE_S:
            raise DeviceError(
                f"The scheduler at {self._address} is gone: {error}.",
                "The rows so far are safe; start it, and run the same command again.",
            )
        while True:
            try:
                self._client = self._connected(CONNECT_S)
                return
            except BadInput as refused:
                if time.monotonic() - lost_since > PATIENCE_S:
                    raise DeviceError(refused.message, "The rows so far are safe.") from None
                time.sleep(POLL_S)

    def _connected(self, timeout_s: float) -> Any:
        try:
            return self._distributed.Client(self._address, timeout=timeout_s)
        except (OSError, ValueError, TypeError, ImportError) as error:
            raise BadInput(
                f"No dask scheduler answers at {self._address}: {str(error).splitlines()[0]}.",
                "Start one (dask scheduler), or check the address: tcp://HOST:8786 or local:N.",
            ) from None

    def _local_cluster(self, count: str) -> str:
        if not count.isdecimal() or int(count) < 1:
            raise BadInput(f"--cluster {LOCAL}{count} says no number of processes.", "Write local:4.")
        scratch = self._ending.enter_context(tempfile.TemporaryDirectory(prefix="dask-"))
        self._ending.enter_context(self._config.set({"temporary-directory": scratch}))
        cluster = self._distributed.LocalCluster(
            n_workers=int(count),
            threads_per_worker=1,
            processes=True,
            dashboard_address=":0",
            silence_logs=logging.CRITICAL,
        )
        self._ending.callback(cluster.close, timeout=5.0)
        return str(cluster.scheduler_address)

    def close(self) -> None:
        """Leave the cluster; one that was started here ends."""
        with suppress(Exception):
            self._client.close(timeout=2.0)
        self._ending.close()
