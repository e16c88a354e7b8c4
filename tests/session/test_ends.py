"""However a session ends, nothing is left running and the exit status says what happened."""

import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.session.command import (
    DEADLINE_S,
    ROOT,
    SERVERS,
    captured,
    controller,
    end_after,
    gone,
    outcome,
    running_session,
    servers_of,
    start_controller,
)
from tests.session.scenes import small
from tests.session.serving import served

pytestmark = pytest.mark.slow

NEVER = ("--threshold", "0.000001", "--max-iterations")


def threads_that_take(sent: signal.Signals, pid: int) -> list[str]:
    """Names of a process's threads that the kernel may give this signal to."""
    taking = []
    for thread in Path(f"/proc/{pid}/task").iterdir():
        told = dict(line.split(":\t", 1) for line in (thread / "status").read_text().splitlines())
        if not int(told["SigBlk"], 16) >> (sent - 1) & 1:
            taking.append(told["Name"])
    return taking


@pytest.mark.parametrize(("sent", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_stopped_by_signal(tmp_path: Path, sent: signal.Signals, status: int) -> None:
    session, servers = running_session(tmp_path, report=True)
    report = report_of(tmp_path)
    assert threads_that_take(sent, session.pid) == ["swipl"]  # another one would lose it
    session.send_signal(sent)
    said, messages = session.communicate(timeout=DEADLINE_S)
    assert session.returncode == status
    assert said.startswith("Stopped") and f": --resume {tmp_path} goes on" in " ".join(messages.split())
    assert gone(servers | {"report": report})
    assert "</html>" in (tmp_path / "report.html").read_text()
    stopped = json.loads((tmp_path / "result.json").read_text())
    assert stopped["status"] == "stopped"
    assert {signal.SIGINT: "Ctrl-C", signal.SIGTERM: "SIGTERM"}[sent] in stopped["message"]
    assert stopped["message"] in (tmp_path / "report.html").read_text()
    end_after(tmp_path / "history.pl", 3)
    assert served("--resume", tmp_path, "--no-report", "--quiet").returncode == 3
    assert json.loads((tmp_path / "result.json").read_text())["status"] == "exhausted"


BLIND = """
proc(control, if(range < 0.7, look_and_forget, [choose_reference, take_image, measure, keep_image])).
proc(look_and_forget, while(neg(exhausted), [choose_reference, take_image, drop_image('a trial')])).
"""


def test_an_approach_that_is_stopped_between_hold_points_tells_where_it_was(tmp_path: Path) -> None:
    strategy = tmp_path / "blind.pl"
    strategy.write_text(BLIND)
    out = tmp_path / "run"
    session = start_controller(
        "--approach", "--first-range", "0.8", "--contact-range", "0.65", "--threshold", "5", "--out", out,
        "--scenario", small("approach"), "--controller", strategy, "--max-iterations", "1000", "--no-report",
    )  # fmt: skip
    captured(session, out, "i2")
    session.send_signal(signal.SIGINT)
    said, messages = session.communicate(timeout=DEADLINE_S)
    assert session.returncode == 130, messages
    assert "hold points at 0.8, 0.65 m" in messages
    result = json.loads((out / "result.json").read_text())
    assert (result["pose"], result["planned_holds_m"]) == (None, [0.8, 0.65])
    assert [hold["status"] for hold in result["holds"]] == ["fixed"]
    assert result["holds"][0]["error"]["translation_fraction_of_range"] < 0.01
    assert "pose fixed at 1 of 2 hold points" in said
    ahead, fixed = said.split("the last pose that was fixed, at the hold point of 0.8 m:")
    assert "no pose" in ahead
    assert "translation" in fixed and "true error 0.0" in fixed


def test_an_approach_that_aborts_says_what_may_help(tmp_path: Path) -> None:
    done = served(
        "--approach", "--first-range", "0.6", "--contact-range", "0.5", "--scenario", small("approach"),
        *NEVER, "2", "--controller", "fixed", "--out", tmp_path / "run", "--no-report",
    )  # fmt: skip
    assert done.returncode == 3
    assert "approach aborted" in done.stderr
    helps = done.stdout.splitlines()[-1]
    assert "what may help: a strategy that goes on (--controller heuristic" in helps
    assert "a --threshold above" in helps


def test_servers_that_are_killed_come_back_and_the_session_goes_on(tmp_path: Path) -> None:
    whole, out = tmp_path / "whole", tmp_path / "run"
    turning = ("--scenario", small("turning-sun"), *NEVER, "3", "--no-report")
    assert served("--out", whole, *turning).returncode == 3
    session = start_controller("--out", out, *turning)
    for victim, image in (("image_server", "i1"), ("vision_server", "i2")):
        captured(session, out, image)
        os.kill(servers_of(session.pid)[victim], signal.SIGKILL)
    _, messages = session.communicate(timeout=DEADLINE_S)
    assert session.returncode == 3, messages
    for name in ("image server", "vision server"):
        assert f"the {name} was killed, by signal 9: it is brought back" in messages
    assert outcome(out) == outcome(whole)


def test_a_server_that_dies_again_and_again_ends_the_session(tmp_path: Path) -> None:
    session, servers = running_session(tmp_path)
    times = []
    while session.poll() is None:
        now = servers_of(session.pid)
        if "vision_server" in now and now["vision_server"] not in times:
            times.append(now["vision_server"])
            os.kill(times[-1], signal.SIGKILL)
        time.sleep(0.02)
    _, messages = session.communicate(timeout=DEADLINE_S)
    assert session.returncode == 4, messages
    assert "(5 of at most 5 times)" in messages
    assert "the vision server was killed, by signal 9" in messages.splitlines()[-2]
    assert len(times) == 6
    assert gone(servers)
    assert list(Path(tempfile.gettempdir()).glob(f"lights-and-camera-{session.pid}-*")) == []


def test_a_server_that_stands_still_is_not_dead(tmp_path: Path) -> None:
    session, servers = running_session(tmp_path)
    for victim in servers.values():
        os.kill(victim, signal.SIGSTOP)
        time.sleep(6)
        taken = (tmp_path / "history.pl").read_text().count("capture(")
        time.sleep(1)
        assert (tmp_path / "history.pl").read_text().count("capture(") == taken
        os.kill(victim, signal.SIGCONT)
        captured(session, tmp_path, f"i{taken + 2}")
        assert servers_of(session.pid) == servers
    session.terminate()
    _, messages = session.communicate(timeout=DEADLINE_S)
    assert "waiting for the vision server" in messages
    assert "brought back" not in messages


def test_a_server_of_the_user_s_may_come_back(tmp_path: Path) -> None:
    folder = Path(tempfile.mkdtemp(prefix="own-"))
    endpoints = {name: f"ipc://{folder}/{name}" for name in SERVERS}
    commands = {
        "image_server": ["image_server", "simulator", "--scenario", str(small()), "--seed", "1"],
        "vision_server": ["vision_server", "serve", "--root", str(tmp_path), "--root", str(ROOT),
                          "--image-server", endpoints["image_server"]],
    }  # fmt: skip

    def start(name: str) -> "subprocess.Popen[bytes]":
        command = [sys.executable, "-m", *commands[name], "--endpoint", endpoints[name]]
        return subprocess.Popen(command, cwd=ROOT, stderr=subprocess.DEVNULL)

    servers = {name: start(name) for name in SERVERS}
    try:
        session = start_controller(
            "--image-server", endpoints["image_server"], "--vision-server", endpoints["vision_server"],
            "--out", tmp_path / "run", *NEVER, "4", "--no-report",
        )  # fmt: skip
        for victim, image in (("image_server", "i1"), ("vision_server", "i3")):
            captured(session, tmp_path / "run", image)
            servers[victim].kill()
            servers[victim].wait()
            time.sleep(3)
            assert session.poll() is None
            servers[victim] = start(victim)
        said, messages = session.communicate(timeout=DEADLINE_S)
        assert session.returncode == 3, messages
        assert "after 4 images" in said
        assert messages.count("waiting for the") >= 2
    finally:
        for server in servers.values():
            server.terminate()
            server.wait(DEADLINE_S)
        shutil.rmtree(folder)


def test_a_server_of_the_user_s_that_stays_away_is_given_up(tmp_path: Path) -> None:
    with tempfile.TemporaryDirectory(prefix="own-") as folder:
        endpoint = f"ipc://{folder}/images"
        words = ["simulator", "--scenario", str(small()), "--seed", "1", "--endpoint", endpoint]
        server = subprocess.Popen([sys.executable, "-m", "image_server", *words], cwd=ROOT)
        while not (Path(folder) / "images").exists():  # it is asked for 5 s whether anybody listens
            assert server.poll() is None
            time.sleep(0.02)
        session = start_controller(
            "--image-server", endpoint, "--out", tmp_path / "run", *NEVER, "100", "--no-report",
        )  # fmt: skip
        captured(session, tmp_path / "run", "i1")
        server.kill()
        server.wait()
        died = time.monotonic()
        _, messages = session.communicate(timeout=DEADLINE_S)
        took_s = time.monotonic() - died
    assert session.returncode == 4, messages
    assert f"nobody listens at {endpoint} any more" in messages
    assert f"Nobody has listened at {endpoint} for 25 s" in messages
    assert f"--resume {tmp_path / 'run'} goes on" in messages
    assert "score" not in messages and "at most 5 times" not in messages
    result = json.loads((tmp_path / "run" / "result.json").read_text())
    assert took_s < 60.0
    assert result["seconds"]["total"] > 25.0


def test_a_folder_that_is_deleted_under_a_session_is_said(tmp_path: Path) -> None:
    session, servers = running_session(tmp_path / "run")
    while (tmp_path / "run").exists():
        shutil.rmtree(tmp_path / "run", ignore_errors=True)
    said, messages = session.communicate(timeout=DEADLINE_S)
    assert session.returncode == 2, messages
    assert said == ""
    assert messages.splitlines()[-1] == f"ERROR: the run folder {tmp_path / 'run'} is not there any more"
    assert gone(servers)


DISK_BYTES = 100 * 1024


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A file system of so few bytes that there is room for some two small images."""
    folder = tmp_path / "small"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", f"size={DISK_BYTES}", "tmpfs", str(folder)]
    if subprocess.run(mount, capture_output=True, check=False).returncode != 0:
        pytest.skip("a file system can be mounted by root only")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


def test_a_session_whose_disk_is_full_is_resumed_when_there_is_space(
    small_disk: Path, tmp_path: Path
) -> None:
    options = ("--seed", "3", "--scenario", small(), *NEVER, "4", "--no-report")
    whole = tmp_path / "whole"
    assert served("--out", whole, *options).returncode == 3
    full = controller("--out", small_disk / "run", *options)
    assert full.returncode == 2, full.stderr
    assert (small_disk / "run" / "images" / "i1.png").exists()
    last = full.stderr.splitlines()[-1]
    assert last.startswith("ERROR: ")
    assert f"--resume {small_disk / 'run'}" in last
    subprocess.run(["mount", "-o", "remount,size=50m", str(small_disk)], check=True)
    assert served("--resume", small_disk / "run", "--no-report").returncode == 3
    assert outcome(small_disk / "run") == outcome(whole)


def test_a_disk_that_is_full_before_the_session_is_said(small_disk: Path) -> None:
    with contextlib.suppress(OSError):
        (small_disk / "filling").write_bytes(bytes(DISK_BYTES))
    full = controller("--out", small_disk / "run", "--no-report", "--quiet")
    assert full.returncode == 2
    (line,) = full.stderr.splitlines()
    assert line == f"ERROR: cannot write to the run folder {small_disk / 'run'}: is there space?"
    assert not (small_disk / "run").exists()


def report_of(out: Path) -> int:
    """Process id of the report that waits for the end of the session in this folder."""
    deadline = time.monotonic() + DEADLINE_S
    while True:
        for entry in Path("/proc").iterdir():
            with contextlib.suppress(OSError):
                words = (entry / "cmdline").read_bytes().split(b"\0") if entry.name.isdigit() else []
                if b"--when-told" in words and str(out).encode() in words:
                    return int(entry.name)
        assert time.monotonic() < deadline, "no report waits"
        time.sleep(0.05)


def test_the_report_of_a_session_that_is_killed_is_not_left_waiting(tmp_path: Path) -> None:
    session, servers = running_session(tmp_path, report=True)
    report = report_of(tmp_path)
    session.kill()
    session.communicate(timeout=DEADLINE_S)
    assert gone(servers | {"report": report})
    assert not (tmp_path / "report.html").exists()
