"""Running `swipl main.pl` in tests."""

import os
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DEADLINE_S = 120.0


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
    """Start a session and leave it running."""
    return subprocess.Popen(
        ["swipl", str(ROOT / "main.pl"), *map(str, options)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        stdin=subprocess.DEVNULL,
    )


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
