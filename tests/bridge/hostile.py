"""A hostile crowd on a server: random and mutated messages, some that never end, replies that are never read.

    python -m tests.bridge.hostile vision --messages 1000000

starts the server, lets the crowd loose on it, and prints one JSON object: messages sent, replies by error
code, what `internal` errors said, the longest wait of a client that behaves, and memory before, at most and
afterwards: when all is quiet, before after a few messages of the same crowd, by which all is loaded.
"""

from __future__ import annotations

import argparse
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

import numpy as np
import zmq

from bridge.client import Client
from bridge.errors import LightsAndCameraError
from vision_server.serve.sessions import MOST_SESSIONS

from .hostile_requests import IMAGE_REQUESTS, RUN, VISION_REQUESTS, WITH_ARRAYS, Mutator
from .hostile_wire import GREETING, connected, plain

ROOT = Path(__file__).resolve().parents[2]
COMMANDS = {
    "vision": ["-m", "vision_server", "serve"],
    "image": ["-m", "image_server", "simulator", "--target", "cube"],
    "mock-vision": ["-m", "bridge.mocks", "vision"],
    "mock-image": ["-m", "bridge.mocks", "image"],
}
BACK_MB = 20.0
"""That a server may hold more than before, when all is quiet again."""
WINDOW = 8
"""Requests of one attacker that are under way."""
FIRST = 3000
"""Messages before the memory is looked at."""
QUIET_S = 3.0
"""After a crowd, until its sessions have ended."""
PATIENCE_MS = 200
"""Without a reply, until an attacker comes back on another connection."""
ATTACKERS = 6


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

    def run(self, attackers: int) -> None:
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
        own = json.dumps(self._requests).replace(RUN, f"{RUN}-{seed}")  # else they take each other's sessions
        mutator = Mutator(json.loads(own), seed)
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
            while waiting and sock.poll(PATIENCE_MS if waiting >= WINDOW else 0):
                waiting -= 1
                self._count(next(filter(None, sock.recv_multipart())))
            if waiting >= WINDOW:  # what was cut off or dropped gets no reply, and some work takes its time
                sock.close(linger=0)
                sock, waiting = self._dealer(), 0
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
                    while True:  # until it has its answer
                        try:
                            client.request(op)
                            break
                        except LightsAndCameraError as error:
                            self.codes[f"behaved: {error.code}"] += 1
                            if error.code != "busy":
                                break
                    self.longest_wait_s = max(self.longest_wait_s, time.monotonic() - began)


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


def warm(endpoint: str, requests: dict[str, dict[str, Any]]) -> None:
    """Each operation, by as many clients as may have sessions: all is loaded then, and no other is left."""
    for number in range(MOST_SESSIONS):
        own = json.loads(json.dumps(requests).replace(RUN, f"{RUN}-warm-{number}-{time.monotonic_ns()}"))
        with Client(endpoint, timeout_s=60) as client:
            for op in sorted(own, key=lambda op: (op == "end", op == "discard")):
                frames = [np.zeros((480, 640), np.uint8)] if op in WITH_ARRAYS else []
                with suppress(LightsAndCameraError):
                    client.request(op, own[op], arrays=frames)


def attack(
    kind: str,
    messages: int,
    seed: int = 1,
    seconds: float = math.inf,
    attackers: int = ATTACKERS,
    first: int = FIRST,
) -> dict[str, Any]:
    """Start a server, let the crowd loose, and tell what came of it."""
    folder = Path(tempfile.mkdtemp(prefix="h"))
    images, endpoint = f"ipc://{folder}/images", f"ipc://{folder}/server"
    parent = ["--parent", str(os.getpid())]
    requests = VISION_REQUESTS if "vision" in kind else IMAGE_REQUESTS
    words = json.dumps(requests).replace("IMAGES", images).replace("FOLDER", str(folder / RUN))
    processes = []
    try:
        with (folder / "log").open("w") as log:
            if "vision" in kind:
                command = [sys.executable, *COMMANDS["image"], "--endpoint", images, *parent]
                processes.append(subprocess.Popen(command, cwd=ROOT, stderr=log))
            command = [sys.executable, *COMMANDS[kind], "--endpoint", endpoint, *parent]
            if kind == "vision":
                command += ["--root", str(folder), "--image-server", images]
            server = subprocess.Popen(command, cwd=ROOT, stderr=log)
            processes.append(server)
        requests = json.loads(words)
        warm(endpoint, requests)
        Crowd(endpoint, requests, first, seed - 1).run(attackers)
        time.sleep(QUIET_S)
        before = most = memory_mb(server.pid)
        crowd = Crowd(endpoint, requests, messages, seed, seconds)
        began = time.monotonic()
        thread = threading.Thread(target=crowd.run, args=(attackers,))
        thread.start()
        while thread.is_alive() and server.poll() is None:
            thread.join(0.1)
            most = max(most, memory_mb(server.pid))
            if sys.stderr.isatty():
                print(crowd.sent, end="\r", file=sys.stderr)
        thread.join()
        seconds = time.monotonic() - began
        time.sleep(QUIET_S)
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
    parser.add_argument("--attackers", type=int, default=ATTACKERS, help="Who send messages at a time.")
    given = parser.parse_args()
    print(json.dumps(attack(given.kind, given.messages, given.seed, given.seconds, given.attackers)))
