"""However a session ends, nothing is left running and the exit status says what happened."""

import json
import os
import signal
import subprocess
import time
from pathlib import Path

import pytest

from tests.session.command import alive, servers_of, start_controller

pytestmark = pytest.mark.slow

SERVERS = {"image_server", "vision_server"}


def running_session(out: Path) -> tuple[subprocess.Popen[str], dict[str, int]]:
    """A session that cannot converge, with both servers up and at least one image taken."""
    session = start_controller(
        "--out", out, "--threshold", "0.000001", "--max-iterations", "1000", "--no-report"
    )
    deadline = time.monotonic() + 60
    journal = out / "history.pl"
    while not (journal.exists() and "capture" in journal.read_text()):
        assert session.poll() is None, session.communicate()
        assert time.monotonic() < deadline, "the session did not take an image"
        time.sleep(0.05)
    servers = servers_of(session.pid)
    assert set(servers) == SERVERS
    return session, servers


def gone(pids: dict[str, int], within_s: float) -> bool:
    """Do all these processes end within the time?"""
    deadline = time.monotonic() + within_s
    while any(alive(pid) for pid in pids.values()):
        if time.monotonic() > deadline:
            return False
        time.sleep(0.05)
    return True


@pytest.mark.parametrize(("sent", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_stopped_by_signal(tmp_path: Path, sent: signal.Signals, status: int) -> None:
    session, servers = running_session(tmp_path)
    session.send_signal(sent)
    _, messages = session.communicate(timeout=30)
    assert session.returncode == status
    assert "Stopped" in messages
    assert gone(servers, 5)
    assert json.loads((tmp_path / "result.json").read_text())["status"] == "stopped"


@pytest.mark.parametrize("victim", sorted(SERVERS))
def test_killed_server(tmp_path: Path, victim: str) -> None:
    session, servers = running_session(tmp_path)
    os.kill(servers[victim], signal.SIGKILL)
    _, messages = session.communicate(timeout=60)
    assert session.returncode == 4, messages
    assert victim in messages
    assert gone(servers, 5)
    assert (tmp_path / "history.pl").exists()


def test_killed_controller(tmp_path: Path) -> None:
    session, servers = running_session(tmp_path)
    session.kill()
    session.communicate(timeout=10)
    assert gone(servers, 5)
