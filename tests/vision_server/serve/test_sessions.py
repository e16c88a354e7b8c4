"""Whose session it is, what it may read and write, and when it has none."""

import os
import socket
import threading
import time
from contextlib import suppress
from pathlib import Path

import pytest

from bridge.client import Client
from bridge.errors import ServerError
from bridge.messages import Settings
from image_server.serve.device import Frame
from image_server.simulator.simulator import Simulator
from tests.commands import process
from tests.vision_server.serve.running import SETTINGS, Running, asked
from vision_server.serve.files import Files
from vision_server.serve.server import VisionServer
from vision_server.serve.sessions import MOST_SESSIONS


def test_nothing_works_before_start_and_bad_starts_are_named(
    vision: Client, images: Running, tmp_path: Path
) -> None:
    for op, args in (("best", {}), ("estimate", {"images": ["i1"]}), ("discard", {"image": "i1"})):
        with pytest.raises(ServerError, match="start"):
            asked(vision, op, **args)
    with pytest.raises(ServerError, match=r"nowhere\.cao"):
        asked(vision, "start", image_server=images.endpoint, model=str(tmp_path / "nowhere.cao"))
    (tmp_path / "pose.toml").write_text(
        "[target.seed_pose]\nrotation_vector = [0, nan, 0]\ntranslation = [0, 0, 1]"
    )
    with pytest.raises(ServerError, match="finite"):
        asked(vision, "start", image_server=images.endpoint, seed_pose_file=str(tmp_path / "pose.toml"))
    (tmp_path / "file").write_text("")
    with pytest.raises(ServerError, match="file"):
        asked(vision, "start", image_server=images.endpoint, out=str(tmp_path / "file"))
    with pytest.raises(ServerError):
        asked(vision, "best")


@pytest.mark.parametrize(("root", "why"), [("nowhere", "is not there"), (__file__, "is a file")])
def test_a_root_that_is_no_folder_is_refused(tmp_path: Path, root: str, why: str) -> None:
    done = process("vision_server", "serve", "--endpoint", f"ipc://{tmp_path}/v", "--root", root)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == f"vision_server: --root {root} {why}. Name a folder.\n"


def test_only_regular_files_under_the_roots_are_read_and_written(
    sockets: Path, images: Running, tmp_path: Path
) -> None:
    allowed, elsewhere = tmp_path / "allowed", tmp_path / "elsewhere"
    for folder in (allowed, elsewhere):
        folder.mkdir()
        (folder / "file.toml").write_text("x = 1")
    (allowed / "link.toml").symlink_to(elsewhere / "file.toml")
    os.mkfifo(allowed / "pipe.toml")
    with (allowed / "large.toml").open("wb") as large:
        large.truncate(1 << 30)
    running = Running(VisionServer(files=Files((allowed,), images.endpoint)), f"ipc://{sockets}/rooted")
    try:
        with Client(running.endpoint, timeout_s=60) as client:
            for args, said in (
                ({"camera_file": str(elsewhere / "file.toml")}, "outside of the folders"),
                ({"camera_file": str(allowed / ".." / "elsewhere" / "file.toml")}, "outside"),
                ({"seed_pose_file": str(allowed / "link.toml")}, "outside"),
                ({"model": str(elsewhere / "file.toml")}, "outside"),
                ({"out": str(elsewhere)}, "outside"),
                ({"out": str(allowed / "..")}, "outside"),
                ({"camera_file": "/dev/zero"}, "outside"),
                ({"out": str(allowed / ("[" * 2000))}, "cannot be a file"),
                ({"camera_file": str(allowed / "pipe.toml")}, "not a regular file"),
                ({"model": str(allowed / "large.toml")}, "at most"),
            ):
                with pytest.raises(ServerError, match=said):
                    asked(client, "start", image_server=images.endpoint, **args)
            with pytest.raises(ServerError, match="outside"):
                asked(client, "restore", image_server=images.endpoint, out=str(elsewhere))
            asked(client, "start", image_server=images.endpoint, out=str(allowed))
            asked(client, "capture", image="i1", settings=SETTINGS)
            with pytest.raises(ServerError, match="has frames already"):
                asked(client, "start", image_server=images.endpoint, out=str(allowed))
    finally:
        running.stop()


def test_a_model_is_read_wherever_only_the_servers_own_image_server_says_so(
    sockets: Path, images: Running, tmp_path: Path
) -> None:
    running = Running(VisionServer(files=Files((tmp_path,), "ipc:///another")), f"ipc://{sockets}/rooted")
    try:
        with Client(running.endpoint, timeout_s=60) as client, pytest.raises(ServerError, match="outside"):
            asked(client, "start", image_server=images.endpoint)
    finally:
        running.stop()


def test_each_client_has_a_session_of_its_own(vision: Client, images: Running, tmp_path: Path) -> None:
    asked(vision, "start", image_server=images.endpoint, seed=1)
    asked(vision, "capture", image="i1", settings=SETTINGS)
    with Client(vision.endpoint, timeout_s=60) as other:
        with pytest.raises(ServerError, match="no session on this"):
            asked(other, "estimate", images=["i1"])
        asked(other, "start", image_server=images.endpoint, seed=2)
        asked(other, "capture", image="i1", settings=SETTINGS)
        assert asked(other, "parameters")["seed"] == 2
    assert asked(vision, "parameters")["seed"] == 1
    assert asked(vision, "estimate", images=["i1"])["pose"] is not None
    asked(vision, "end")
    with pytest.raises(ServerError, match="no session"):
        asked(vision, "best")


def test_a_session_that_has_to_go_is_told_why(vision: Client, images: Running, tmp_path: Path) -> None:
    asked(vision, "start", image_server=images.endpoint, out=str(tmp_path))
    with Client(vision.endpoint, timeout_s=60) as other:
        asked(other, "restore", image_server=images.endpoint, out=str(tmp_path))
        with pytest.raises(ServerError, match="another one writes to"):
            asked(vision, "best")
        asked(vision, "start", image_server=images.endpoint)
        for _ in range(MOST_SESSIONS):
            with Client(vision.endpoint, timeout_s=60) as one_more:
                asked(one_more, "start", image_server=images.endpoint)
        for gone in (vision, other):
            with pytest.raises(ServerError, match="idle for longest"):
                asked(gone, "best")


def test_an_image_server_that_does_not_answer_holds_up_nobody_else(
    vision: Client, images: Running, sockets: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One listens and never answers; another is the vision server itself."""
    monkeypatch.setattr("vision_server.serve.server.CAPTURE_S", 6.0)
    monkeypatch.setattr("vision_server.serve.server.RETRIES", 9)
    with socket.socket(socket.AF_UNIX) as silent:
        silent.bind(f"{sockets}/silent")
        silent.listen()
        waiting = threading.Thread(target=waits_in_vain, args=(vision.endpoint, f"ipc://{sockets}/silent"))
        waiting.start()
        held, _ = silent.accept()  # it is asked
        with pytest.raises(ServerError, match="describe"):
            asked(vision, "start", image_server=vision.endpoint)
        asked(vision, "start", image_server=images.endpoint)
        assert waiting.is_alive()
        held.close()
        waiting.join()


def test_a_long_exposure_is_no_loss_of_the_image_server(
    vision: Client, images: Running, simulator: Simulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is waited for by as many exposures as it may take, however few seconds a short one gets."""
    asked(vision, "start", image_server=images.endpoint)
    monkeypatch.setattr("vision_server.serve.server.CAPTURE_S", 0.1)
    monkeypatch.setattr("bridge.image_messages.CAPTURE_S", 0.1)
    monkeypatch.setattr("bridge.image_messages.EXPOSURES_A_CAPTURE", 60 / SETTINGS["shutter_s"])
    take = simulator.capture

    def slowly(settings: Settings) -> Frame:
        time.sleep(1.0)
        return take(settings)

    monkeypatch.setattr(simulator, "capture", slowly)
    assert asked(vision, "capture", image="i1", settings=SETTINGS)["image"] == "i1"


def waits_in_vain(endpoint: str, silent: str) -> None:
    with Client(endpoint, timeout_s=60, retries=0) as stuck, suppress(ServerError):
        asked(stuck, "start", image_server=silent)
