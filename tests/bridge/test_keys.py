"""Folders of CURVE keys, from the command that makes them to servers that use them."""

import stat
import subprocess
import sys
from pathlib import Path

import pytest

from bridge.client import Client
from bridge.errors import BadInput, BridgeRefused
from bridge.keys import client_keys, make_keys, server_keys
from bridge.serve import Server

from .conftest import Counter, Running


@pytest.fixture
def keys(tmp_path: Path) -> Path:
    folder = tmp_path / "keys"
    make_keys(folder)
    return folder


def test_the_programs_of_a_folder_reach_each_other_and_nobody_else_does(keys: Path, tmp_path: Path) -> None:
    service = Counter()
    curve = server_keys(keys, "image_server")
    running = Running(service, Server(service, "tcp://0.0.0.0:*", curve=curve))
    port = running.endpoint.rpartition(":")[2]
    endpoint = f"tcp://127.0.0.1:{port}"
    make_keys(tmp_path / "others")
    try:
        for name in ("vision_server", "controller"):
            with Client(endpoint, timeout_s=60, curve=client_keys(keys, name, "image_server")) as client:
                client.request("count")
        stranger = client_keys(tmp_path / "others", "controller", "image_server")
        with (
            Client(endpoint, timeout_s=0.5, retries=20, curve=stranger) as client,
            pytest.raises(BridgeRefused),
        ):
            client.request("count")
        assert service.count == 2
    finally:
        running.stop()


def test_secrets_are_for_their_owner_only(keys: Path) -> None:
    secret = keys / "controller.key_secret"
    assert stat.S_IMODE(secret.stat().st_mode) == 0o600
    secret.chmod(0o644)
    with pytest.raises(BadInput, match=rf"Others can read {secret}.*chmod 600"):
        client_keys(keys, "controller", "image_server")


def test_keys_that_cannot_be_used_say_which(keys: Path, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="is not empty"):
        make_keys(keys)
    with pytest.raises(
        BadInput, match=rf"No key in {tmp_path}/image_server.key_secret: .*python -m bridge keys"
    ):
        server_keys(tmp_path, "image_server")
    (keys / "image_server.key").write_text("nothing\n")
    with pytest.raises(BadInput, match=rf"No key in {keys}/image_server.key: it is not"):
        client_keys(keys, "controller", "image_server")
    secret = keys / "vision_server.key_secret"
    secret.write_text((keys / "vision_server.key").read_text())
    with pytest.raises(BadInput, match=rf"{secret} holds no secret key"):
        server_keys(keys, "vision_server")


def test_the_command_makes_them_once(tmp_path: Path) -> None:
    def run() -> "subprocess.CompletedProcess[str]":
        return subprocess.run(
            [sys.executable, "-m", "bridge", "keys", str(tmp_path / "keys")],
            capture_output=True, text=True, check=False, timeout=240,
        )  # fmt: skip

    made = run()
    assert made.returncode == 0
    assert len(made.stdout.splitlines()) == 6
    again = run()
    assert again.returncode == 2
    assert "is not empty" in again.stderr
