"""Sessions whose servers are reached with CURVE keys: own ones, and servers on a network."""

import json
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from bridge.keys import make_keys
from tests.session.command import DEADLINE_S, ROOT, controller
from tests.session.scenes import small

pytestmark = pytest.mark.slow


@pytest.fixture
def keys(tmp_path: Path) -> Path:
    folder = tmp_path / "keys"
    make_keys(folder)
    return folder


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("", 0))
        return int(probe.getsockname()[1])


@pytest.fixture(scope="module")
def network_keys(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The keys of the servers on a network."""
    folder = tmp_path_factory.mktemp("network") / "keys"
    make_keys(folder)
    return folder


@pytest.fixture(scope="module")
def network(network_keys: Path) -> Iterator[tuple[str, str]]:
    """Both servers on every interface of this machine; their endpoints as a client calls them."""
    image, events, vision = free_port(), free_port(), free_port()
    commands = [
        ["image_server", "simulator", "--scenario", str(small("turning-sun")), "--seed", "1",
         "--endpoint", f"tcp://0.0.0.0:{image}", "--events", f"tcp://0.0.0.0:{events}"],
        ["vision_server", "serve", "--endpoint", f"tcp://0.0.0.0:{vision}"],
    ]  # fmt: skip
    running = [
        subprocess.Popen([sys.executable, "-m", *command, "--keys", str(network_keys)], cwd=ROOT)
        for command in commands
    ]
    yield f"tcp://127.0.0.1:{image}", f"tcp://127.0.0.1:{vision}"
    for process in running:
        process.terminate()
        process.wait(timeout=DEADLINE_S)


def test_servers_on_a_network_serve_who_has_a_key(
    network: tuple[str, str], network_keys: Path, tmp_path: Path
) -> None:
    image, vision = network
    out = tmp_path / "run"
    done = controller(
        "--image-server", image, "--vision-server", vision, "--keys", network_keys,
        "--out", out, "--no-report",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert json.loads((out / "result.json").read_text())["status"] == "converged"


def test_wrong_keys_are_said_and_not_waited_for(network: tuple[str, str], tmp_path: Path) -> None:
    image, vision = network
    others = tmp_path / "others"
    make_keys(others)
    for keys in (["--keys", others], []):
        done = controller(
            "--image-server", image, "--vision-server", vision, *keys, "--out", tmp_path / "run"
        )
        assert done.returncode == 2, done.stderr
        assert "does not let this client in" in done.stderr
        assert "--keys" in done.stderr


def test_a_session_gives_its_own_servers_the_keys(keys: Path, tmp_path: Path) -> None:
    options = ("--keys", keys, "--scenario", small(), "--out", tmp_path / "run", "--no-report", "--quiet")
    done = controller(*options)
    assert done.returncode == 0, done.stderr


def test_without_keys_a_network_is_refused(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "image_server", "simulator", "--endpoint", "tcp://0.0.0.0:*"],
        capture_output=True, text=True, check=False, timeout=240, cwd=ROOT,
    )  # fmt: skip
    assert done.returncode == 2
    assert "can be reached from the network and has no CURVE keys. Use 127.0.0.1, or" in done.stderr


def test_keys_that_are_missing_are_named(keys: Path, tmp_path: Path) -> None:
    missing = keys / "controller.key_secret"
    missing.unlink()
    done = controller("--keys", keys, "--out", tmp_path / "run", "--no-report")
    assert done.returncode == 2
    assert f"{missing}" in done.stderr and "python -m bridge keys" in done.stderr
    assert "--keys: no folder" in controller("--keys", tmp_path / "none").stderr


def test_a_secret_that_others_can_read_is_refused(keys: Path, tmp_path: Path) -> None:
    secret = keys / "controller.key_secret"
    secret.chmod(0o644)
    done = controller("--keys", keys, "--out", tmp_path / "run")
    assert (done.returncode, done.stdout) == (2, "")
    assert f"others can read {secret}, which is a secret: chmod 600" in done.stderr
