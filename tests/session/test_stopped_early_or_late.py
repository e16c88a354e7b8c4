"""A session that is stopped before its first action leaves nothing; one after its last, what it has found."""

import json
import os
import signal
import subprocess
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from bridge.image_messages import PoseErrorMessage
from bridge.messages import PoseMessage
from bridge.serve import Server
from image_server.serve.server import ImageServer
from image_server.simulator.scenario import load_scenario
from image_server.simulator.simulator import Simulator
from tests.session.command import DEADLINE_S, controller, refused, start_controller
from tests.session.scenes import small

pytestmark = pytest.mark.slow


class Stopping(Simulator):
    """Is asked how good a pose was when a session has done its last action, and stops that session."""

    session: "subprocess.Popen[str] | None" = None

    def score(self, pose: PoseMessage, moves: int | None = None) -> PoseErrorMessage:
        """The error; the first to ask is sent Ctrl-C before it hears it."""
        if self.session is not None:
            os.kill(self.session.pid, signal.SIGINT)
            self.session = None
        return super().score(pose, moves)


@pytest.fixture
def device() -> Iterator[tuple[Stopping, str]]:
    shown = Stopping("cube", load_scenario(str(small())), 1)
    with tempfile.TemporaryDirectory(prefix="e-") as folder:
        server = Server(ImageServer(shown), f"ipc://{folder}/s")
        serving = threading.Thread(target=server.run)
        serving.start()
        yield shown, server.endpoint
        server.stop()
        serving.join()


def test_what_was_found_is_kept_and_the_session_can_go_on(
    device: tuple[Stopping, str], tmp_path: Path
) -> None:
    shown, endpoint = device
    out = tmp_path / "run"
    session = start_controller("--image-server", endpoint, "--out", out, "--no-report")
    shown.session = session
    said, messages = session.communicate(timeout=DEADLINE_S)
    assert session.returncode == 130, messages
    result = json.loads((out / "result.json").read_text())
    assert (result["status"], result["iterations"]) == ("stopped", 2) and result["pose"] is not None
    assert "Stopped after 2 images" in said and f"--resume {out}" in messages
    assert {file.name for file in out.iterdir()} >= {"history.pl"} and not list(out.glob("*.new"))
    resumed = controller("--resume", out, "--no-report")
    assert resumed.returncode == 0, resumed.stderr
    whole = json.loads((out / "result.json").read_text())
    assert (whole["status"], whole["iterations"], whole["pose"]) == ("converged", 2, result["pose"])
    finished = " ".join(refused("--resume", out).split())
    page = f".venv/bin/python -m report {out} writes its page"
    assert f"is finished; its outcome is in result.json there, and {page}" in finished


@pytest.mark.parametrize(("sent", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_while_it_is_loaded_it_leaves_nothing(tmp_path: Path, sent: signal.Signals, status: int) -> None:
    out = tmp_path / "run"
    session = start_controller("--out", out)
    while not (out / "session.pl").exists():
        assert session.poll() is None, session.communicate()
        time.sleep(0.001)
    session.send_signal(sent)
    said, messages = session.communicate(timeout=DEADLINE_S)
    assert (session.returncode, said, messages) == (status, "", "")
    assert not out.exists()
