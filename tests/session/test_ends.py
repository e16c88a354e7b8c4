"""However a session ends, nothing is left running and the exit status says what happened."""

import json
import os
import signal
from pathlib import Path

import pytest

from tests.session.command import SERVERS, gone, running_session

pytestmark = pytest.mark.slow

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
