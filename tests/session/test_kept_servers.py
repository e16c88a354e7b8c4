"""Servers that stay: found again, told apart, used by one session at a time, and gone in the end."""

from __future__ import annotations

import json
import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.session.command import DEADLINE_S, captured, controller, gone, start_controller
from tests.session.scenes import small
from tests.session.serving import kept, kept_servers

pytestmark = pytest.mark.slow

IDLE_S = 20.0
"""Longer than any of these tests needs between two sessions, on a busy machine."""


@pytest.fixture
def runtime() -> Iterator[Path]:
    """The folder where servers are kept; they end with the test."""
    with kept_servers() as folder:
        yield folder


def session(
    out: Path, *options: str, scenario: str = "nominal", keep: bool = True, idle_s: float = IDLE_S
) -> dict[str, Any]:
    """What one session finds, but for its times and how it was asked for."""
    keeping = ["--keep-servers", "--idle-s", str(idle_s)] if keep else []
    done = controller("--out", out, "--no-report", "--scenario", small(scenario), *options, *keeping)
    assert done.returncode in (0, 3), done.stderr
    result: dict[str, Any] = json.loads((out / "result.json").read_text())
    return {key: value for key, value in result.items() if key not in ("seconds", "command")}


def asked(idle_s: float = IDLE_S, target: str = "cube") -> None:
    """Ask the servers of a session what they offer, and take no image: they are started, or found."""
    keeping = ("--keep-servers", "--idle-s", str(idle_s))
    done = controller("--dry-run", "--scenario", small(), "--target", target, *keeping)
    assert done.returncode == 0, done.stderr


def test_a_session_on_kept_servers_finds_what_one_on_its_own_finds(runtime: Path, tmp_path: Path) -> None:
    three = ("--max-iterations", "3", "--seed", "4")
    alone = session(tmp_path / "alone", *three, scenario="drifting", keep=False)
    assert not kept(runtime)
    session(tmp_path / "first", "--max-iterations", "1", "--seed", "9", scenario="drifting")
    running = kept(runtime)
    assert sorted(name.split("-")[0] for name in running) == ["image_server", "vision_server"]
    assert session(tmp_path / "second", *three, scenario="drifting") == alone
    assert kept(runtime) == running
    asked(target="satellite")
    assert len(kept(runtime)) == 3 and running.items() <= kept(runtime).items(), (
        "only the image server differs"
    )


def test_two_sessions_do_not_share_servers_and_one_that_is_killed_frees_its_own(
    runtime: Path, tmp_path: Path
) -> None:
    endless = start_controller(
        "--out", tmp_path / "endless", "--scenario", small(), "--controller", "greedy",
        "--threshold", "0.000001", "--max-iterations", "1000", "--no-report",
        "--keep-servers", "--idle-s", str(IDLE_S),
    )  # fmt: skip
    try:
        while len(first := kept(runtime)) < 2:
            assert endless.poll() is None, endless.communicate()
            time.sleep(0.05)
        asked()
        assert len(kept(runtime)) == 4 and first.items() <= kept(runtime).items()
    finally:
        endless.kill()
        endless.communicate()
    asked()
    assert len(kept(runtime)) == 4


def test_servers_that_nobody_asks_end(runtime: Path, tmp_path: Path) -> None:
    session(tmp_path / "one", "--max-iterations", "1", idle_s=5)
    running = kept(runtime)
    assert running and gone(running)
    asked(idle_s=5)
    assert kept(runtime) and not set(kept(runtime).values()) & set(running.values())


def test_a_kept_server_that_is_killed_comes_back(runtime: Path, tmp_path: Path) -> None:
    asked()
    endless = start_controller(
        "--out", tmp_path / "endless", "--scenario", small(), "--controller", "greedy",
        "--threshold", "0.000001", "--max-iterations", "1000", "--no-report",
        "--keep-servers",
    )  # fmt: skip
    found, taken = kept(runtime), 0
    assert len(found) == 2
    for pid in found.values():
        captured(endless, tmp_path / "endless", f"i{taken + 1}")
        os.kill(pid, signal.SIGKILL)
        taken = (tmp_path / "endless" / "history.pl").read_text().count("capture(") + 2
    captured(endless, tmp_path / "endless", f"i{taken + 1}")
    endless.terminate()
    _, messages = endless.communicate(timeout=DEADLINE_S)
    for victim in ("image server", "vision server"):
        assert f"the {victim} is gone: it is brought back" in messages
    assert len(kept(runtime)) == 2


def test_servers_of_a_session_that_did_not_come_to_name_them_are_found(runtime: Path) -> None:
    asked()
    running = kept(runtime)
    for number, file in enumerate(sorted(runtime.glob("*.pid"))):
        file.write_text("") if number else file.unlink()
    asked()
    assert kept(runtime) == running


def test_a_small_scene_is_there_when_other_servers_have_ended() -> None:
    with kept_servers():
        small("focus")
    assert small("focus").is_file()


def test_what_cannot_be_kept_is_told(tmp_path: Path) -> None:
    for options, message in (
        (["--keep-servers", "--idle-s", "0"], "--idle-s must be a positive number of seconds"),
        (["--camera", "/dev/null", "--target", "cube"], "--keep-servers and --camera exclude each other"),
    ):
        done = controller("--keep-servers", *options, cwd=tmp_path)
        assert done.returncode == 2 and message in done.stderr
