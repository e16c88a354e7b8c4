"""What a run folder tells at this moment, of a session that runs or has ended."""

from __future__ import annotations

import os
import select
import subprocess
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec

from bridge.errors import BadInput
from bridge.result_file import Result, read_result
from report.holding import must_be_session, session_process, waits

JOURNAL_READER = Path(__file__).resolve().parent.parent / "session" / "journal_reader.pl"
ANSWER_S = 300.0  # of the journal's reader, for thousands of images on a busy machine; chosen by hand
WORK_NICENESS = 19  # of what follows and draws; the page answers sooner
SECONDS = "seconds.json"  # by session/times.pl


class CandidateRecord(msgspec.Struct, frozen=True):
    """Settings that could be chosen, and what was predicted of an image under them.

    Attributes
    ----------
    brightness, highlight : median and 95th percentile of the target, fractions of full scale.
    information : of the place of an edge, bit; with the likelihood's part it makes the promise.
    bits, line : what it was predicted to add to the pose, and to which model line most; or a promise.
    """

    words: str = ""
    state: str | None = None
    promise: float | None = None
    likelihood: float | None = None
    information: float | None = None
    bits: float | None = None
    line: int | None = None
    brightness: float | None = None
    highlight: float | None = None
    blur_px: float | None = None
    dark: float | None = None
    saturated: float | None = None


class ReasonRecord(msgspec.Struct, frozen=True):
    """Why the controller did something, as session/display/reasons.pl tells it: chosen, seen or measured."""

    kind: str
    chosen: CandidateRecord | None = None
    best: list[CandidateRecord] = []
    candidates: int = 0
    left_out_alike: int = 0
    left_out_unfavourable: int = 0
    quality: str = ""
    expected: CandidateRecord | None = None
    seen: CandidateRecord | None = None
    rms_px: float | None = None
    merit: float | None = None


class Action(msgspec.Struct, frozen=True):
    """An action of the journal, or what happened meanwhile, and the reason for it where there is one."""

    name: str
    text: str
    reason: ReasonRecord | None = None


class Told(msgspec.Struct, frozen=True):
    """What the controller knows, by its journal; with a `problem`, nothing else."""

    result: Result | None = None
    first: int = 0  # number of the first of these actions, from 0
    actions: list[Action] = []
    left: str = ""
    controller_file: str | None = None
    problem: str = ""
    spent_s: float = 0.0  # of the processor, by the journal's reader since it began


@dataclass(frozen=True)
class State:
    """A session at one moment.

    Attributes
    ----------
    result : so far, or the final one.
    status : running, paused, interrupted or that of the result.
    told : what the journal tells.
    age_s : since the session began; None where that is not known.
    """

    result: Result
    status: str
    told: Told = field(default_factory=Told)
    age_s: float | None = None

    @property
    def ended(self) -> bool:
        """Whether it has come to a result that can be read."""
        return self.status not in ("running", "paused", "interrupted", "broken")

    @property
    def runs(self) -> bool:
        """Whether the session can still be told to do something."""
        return self.status in ("running", "paused")


class Journal:
    """The reader of a folder's journal, a process of its own: the controller's theory is Prolog.

    Parameters
    ----------
    folder : the run folder.
    every_reason : tell the reason of each decision; otherwise of the newest of each kind in an answer.
    """

    def __init__(self, folder: Path, every_reason: bool = False) -> None:
        self._folder = folder
        self._reasons = "every" if every_reason else "newest"
        self._process: subprocess.Popen[bytes] | None = None
        self._actions: list[Action] = []
        self.spent_s = 0.0

    def start(self) -> None:
        """Start the reader, which is ready sooner then when it is asked; may be called twice."""
        if self._process is None:
            self._process = subprocess.Popen(
                ["swipl", str(JOURNAL_READER), str(self._folder), self._reasons],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
            )  # fmt: skip
            os.setpriority(os.PRIO_PROCESS, self._process.pid, WORK_NICENESS)

    def ask(self) -> Told:
        """What the journal tells now, nothing where there is none; without its reader a problem is told."""
        if not (self._folder / "history.pl").is_file():
            return Told()
        try:
            return self._answer()
        except (OSError, ValueError, msgspec.MsgspecError) as error:
            self.close()
            return Told(problem=f"The journal cannot be followed ({error}).")

    def close(self) -> None:
        """End the reader; may be called twice."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.communicate()

    def _answer(self) -> Told:
        self.start()
        assert self._process is not None
        asked, answers = self._process.stdin, self._process.stdout
        assert asked is not None and answers is not None
        asked.write(b"\n")
        asked.flush()
        deadline = time.monotonic() + ANSWER_S
        line = b""
        while not line.endswith(b"\n"):
            if not select.select([answers], [], [], max(0.0, deadline - time.monotonic()))[0]:
                raise ValueError(f"its reader has not answered within {ANSWER_S:g} s")
            part = os.read(answers.fileno(), 1 << 20)
            if not part:
                raise ValueError("its reader has ended; is swipl installed?")
            line += part
        told = msgspec.json.decode(line, type=Told)
        self._actions = [*self._actions[: told.first], *told.actions]
        self.spent_s = max(self.spent_s, told.spent_s)
        return msgspec.structs.replace(told, first=0, actions=self._actions)


class Follower:
    """A run folder that is looked at again and again.

    Raises
    ------
    BadInput : no such folder, or none of a session.
    """

    def __init__(self, folder: Path) -> None:
        must_be_session(folder)
        self.folder = folder
        self._journal = Journal(folder)
        self._seen: Any = None

    def look(self) -> State | None:
        """The session as it is now; None where nothing has changed since the last look."""
        seen = self._signature()
        if seen == self._seen:
            return None
        self._seen = seen
        waiting = waits(self.folder)  # before the journal is read: what led here is in it
        told = self._journal.ask()
        if self._has_result():
            try:
                result = read_result(self.folder)
            except BadInput as error:
                return State(Result(status="broken", message=str(error)), "broken", told)
            return State(result, result.status, told)
        result = told.result or Result(status="running")
        status = "paused" if waiting else "running"
        if session_process(self.folder) is None:
            status = "interrupted"
        result = msgspec.structs.replace(result, status=status, seconds=self._seconds())
        return State(result, status, told, self._age_s())

    def _seconds(self) -> dict[str, float | None]:
        """Where the time went so far, as a session with a view tells it."""
        try:
            return msgspec.json.decode((self.folder / SECONDS).read_bytes(), type=dict[str, float | None])
        except (OSError, msgspec.MsgspecError):
            return {}

    @property
    def spent_s(self) -> float:
        """Seconds of the processor that reading the journal took so far."""
        return self._journal.spent_s

    def close(self) -> None:
        """End what was started; may be called twice."""
        self._journal.close()

    def _signature(self) -> Any:
        """What changes when there is something new to see."""
        files = [self.folder / name for name in ("history.pl", "result.json", "held", "session.pl", SECONDS)]
        files += sorted((self.folder / "images").glob("*.*"))
        stats = [(file.name, *_changed(file)) for file in files]
        return stats, session_process(self.folder)

    def _has_result(self) -> bool:
        """Whether there is a result, and not one from before the session was resumed."""
        written, size = _changed(self.folder / "result.json")
        old = session_process(self.folder) is not None and written < _changed(self.folder / "history.pl")[0]
        return size > 0 and not old

    def _age_s(self) -> float | None:
        changed, _ = _changed(self.folder / "session.pl")
        return time.time() - changed if changed else None


def _changed(file: Path) -> tuple[float, int]:
    try:
        stat = file.stat()
    except OSError:
        return 0.0, 0
    return stat.st_mtime, stat.st_size
