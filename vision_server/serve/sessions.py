"""The sessions of a vision server: one for each client, few at a time, and why one has ended."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Lock

from bridge.client import Client
from bridge.errors import BadInput, ProtocolError
from vision_server.serve.task import PoseTask

MOST_SESSIONS = 4  # at a time; each holds its images, some 10 MB for one of 640 x 480
TAKEN = "another one writes to its folder now"
REMEMBERED_ENDS = 256  # sessions whose clients can be told why they have none any more


class Session:
    """The task of one client, and its image server; used by who holds ``lock``."""

    def __init__(self, task: PoseTask, client: Client | None) -> None:
        self.task, self.client = task, client
        self.lock = Lock()
        self.over = False

    def writes_to(self, out: str) -> bool:
        """Whether this session records into the same folder."""
        recorder = self.task.recorder
        return recorder is not None and recorder.out.resolve() == Path(out).resolve()

    def close(self) -> None:
        """Write what is left, and let go of the image server."""
        self.over = True
        if self.task.recorder is not None:
            self.task.recorder.close()
        if self.client is not None:
            self.client.close()


class Sessions:
    """Sessions by the name of their client; from any thread."""

    def __init__(self) -> None:
        self._guard = Lock()  # of the next two
        self._sessions: OrderedDict[str, Session] = OrderedDict()  # longest idle first
        self._ends: OrderedDict[str, str] = OrderedDict()  # why a client has no session any more

    def begin(self, client: str, session: Session) -> None:
        """The client's session from now on, in place of the one that it had."""
        self.end(client, "")
        with self._guard:
            self._sessions[client] = session
            self._ends.pop(client, None)

    def end(self, client: str, why: str) -> None:
        """End a client's session, if it has one, once it is not at work."""
        with self._guard:
            session = self._sessions.pop(client, None)
            if session is None:
                return
            self._ends[client] = why
            if len(self._ends) > REMEMBERED_ENDS:
                self._ends.popitem(last=False)
        with session.lock:
            session.close()

    def end_all(self) -> None:
        """End all of them."""
        for client in list(self._sessions):
            self.end(client, "")

    def make_room(self, client: str, out: str | None) -> None:
        """End the client's own session, those that write to the same folder, and the longest idle of many.

        Raises
        ------
        BadInput
            There are as many as there may be, and all are at work.
        """
        self.end(client, "")
        with self._guard:
            here = [other for other, session in self._sessions.items() if out and session.writes_to(out)]
            idle = [other for other, session in self._sessions.items() if not session.lock.locked()]
            full = len(self._sessions) - len(here) >= MOST_SESSIONS
        if full and not idle:
            raise BadInput("All sessions of this vision server are at work.", "Ask again later.")
        for other in here:
            self.end(other, TAKEN)
        if full:
            self.end(idle[0], f"of {MOST_SESSIONS} sessions it was idle for longest")

    @contextmanager
    def of(self, client: str) -> Iterator[Session]:
        """The client's session, for itself.

        Raises
        ------
        BadInput
            Another session has taken its folder.
        ProtocolError
            It has none, or none any more.
        """
        with self._guard:
            session = self._sessions.get(client)
            if session is not None:
                self._sessions.move_to_end(client)
            why = self._ends.get(client, "")
        if session is not None:
            with session.lock:
                if not session.over:
                    yield session
                    return
        if why == TAKEN:
            raise BadInput(f"This client has no session any more: {why}.", "Stop one of the two.")
        raise ProtocolError(
            "no_session",
            f"This client has no session on this vision server{why and ': ' + why}.",
            "Send start first, or restore.",
        )
