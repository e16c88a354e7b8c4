import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from bridge.client import Client
from bridge.errors import BridgeTimeout
from bridge.serve import Server

from .conftest import Counter, Running

pytestmark = pytest.mark.slow

SERVER = """
import sys, time
from bridge.messages import NoArgs
from bridge.serve import Reply, Service, serve

class Sleeper(Service):
    name = "sleeper"
    def __init__(self):
        self.operations = {"sleep": (NoArgs, self.sleep)}
    def sleep(self, _):
        time.sleep(600)
        return Reply({})
    def close(self):
        print("closed", flush=True)

sys.exit(serve(Sleeper(), sys.argv[1], parent_pid=int(sys.argv[2]) if sys.argv[2:] else None))
"""
PARENT = """
import subprocess, sys, os, time
subprocess.Popen([sys.executable, "-c", sys.argv[1], sys.argv[2], str(os.getpid())])
time.sleep(600)
"""
DEADLINE_S = 120

Start = Callable[..., "subprocess.Popen[str]"]


@pytest.fixture
def start(root: Path) -> Iterator[Start]:
    """Starts python programs and ends those still running."""
    started: list[subprocess.Popen[str]] = []

    def run(*args: str) -> "subprocess.Popen[str]":
        process = subprocess.Popen(
            [sys.executable, "-c", *args], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=root
        )
        started.append(process)
        return process

    yield run
    for process in started:
        process.kill()
        process.communicate()


def hello(endpoint: str) -> int:
    with Client(endpoint, timeout_s=DEADLINE_S, retries=60) as client:
        return int(client.request("hello")[0]["pid"])


@pytest.mark.parametrize(("signum", "status"), [(signal.SIGTERM, 143), (signal.SIGINT, 130)])
def test_a_signal_is_a_clean_stop(start: Start, folder: Path, signum: int, status: int) -> None:
    process = start(SERVER, f"ipc://{folder}/s")
    hello(f"ipc://{folder}/s")
    process.send_signal(signum)
    out, err = process.communicate(timeout=DEADLINE_S)
    assert (process.returncode, out, err) == (status, "closed\n", "")
    assert not (folder / "s").exists()


def test_a_server_with_a_parent_leaves_ctrl_c_to_it(start: Start, folder: Path) -> None:
    process = start(SERVER, f"ipc://{folder}/s", str(os.getpid()))
    hello(f"ipc://{folder}/s")
    process.send_signal(signal.SIGINT)
    assert hello(f"ipc://{folder}/s") == process.pid


def test_an_idle_server_ends_with_its_parent(start: Start, folder: Path) -> None:
    parent = start(PARENT, SERVER, f"ipc://{folder}/s")
    pid = hello(f"ipc://{folder}/s")
    watch = os.pidfd_open(pid)
    parent.kill()
    assert ended(watch)
    assert parent.communicate(timeout=DEADLINE_S)[0] == "closed\n"


def test_a_busy_server_ends_with_its_parent_too(start: Start, folder: Path) -> None:
    parent = start(PARENT, SERVER, f"ipc://{folder}/s")
    pid = hello(f"ipc://{folder}/s")
    watch = os.pidfd_open(pid)
    with Client(f"ipc://{folder}/s", timeout_s=0.5) as client, pytest.raises(BridgeTimeout):
        client.request("sleep")
    parent.kill()
    assert ended(watch)
    assert not (folder / "s").exists()


def test_a_busy_server_does_not_outlive_sigterm(start: Start, folder: Path) -> None:
    process = start(SERVER, f"ipc://{folder}/s")
    hello(f"ipc://{folder}/s")
    with Client(f"ipc://{folder}/s", timeout_s=0.5) as client, pytest.raises(BridgeTimeout):
        client.request("sleep")
    process.terminate()
    assert process.wait(DEADLINE_S) == 143


def test_a_parent_that_is_gone_already_is_noticed(start: Start, folder: Path) -> None:
    gone = start("pass")
    gone.wait(DEADLINE_S)
    process = start(SERVER, f"ipc://{folder}/s", str(gone.pid))
    assert process.wait(DEADLINE_S) == 0


def ended(watch: int) -> bool:
    import select

    poll = select.poll()
    poll.register(watch, select.POLLIN)
    try:
        return bool(poll.poll(DEADLINE_S * 1000))
    finally:
        os.close(watch)


def test_a_server_with_a_client_is_not_idle(folder: Path) -> None:
    service = Counter()
    running = Running(service, Server(service, f"ipc://{folder}/s", idle_s=0.5))
    with Client(running.endpoint, timeout_s=60) as client:
        client.request("count")
        time.sleep(2.0)
        assert client.request("count")[0] == {"count": 2}
    running.thread.join(60)
    assert running.status == 0


CATCHES = """
import signal, sys, time
from bridge.lifeline import leave_at_signals
leave_at_signals()
print("ready", flush=True)
while True:
    try:
        time.sleep(600)
    except BaseException:
        print("caught", flush=True)
"""


@pytest.mark.parametrize(("signum", "status"), [(signal.SIGTERM, 143), (signal.SIGINT, 130)])
def test_a_signal_ends_a_command_that_catches_everything(start: Start, signum: int, status: int) -> None:
    process = start(CATCHES)
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    process.send_signal(signum)
    out, err = process.communicate(timeout=DEADLINE_S)
    assert (process.returncode, out, err) == (status, "", "")


STANDS = """
import ctypes
from bridge.lifeline import leave_at_signals
leave_at_signals()
lock = ctypes.create_string_buffer(64)  # a mutex that nobody holds
print("ready", flush=True)
while True:
    ctypes.CDLL(None).pthread_mutex_lock(lock)
"""


@pytest.mark.parametrize(("signum", "status"), [(signal.SIGTERM, 143), (signal.SIGINT, 130)])
def test_a_signal_ends_a_command_that_does_not_come_round_to_it(
    start: Start, signum: int, status: int
) -> None:
    process = start(STANDS)
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    process.send_signal(signum)
    assert process.wait(DEADLINE_S) == status


COPY = """
import os, signal, time
from bridge.lifeline import leave_at_signals
leave_at_signals()
heard, told = os.pipe()
child = os.fork()
while child == 0:
    os.write(told, b"it runs")
    time.sleep(0.01)
os.read(heard, 1)
os.kill(child, signal.SIGTERM)
print(os.waitpid(child, 0)[1] >> 8)
"""


def test_what_ends_a_copy_of_a_command_ends_not_the_command(start: Start) -> None:
    assert start(COPY).communicate(timeout=DEADLINE_S) == ("143\n", "")


def test_a_signal_that_is_ignored_stays_so(start: Start) -> None:
    code = "import os, signal; signal.signal(signal.SIGINT, signal.SIG_IGN); from bridge.lifeline import *;"
    process = start(f"{code} leave_at_signals(); os.kill(os.getpid(), signal.SIGINT); print('goes on')")
    assert process.communicate(timeout=DEADLINE_S) == ("goes on\n", "")
