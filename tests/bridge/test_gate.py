"""What a client may cost a server: messages that never end, replies that are never read, too many at once."""

import json
import math
import os
import socket
import struct
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from bridge import gate
from bridge.client import Client
from bridge.envelope import MAX_FRAMES, MAX_MESSAGE_BYTES
from bridge.errors import BadInput
from bridge.frame_meter import FrameMeter, TooMuchError
from bridge.lanes import MAX_WAITING, Lanes, Turns
from bridge.serve import Server

from .conftest import Counter, Running, wait_until
from .hostile import memory_mb
from .hostile_wire import GREETING, READY, connected, plain


def frame(flags: int, size: int) -> bytes:
    """A frame's head."""
    return bytes([flags, size]) if size < 256 else bytes([flags | 2]) + struct.pack(">Q", size)


def fed(data: bytes, step: int) -> FrameMeter:
    """A meter that saw these bytes in pieces."""
    meter = FrameMeter()
    for at in range(0, len(data), step):
        meter.feed(memoryview(data)[at : at + step])
    return meter


@pytest.mark.parametrize("step", [1, 7, 64, 1000])
def test_frames_are_counted_however_the_bytes_come(step: int) -> None:
    start = GREETING + READY
    assert fed(start, step).unfinished == 0
    assert fed(start + frame(0, 5) + b"abcde", step).unfinished == 0
    meter = fed(start + frame(1, 300) + bytes(300) + frame(4, 2) + b"xx" + frame(1, 3) + b"ab", step)
    assert meter.midway
    assert meter.unfinished == 9 + 300 + 2 + 2 + 2 + 3
    meter.feed(memoryview(b"c" + frame(0, 0)))
    assert (meter.unfinished, meter.midway) == (0, False)


@pytest.mark.parametrize(
    "bad",
    [
        b"GET / HTTP",
        b"\xff" * 20,
        b"\xff" + bytes(8) + b"\x7f\x01",
        GREETING + frame(4, 5000),
        GREETING + frame(0, 1 << 40),
        GREETING + frame(1, 0) * (MAX_FRAMES + 1),
        GREETING + (frame(1, 1 << 22) + bytes(1 << 22)) * (MAX_MESSAGE_BYTES // (1 << 22) + 1),
    ],
)
def test_what_breaks_a_bound_is_noticed(bad: bytes) -> None:
    with pytest.raises(TooMuchError):
        fed(bad, 1 << 20)


def test_a_message_that_never_ends_is_cut_off_and_its_memory_comes_back(counter: Running) -> None:
    before = memory_mb(os.getpid())
    piece = frame(1, 1 << 20) + bytes(1 << 20)
    sent = 0
    with connected(counter.endpoint) as sock, pytest.raises(OSError):
        while sent < 1 << 30:
            sock.sendall(piece)
            sent += len(piece)
    assert sent < 1 << 27
    with Client(counter.endpoint, timeout_s=60) as client:
        client.request("count")
    assert wait_until(lambda: memory_mb(os.getpid()) - before < 20.0)


def test_the_sum_of_unfinished_messages_is_bounded(counter: Running, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gate, "MAX_UNFINISHED_BYTES", 1 << 20)
    monkeypatch.setattr(gate, "STALLED_S", 3600)  # on a busy machine they wait for each other for long
    socks = [connected(counter.endpoint) for _ in range(4)]
    (passed,) = [each for each in counter.server._sockets._gates if each.most_bytes == math.inf]
    sizes = (300_000, 500_000, 200_000, 300_000)
    for number, (size, sock) in enumerate(zip(sizes, socks, strict=True), 1):
        sock.sendall(frame(1, size) + bytes(size))
        if number < len(socks):  # each is there before the next, so that it is known which is the largest
            expected = sum(sizes[:number]) + 9 * number
            assert wait_until(lambda n=expected: unfinished(passed) == n)  # type: ignore[misc]
    assert wait_until(lambda: len(passed._connections) == len(socks) - 1)
    open_now = []
    for sock in socks:
        sock.setblocking(False)
        try:
            while (heard := sock.recv(4096)) != b"":
                pass
            open_now.append(False)
        except BlockingIOError:
            open_now.append(True)
        except ConnectionResetError:
            open_now.append(False)
        sock.close()
    assert open_now == [True, False, True, True], heard


def unfinished(passed: gate.Gate) -> int:
    """Bytes of messages that are not complete, of all connections."""
    return sum(each.meter.unfinished for each in list(passed._connections))


def test_who_does_not_go_on_in_the_midst_of_a_message_is_cut_off(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gate, "STALLED_S", 1)
    service = Counter()
    running = Running(service, Server(service, f"ipc://{folder}/s"))
    with plain(running.endpoint) as half, connected(running.endpoint) as idle:
        half.sendall(GREETING[:20])
        half.settimeout(60)
        while half.recv(4096):
            continue
        idle.sendall(
            frame(4, 7) + b"\x04PING\x00\x00"
        )  # complete: it may stay silent for as long as it likes
        time.sleep(1.5)
        request = json.dumps({"v": 1, "id": "idle/1", "op": "count", "args": {}}).encode()
        idle.sendall(frame(0, len(request)) + request)
        assert wait_until(lambda: service.count == 1)
    running.stop()


def test_who_reads_no_replies_is_cut_off_and_nobody_waits(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gate, "STALLED_S", 1)
    service = Counter()
    running = Running(service, Server(service, f"ipc://{folder}/s"))

    def ask(sock: socket.socket) -> None:
        for number in range(100_000):
            request = json.dumps({"v": 1, "id": f"deaf/{number}", "op": "echo", "args": {"x": "a" * 2000}})
            sock.sendall(frame(0, len(request)) + request.encode())

    with connected(running.endpoint) as deaf, Client(running.endpoint, timeout_s=60) as client:
        with pytest.raises(OSError):
            ask(deaf)
        client.request("count")
    running.stop()


def test_the_silent_one_goes_when_there_are_too_many(
    counter: Running, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gate, "MAX_CONNECTIONS", 3)
    socks = [connected(counter.endpoint) for _ in range(3)]
    time.sleep(0.2)
    with Client(counter.endpoint, timeout_s=60) as client:
        assert client.request("count")[0] == {"count": 1}
    for sock in socks:
        sock.close()


def test_a_slow_request_holds_up_nobody_else(counter: Running) -> None:
    with Client(counter.endpoint, timeout_s=60) as slow, Client(counter.endpoint, timeout_s=60) as other:
        waiting = threading.Thread(target=slow.request, args=("wait",))
        waiting.start()
        assert wait_until(lambda: counter.service.count == 1)
        for op in ("hello", "health"):
            other.request(op)
        assert waiting.is_alive()
        counter.service.released.set()
        waiting.join()


def test_what_only_tells_waits_for_nothing_that_is_under_way(counter: Running) -> None:
    counter.service.prompt = frozenset({"count"})
    with Client(counter.endpoint, timeout_s=60) as slow, Client(counter.endpoint, timeout_s=60) as other:
        waiting = threading.Thread(target=slow.request, args=("wait",))
        waiting.start()
        assert wait_until(lambda: counter.service.count == 1)
        assert other.request("count")[0] == {"count": 2}
        assert waiting.is_alive()
        counter.service.released.set()
        waiting.join()


def test_work_of_one_caller_is_done_in_order_and_of_others_meanwhile() -> None:
    lanes, done, gate_open = Lanes(), [], threading.Event()
    assert lanes.put(b"a", lambda: (gate_open.wait(60), done.append(1)), 0)  # type: ignore[func-returns-value]
    for number in range(2, MAX_WAITING + 1):
        assert lanes.put(b"a", lambda number=number: done.append(number), 0)  # type: ignore[misc]
    assert not lanes.put(b"a", lambda: None, 0)
    assert lanes.put(b"b", lambda: done.append(0), 0)
    assert wait_until(lambda: done == [0])
    gate_open.set()
    lanes.join()
    assert done == list(range(MAX_WAITING + 1))


def test_turns_are_had_in_the_order_in_which_they_are_asked_for() -> None:
    turns, had = Turns(), []

    def busy() -> None:
        for _ in range(20):  # work upon work
            with turns:
                had.append("busy")
                assert len(had) > 1 or wait_until(lambda: len(turns._waiting) == 1)

    def other() -> None:
        with turns:
            had.append("other")

    threads = [threading.Thread(target=busy), threading.Thread(target=other)]
    threads[0].start()
    assert wait_until(lambda: bool(had))
    threads[1].start()
    for thread in threads:
        thread.join()
    assert had == ["busy", "other"] + ["busy"] * 19
    with pytest.raises(ValueError, match="inside"), turns:
        raise ValueError("inside")
    with turns:
        assert not turns._waiting


class Late:
    """A socket that is slow to give what it has received."""

    def __init__(self, sock: socket.socket) -> None:
        self._sock = sock

    def recv_into(self, buffer: memoryview) -> int:
        count = self._sock.recv_into(buffer)
        time.sleep(0.3)
        return count

    def __getattr__(self, name: str) -> Any:
        return getattr(self._sock, name)


def test_the_last_reply_leaves_however_late_the_gate_is(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    outward = gate._Connection._outward

    def late(connection: gate._Connection) -> None:
        connection._inner = Late(connection._inner)  # type: ignore[assignment]
        outward(connection)

    monkeypatch.setattr(gate._Connection, "_outward", late)
    service = Counter()
    running = Running(service, Server(service, f"ipc://{folder}/s"))
    with Client(running.endpoint, timeout_s=20) as client:
        assert client.request("shutdown")[0] == {}
    running.thread.join()


def test_two_servers_started_together_do_not_share_a_socket(folder: Path) -> None:
    for _ in range(30):
        with socket.socket(socket.AF_UNIX) as dead:
            dead.bind(f"{folder}/s")
        with ThreadPoolExecutor(3) as pool:
            started = list(pool.map(lambda _: listening(folder), range(3)))
        (server,) = filter(None, started)
        server._end()
        assert not (folder / "s").exists()


def listening(folder: Path) -> Server | None:
    """A server, or None where there is another."""
    try:
        return Server(Counter(), f"ipc://{folder}/s")
    except BadInput:
        return None


def test_an_abstract_socket_is_for_its_user_only(monkeypatch: pytest.MonkeyPatch) -> None:
    service = Counter()
    running = Running(service, Server(service, f"ipc://@lights-and-camera-test-{os.getpid()}"))
    with Client(running.endpoint, timeout_s=60) as client:
        client.request("count")
    monkeypatch.setattr("os.geteuid", lambda: os.getuid() + 1)
    if os.getuid() == 0:
        monkeypatch.setattr("bridge.endpoints.ROOT", -1)
    with connected_abstract(running.endpoint) as stranger:
        stranger.settimeout(60)
        assert stranger.recv(100) == b""
    running.stop()


def connected_abstract(endpoint: str) -> socket.socket:
    sock = socket.socket(socket.AF_UNIX)
    sock.connect("\0" + endpoint.removeprefix("ipc://@"))
    return sock
