"""Sessions whose processes are killed: do they come to what they would have come to?

    .venv/bin/python -m tests.session.kills --sessions 300    # a random process at a random moment
    .venv/bin/python -m tests.session.kills --places          # one at each write to a file or a socket

Each session is compared with the same one undisturbed: outcome, frames bit for bit, frames taken twice,
processes and sockets that are left. Prints one JSON object a session, and one of all at the end.
"""

import argparse
import json
import os
import random
import signal
import socket
import subprocess
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from tests.session.cases import CASES, words_of
from tests.session.command import ROOT, SERVERS, alive, controller, outcome, servers_of
from tests.session.serving import KEEPING, kept_servers

VICTIMS = ("controller", "image_server", "vision_server")
VIEW = "report"
DEADLINE_S = 300.0


@dataclass
class Session:
    """One session of a case in a folder of its own, with the kill that it meets."""

    case: str
    seed: int
    folder: Path
    environment: dict[str, str] = field(default_factory=dict)
    more: tuple[str, ...] = ()

    @property
    def out(self) -> Path:
        """The run folder."""
        return self.folder / "run"

    def start(self) -> subprocess.Popen[str]:
        """Begin it, in the same folder where it came to nothing, or go on with it where it was begun."""
        (self.folder / "tmp").mkdir(parents=True, exist_ok=True)
        if begun(self.out):
            words = ["--resume", str(self.out), *(["--view"] if "--view" in CASES[self.case] else [])]
        else:
            words = [*words_of(self.case), "--seed", str(self.seed), "--out", str(self.out)]
        return subprocess.Popen(
            ["swipl", str(ROOT / "main.pl"), *words, *self.more, "--no-report"],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            env=os.environ | {"TMPDIR": str(self.folder / "tmp")} | self.environment,
        )

    def finish(self, running: subprocess.Popen[str]) -> tuple[int, str]:
        """Wait for its end and that of its servers; one that was killed is resumed."""
        said = running.communicate(timeout=DEADLINE_S)[1]
        ended = time.monotonic() + 60.0
        while servers_of(running.pid) and time.monotonic() < ended:
            time.sleep(0.02)
        if running.returncode == -signal.SIGKILL:
            self.environment.pop("LD_PRELOAD", None)
            return self.finish(self.start())
        return running.returncode, said

    def left(self, pids: set[int]) -> tuple[int, int]:
        """Processes that still run, and socket files that are still there."""
        return sum(map(alive, pids)), len(list((self.folder / "tmp").glob("lights-and-camera-*")))


def begun(out: Path) -> bool:
    """Whether a session was begun there that can be resumed."""
    journal = out / "history.pl"
    return journal.exists() and b"\n" in journal.read_bytes()


@contextmanager
def scratch() -> Iterator[Path]:
    """A folder whose path is short enough for sockets."""
    with tempfile.TemporaryDirectory(prefix="k-", ignore_cleanup_errors=True) as folder:
        yield Path(folder)


def frames(out: Path) -> dict[str, bytes]:
    """What was taken, by name."""
    return {file.stem: file.read_bytes() for file in (out / "images").glob("i*.png") if "-" not in file.stem}


@cache
def undisturbed(case: str, seed: int) -> tuple[dict[str, object], dict[str, bytes], float]:
    """Outcome and frames of a session that nobody kills, and how long one on its own servers takes."""
    with scratch() as folder:
        session = Session(case, seed, folder, more=KEEPING)
        began = time.monotonic()
        status, said = session.finish(session.start())
        assert status in (0, 3), said
        return outcome(session.out), frames(session.out), time.monotonic() - began + starting_s()


@cache
def starting_s() -> float:
    """How long it takes until a session's own servers have been started."""
    began = time.monotonic()
    assert controller("--dry-run").returncode == 0
    return time.monotonic() - began


def judged(session: Session, status: int, said: str, pids: set[int]) -> dict[str, Any]:
    """How the session compares with the undisturbed one."""
    expected, taken, _ = undisturbed(session.case, session.seed)
    found: dict[str, Any] = {"case": session.case, "seed": session.seed, "status": status}
    try:
        found["same"] = outcome(session.out) == expected
        journal = (session.out / "history.pl").read_text()
    except (OSError, ValueError):
        found["same"], journal = False, ""
    now = frames(session.out)
    captures = Counter(
        line.split("capture(")[1].split(",")[0] for line in journal.splitlines() if "capture(" in line
    )
    found["lost"] = sum(now.get(name) != pixels for name, pixels in taken.items())
    found["twice"] = sum(number - 1 for number in captures.values()) + len(now.keys() - taken.keys())
    found["strays"], found["sockets"] = session.left(pids)
    if not found["same"] or found["strays"]:
        found["said"] = said[-600:]
    return found


def killed_once(case: str, seed: int, victim: str, share: float) -> dict[str, Any]:
    """A session of which a process is killed after that share of the time that it takes."""
    duration = undisturbed(case, seed)[2]
    with scratch() as folder:
        session = Session(case, seed, folder)
        running = session.start()
        time.sleep(share * duration)
        pids = {running.pid}
        servers = servers_of(running.pid)
        pids |= set(servers.values())
        target = running.pid if victim == "controller" else servers.get(victim)
        back = None
        if target is not None and running.poll() is None:
            os.kill(target, signal.SIGKILL)
            if victim in SERVERS:
                back = back_after(running, victim, target, folder)
                pids |= set(servers_of(running.pid).values())
        status, said = session.finish(running)
        return {**judged(session, status, said, pids), "victim": victim, "share": share, "back_s": back}


def back_after(running: subprocess.Popen[str], victim: str, old: int, folder: Path) -> float | None:
    """Seconds until another process answers in place of the one killed; None where the session ends."""
    began = time.monotonic()
    while running.poll() is None and time.monotonic() < began + 60.0:
        if servers_of(running.pid).get(victim, old) != old:
            with socket.socket(socket.AF_UNIX) as probe:
                try:
                    probe.connect(str(folder / "tmp" / f"lights-and-camera-{running.pid}-{victim}"))
                    return round(time.monotonic() - began, 2)
                except OSError:
                    pass
        time.sleep(0.02)
    return None


def kill_library(folder: Path) -> Path:
    """The library that has a process kill itself, compiled."""
    library = folder / "kill_at.so"
    source = ROOT / "tests" / "equipment" / "kill_at.c"
    subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-o", str(library), str(source), "-ldl"], check=True)
    return library


def killed_at(case: str, seed: int, victim: str, library: Path, place: int | None) -> dict[str, Any]:
    """A session of which a process kills itself at a write; without a place, how many there are."""
    undisturbed(case, seed)
    with scratch() as folder:
        program = "main.pl" if victim == "controller" else f"-m {victim}"
        environment = {
            "LD_PRELOAD": str(library), "KILL_PROGRAM": program, "KILL_FLAG": str(folder / "flag"),
            "KILL_LOG": str(folder / "log"), **({} if place is None else {"KILL_AT": str(place)}),
        }  # fmt: skip
        session = Session(case, seed, folder, environment)
        running = session.start()
        status, said = session.finish(running)
        if place is None:
            return {"places": (folder / "log").stat().st_size}
        found = judged(session, status, said, {running.pid})
        return {**found, "victim": victim, "place": place, "died": (folder / "flag").exists()}


def random_kills(sessions: int, seed: int) -> Iterator[dict[str, Any]]:
    """Sessions of all cases in turn, each with its kill."""
    draw = random.Random(seed)
    for number in range(sessions):
        case = list(CASES)[number % len(CASES)]
        victims = (*VICTIMS, VIEW) if "--view" in CASES[case] else VICTIMS
        yield killed_once(case, draw.randint(1, 3), draw.choice(victims), draw.random())


def kills_at_places(case: str, every: int) -> Iterator[dict[str, Any]]:
    """One kill at every so manyth write of each process."""
    with scratch() as folder:
        library = kill_library(folder)
        for victim in VICTIMS:
            places = killed_at(case, 1, victim, library, None)["places"]
            for place in range(1, places + 1, every):
                yield {**killed_at(case, 1, victim, library, place), "of": places}


def summary(found: list[dict[str, Any]]) -> dict[str, Any]:
    """All sessions in one line."""
    back = sorted(one["back_s"] for one in found if one.get("back_s") is not None)
    return {
        "sessions": len(found),
        **{key: sum(one[key] for one in found) for key in ("same", "lost", "twice", "strays", "sockets")},
        "back_s": {"median": back[len(back) // 2], "largest": back[-1]} if back else None,
    }


def main() -> int:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--sessions", type=int, default=300, help="Sessions with a kill at a random moment.")
    parser.add_argument("--seed", type=int, default=1, help="Of cases, victims and moments.")
    parser.add_argument(
        "--places", action="store_true", help="Instead: a kill at each write of each process."
    )
    parser.add_argument("--case", choices=CASES, default="short", help="With --places: the session.")
    parser.add_argument("--every", type=int, default=1, help="With --places: only every so manyth.")
    options = parser.parse_args()
    runs = (
        kills_at_places(options.case, options.every)
        if options.places
        else random_kills(options.sessions, options.seed)
    )
    found = []
    with kept_servers():
        for one in runs:
            print(json.dumps(one), flush=True)
            found.append(one)
    total = summary(found)
    print(json.dumps(total), flush=True)
    wrong = total["same"] < total["sessions"] or any(
        total[key] for key in ("lost", "twice", "strays", "sockets")
    )
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
