"""Running `swipl main.pl` in tests, and what is asked of its run folder."""

import json
import os
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

from tests.session.scenes import small

ROOT = Path(__file__).resolve().parents[2]
DEADLINE_S = 240.0
SERVERS = {"image_server", "vision_server"}
STARTED: list[subprocess.Popen[str]] = []


def controller(
    *options: str | Path, cwd: Path | None = None, deadline_s: float = DEADLINE_S
) -> subprocess.CompletedProcess[str]:
    """Run one session to its end."""
    return subprocess.run(
        ["swipl", str(ROOT / "main.pl"), *map(str, options)],
        capture_output=True,
        text=True,
        timeout=deadline_s,
        cwd=cwd,
        stdin=subprocess.DEVNULL,
        check=False,
    )


def start_controller(*options: str | Path) -> subprocess.Popen[str]:
    """Start a session and leave it running; it ends with the test at the latest."""
    session = subprocess.Popen(
        ["swipl", str(ROOT / "main.pl"), *map(str, options)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        stdin=subprocess.DEVNULL,
    )
    STARTED.append(session)
    return session


def end_sessions() -> None:
    """End those that a test has left running, as one that fails does; their servers end with them."""
    while STARTED:
        session = STARTED.pop()
        session.kill()  # nothing where it has ended
        session.wait()


def servers_of(parent: int) -> dict[str, int]:
    """Process ids of the servers that were started for this controller, by module name."""
    found = {}
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            words = (entry / "cmdline").read_bytes().split(b"\0")
        except OSError:
            continue
        if b"--parent" in words and words[words.index(b"--parent") + 1] == str(parent).encode():
            module = words[words.index(b"-m") + 1].decode() if b"-m" in words else words[0].decode()
            found[module] = int(entry.name)
    return found


def alive(pid: int) -> bool:
    """Is this process running (a zombie is not)?"""
    try:
        os.kill(pid, 0)
        return "\nState:\tZ" not in Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return False


def running_session(out: Path, report: bool = False) -> tuple[subprocess.Popen[str], dict[str, int]]:
    """A session that cannot converge, with both servers up and at least one image taken."""
    session = start_controller(
        "--out", out, "--scenario", small(), "--controller", "greedy", "--threshold", "0.000001",
        "--max-iterations", "1000", *([] if report else ["--no-report"]),
    )  # fmt: skip
    captured(session, out, "i1")
    servers = servers_of(session.pid)
    assert set(servers) == SERVERS
    return session, servers


def captured(session: subprocess.Popen[str], out: Path, image: str) -> None:
    """Wait until the session's journal has this image."""
    deadline = time.monotonic() + DEADLINE_S
    journal = out / "history.pl"
    while not (journal.exists() and f"capture({image}," in journal.read_text()):
        assert session.poll() is None, session.communicate()
        assert time.monotonic() < deadline, f"the session did not take {image}"
        time.sleep(0.02)


def outcome(out: Path) -> dict[str, object]:
    """All that a session came to, but for times and how it was called."""
    result = json.loads((out / "result.json").read_text())
    return {key: value for key, value in result.items() if key not in {"seconds", "command"}}


def steps_of(out: Path) -> list[tuple[object, ...]]:
    """What the session did and found, image by image."""
    steps = json.loads((out / "result.json").read_text())["steps"]
    return [(s["image"], str(s["settings"]), s["decision"], s["set_size"], s["rms_px"]) for s in steps]


def cut(journal: Path, after: str) -> None:
    """Keep the journal up to and with the first line that holds this."""
    lines = journal.read_text().splitlines(keepends=True)
    last = next(number for number, line in enumerate(lines) if after in line)
    journal.write_text("".join(lines[: last + 1]))


def end_after(journal: Path, images: int) -> None:
    """Let a `running_session` end after fewer images when it goes on: the journal tells its limit."""
    text = journal.read_text()
    assert ",1000))" in text
    journal.write_text(text.replace(",1000))", f",{images}))"))


def gone(pids: dict[str, int], within_s: float = DEADLINE_S) -> bool:
    """Do all these processes end within the time?"""
    deadline = time.monotonic() + within_s
    while any(alive(pid) for pid in pids.values()):
        if time.monotonic() > deadline:
            return False
        time.sleep(0.05)
    return True


def refused(*options: str | Path, by: Callable[..., subprocess.CompletedProcess[str]] = controller) -> str:
    """Run with bad options; returns the message after checking that it is short and the status is 2."""
    done = by(*options)
    assert done.returncode == 2, done.stderr
    lines = [line for line in done.stderr.strip().splitlines() if "  waiting for the" not in line]
    assert 1 <= len(lines) <= 4, done.stderr
    assert "Traceback" not in done.stderr
    return done.stderr
