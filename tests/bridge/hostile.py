"""A hostile crowd on a server: random and mutated messages, some that never end, replies that are never read.

    python -m tests.bridge.hostile vision --messages 1000000

starts the server, lets the crowd loose on it, and prints one JSON object: messages sent, replies by error
code, what `internal` errors said, the longest wait of a client that behaves, and memory before, at most and
afterwards.
"""

from __future__ import annotations

import argparse
import copy
import json
import math
import os
import random
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from contextlib import suppress
from pathlib import Path
from typing import Any

import zmq

from bridge.client import Client
from bridge.errors import LightsAndCameraError

ROOT = Path(__file__).resolve().parents[2]
SETTINGS = {"lights": [5, 5, 5], "shutter_s": 1 / 60, "aperture": 4.0}
POSE = {"rotation_vector": [0.1, 0.2, 0.3], "translation": [0.0, 0.0, 0.6]}
COMMANDS = {
    "vision": ["-m", "vision_server", "serve"],
    "image": ["-m", "image_server", "simulator", "--target", "cube"],
    "mock-vision": ["-m", "bridge.mocks", "vision"],
    "mock-image": ["-m", "bridge.mocks", "image"],
}
IMAGE_REQUESTS: dict[str, dict[str, Any]] = {
    "describe": {},
    "capture": {"settings": SETTINGS},
    "health": {},
    "restart": {"seed": 1, "captures_taken": 2},
    "move": {"range_m": 0.7},
    "score": {"pose": POSE},
    "hello": {},
}
VISION_REQUESTS: dict[str, dict[str, Any]] = {
    "start": {"image_server": "IMAGES", "seed": 3, "out": "FOLDER", "matcher": "search"},
    "capture": {"image": "i1", "settings": SETTINGS},
    "add": {"image": "i2", "settings": SETTINGS},
    "estimate": {"images": ["i1"]},
    "discard": {"image": "i1"},
    "best": {},
    "parameters": {"seed": 1, "generations": 20, "seed_pose": POSE},
    "restore": {"image_server": "IMAGES", "out": "FOLDER", "images": ["i1"], "discarded": [], "told": []},
    "hello": {},
    "health": {},
}
ODD: list[Any] = [
    None, True, -1, 0, 1e-300, 1e300, -1e308, 2**63, 10**30, 10**400, "", "\0", "i1\n", "a" * 5000, "../../x",
    "/dev/zero", "/dev/stdin", "/etc/passwd", "ipc:///nowhere", "tcp://127.0.0.1:1", "best", [], {}, [[]],
    [1e308] * 3, ["i1"] * 300, {"best_at_range_m": 1e-300}, {"best_at_range_m": 1e308}, "é\u2028\U0001f6f0",
]  # fmt: skip
BACK_MB = 20.0
"""That a server may hold more than before, when all is quiet again."""
WINDOW = 8
"""Requests of one attacker that are under way."""
AS_IT_IS = 0.02
"""Share of requests that are sent without a mutation: they cost most."""


class Mutator:
    """Requests that are nearly right."""

    def __init__(self, requests: dict[str, dict[str, Any]], seed: int) -> None:
        self._random = random.Random(seed)
        self._requests = requests
        self._name = f"hostile-{seed}"
        self._number = 0

    def message(self) -> list[bytes]:
        """The frames of one message."""
        draw = self._random
        self._number += 1
        op = draw.choice(list(self._requests))
        args = json.loads(json.dumps(self._requests[op]))
        request: dict[str, Any] = {"v": 1, "id": f"{self._name}/{self._number}", "op": op, "args": args}
        if draw.random() >= AS_IT_IS:
            for _ in range(draw.randint(1, 3)):
                self._mutate(request if draw.random() < 0.15 else args)
        header = json.dumps(request).encode()
        if draw.random() < 0.2:
            header = self._bytes(header)
        if draw.random() < 0.03:
            header = draw.randbytes(draw.choice([0, 1, 30, 3000]))
        frames = [
            header,
            *(draw.randbytes(draw.choice([0, 5, 3000])) for _ in range(draw.choice([0] * 9 + [1, 3]))),
        ]
        if b"shutdown" in header:
            return [b"{}"]
        return frames

    def _mutate(self, value: Any) -> None:
        """Change one thing somewhere inside."""
        draw = self._random
        keys = list(value) if isinstance(value, dict) else list(range(len(value)))
        if not keys or draw.random() < 0.1:
            if isinstance(value, dict):
                value[draw.choice(["colour", "", "image", "seed_pose", "a" * 300])] = copy.deepcopy(
                    draw.choice(ODD)
                )
            else:
                value.append(copy.deepcopy(draw.choice(ODD)))
            return
        key = draw.choice(keys)
        if isinstance(value[key], (dict, list)) and draw.random() < 0.7:
            self._mutate(value[key])
        elif draw.random() < 0.15:
            del value[key]
        else:
            value[key] = copy.deepcopy(draw.choice(ODD))

    def _bytes(self, header: bytes) -> bytes:
        draw = self._random
        changed = bytearray(header)
        for _ in range(draw.randint(1, 4)):
            at = draw.randrange(len(changed))
            match draw.randrange(4):
                case 0:
                    changed[at] = draw.randrange(256)
                case 1:
                    del changed[at : at + draw.randint(1, 20)]
                    changed += b" "
                case 2:
                    changed[at:at] = changed[: draw.randint(1, 40)]
                case _:
                    changed[at:at] = draw.choice([b'"', b"{", b"[" * 2000, b"1e999", b"9" * 50, b"\\u0000"])
        return bytes(changed)


class Crowd:
    """Attackers on one server, and one client that behaves."""

    def __init__(
        self,
        endpoint: str,
        requests: dict[str, dict[str, Any]],
        messages: int,
        seed: int,
        seconds: float = math.inf,
    ) -> None:
        self.codes: Counter[str] = Counter()
        self.internal: dict[str, str] = {}
        self.sent = 0
        self.cut_bytes = 0
        self.longest_wait_s = 0.0
        self._endpoint, self._requests, self._messages, self._seed = endpoint, requests, messages, seed
        self._until = time.monotonic() + seconds
        self._over = threading.Event()
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()

    def run(self, attackers: int = 3) -> None:
        """Attack until all messages are sent."""
        mutators = [
            threading.Thread(target=self._mutations, args=(self._messages // attackers, self._seed + n))
            for n in range(attackers)
        ]
        others = [
            threading.Thread(target=work)
            for work in (self._endless, self._endless, self._deaf, self._churn, self._behaved)
        ]
        for thread in (*mutators, *others):
            thread.start()
        for thread in mutators:
            thread.join()
        self._over.set()
        for thread in others:
            thread.join()
        self._context.destroy(linger=0)

    def _mutations(self, messages: int, seed: int) -> None:
        mutator = Mutator(self._requests, seed)
        sock, waiting, busy = self._dealer(), 0, 0
        for _ in range(messages):
            if time.monotonic() > self._until:
                break
            if self.codes["busy"] > busy:  # what it asked for takes its time: somebody else asks now
                busy = self.codes["busy"]
                sock.close(linger=0)
                sock, waiting = self._dealer(), 0
            sock.send_multipart(mutator.message())
            self.sent += 1
            waiting += 1
            while waiting and sock.poll(1000 if waiting >= WINDOW else 0):
                waiting -= 1
                self._count(next(filter(None, sock.recv_multipart())))
            waiting = min(waiting, WINDOW - 1)  # what was cut off or dropped gets no reply
        while waiting and sock.poll(5000):
            waiting -= 1
            self._count(next(filter(None, sock.recv_multipart())))
        sock.close(linger=0)

    def _dealer(self) -> zmq.Socket[bytes]:
        sock = self._context.socket(zmq.DEALER)
        sock.connect(self._endpoint)
        return sock

    def _count(self, header: bytes) -> None:
        reply = json.loads(header)
        code = "ok" if reply["ok"] else reply["error"]["code"]
        self.codes[code] += 1
        if code == "internal":
            self.internal.setdefault(reply["error"]["message"][-200:], reply["id"])

    def _endless(self) -> None:
        """Frames of a message that never ends; once cut off, again."""
        frame = b"\x03" + struct.pack(">Q", 1 << 20) + bytes(1 << 20)
        while not self._over.wait(1.0):
            with connected(self._endpoint) as sock:
                try:
                    while not self._over.is_set():
                        sock.sendall(frame)
                        self.cut_bytes += len(frame)
                except OSError:
                    continue

    def _deaf(self) -> None:
        """Requests for the largest replies there are; none is read."""
        number = 0
        while not self._over.wait(0.05):
            with connected(self._endpoint) as sock:
                try:
                    while not self._over.wait(0.05):
                        number += 1
                        op = random.choice(["capture", "hello", "describe", "parameters"])
                        request = {
                            "v": 1,
                            "id": f"deaf/{number}",
                            "op": op,
                            "args": self._requests.get(op, {}),
                        }
                        header = json.dumps(request).encode()
                        sock.sendall(b"\x02" + struct.pack(">Q", len(header)) + header)
                except OSError:
                    continue

    def _churn(self) -> None:
        """Connections that say half of something and go, or stay."""
        stay: list[socket.socket] = []
        while not self._over.wait(0.02):
            try:
                sock = plain(self._endpoint)
                sock.sendall(
                    random.choice([b"", b"GET / HTTP/1.1\r\n\r\n", GREETING[:20], GREETING, b"\xff" * 100])
                )
                stay.append(sock)
            except OSError:
                pass
            for old in stay[:-20]:
                old.close()
            del stay[:-20]
        for sock in stay:
            sock.close()

    def _behaved(self) -> None:
        with Client(self._endpoint, timeout_s=60, retries=0) as client:
            while not self._over.wait(0.02):
                for op in ("hello", "health"):
                    began = time.monotonic()
                    try:
                        client.request(op)
                    except LightsAndCameraError as error:
                        self.codes[f"behaved: {error.code}"] += 1
                    self.longest_wait_s = max(self.longest_wait_s, time.monotonic() - began)


GREETING = b"\xff" + bytes(8) + b"\x7f" + b"\x03\x00" + b"NULL".ljust(20, b"\0") + bytes(32)
READY = b"\x04\x29\x05READY\x0bSocket-Type\x00\x00\x00\x06DEALER\x08Identity\x00\x00\x00\x00"


def plain(endpoint: str) -> socket.socket:
    """A connection on which nothing has been said."""
    sock = socket.socket(socket.AF_UNIX)
    sock.settimeout(2)
    sock.connect(endpoint.removeprefix("ipc://"))
    return sock


def connected(endpoint: str) -> socket.socket:
    """A connection on which ZMTP's handshake is done."""
    sock = plain(endpoint)
    with suppress(OSError):
        sock.sendall(GREETING + READY)
    return sock


def memory_mb(pid: int) -> float:
    """Resident memory of a process."""
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def given_back(pid: int, before: float, within_s: float = 30.0) -> None:
    """Wait until a process has given memory back, for a while."""
    deadline = time.monotonic() + within_s
    with suppress(OSError):
        while memory_mb(pid) - before > BACK_MB and time.monotonic() < deadline:
            time.sleep(0.1)


def attack(kind: str, messages: int, seed: int = 1, seconds: float = math.inf) -> dict[str, Any]:
    """Start a server, let the crowd loose, and tell what came of it."""
    folder = Path(tempfile.mkdtemp(prefix="h"))
    images, endpoint = f"ipc://{folder}/images", f"ipc://{folder}/server"
    parent = ["--parent", str(os.getpid())]
    requests = VISION_REQUESTS if "vision" in kind else IMAGE_REQUESTS
    words = json.dumps(requests).replace("IMAGES", images).replace("FOLDER", str(folder / "run"))
    processes = []
    try:
        with (folder / "log").open("w") as log:
            if "vision" in kind:
                command = [sys.executable, *COMMANDS["image"], "--endpoint", images, *parent]
                processes.append(subprocess.Popen(command, cwd=ROOT, stderr=log))
            command = [sys.executable, *COMMANDS[kind], "--endpoint", endpoint, *parent]
            if kind == "vision":
                command += ["--root", str(folder)]
            server = subprocess.Popen(command, cwd=ROOT, stderr=log)
            processes.append(server)
        requests = json.loads(words)
        with Client(endpoint, timeout_s=60) as client:
            for op, args in requests.items():  # each once, so that what it loads is loaded
                try:
                    client.request(op, args)
                except LightsAndCameraError:
                    continue
        time.sleep(1.0)
        before = most = memory_mb(server.pid)
        crowd = Crowd(endpoint, requests, messages, seed, seconds)
        began = time.monotonic()
        thread = threading.Thread(target=crowd.run)
        thread.start()
        while thread.is_alive() and server.poll() is None:
            thread.join(0.1)
            most = max(most, memory_mb(server.pid))
            if sys.stderr.isatty():
                print(crowd.sent, end="\r", file=sys.stderr)
        thread.join()
        seconds = time.monotonic() - began
        time.sleep(3.0)
        given_back(server.pid, before)
        serving = server.poll() is None
        with Client(endpoint, timeout_s=60) as client:
            serving = serving and client.request("hello")[0]["pid"] == server.pid
        return {
            "server": kind,
            "messages": crowd.sent,
            "seconds": round(seconds, 1),
            "serving": serving,
            "codes": dict(crowd.codes),
            "internal": crowd.internal,
            "longest_wait_s": round(crowd.longest_wait_s, 3),
            "unfinished_mb_sent": round(crowd.cut_bytes / 1e6),
            "memory_mb": {
                "before": round(before),
                "most": round(most),
                "after": round(memory_mb(server.pid)) if serving else None,
            },
            "tracebacks": (folder / "log").read_text().count("Traceback"),
        }
    finally:
        for process in processes:
            process.terminate()
            process.wait(60)
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m tests.bridge.hostile", description="A hostile crowd.")
    parser.add_argument("kind", choices=COMMANDS)
    parser.add_argument("--messages", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=math.inf, help="At most for so long.")
    given = parser.parse_args()
    print(json.dumps(attack(given.kind, given.messages, given.seed, given.seconds)))
