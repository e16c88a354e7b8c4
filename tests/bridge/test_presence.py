import contextlib
import socket
import subprocess
import sys
import threading
from pathlib import Path

import pytest
import zmq

from bridge.client import Client
from bridge.errors import BridgeAbsent, BridgeTimeout
from bridge.presence import Presence

EVENTS = 1000
"""So many libzmq keeps for a monitor; its thread waits then."""


def test_a_socket_may_be_left_when_nobody_has_read_what_it_told(folder: Path) -> None:
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    sock = context.socket(zmq.DEALER)
    sock.linger, sock.reconnect_ivl = 0, 1
    presence = Presence()
    presence.watch(sock)
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(folder / "curt"))
        listener.listen()
        listener.settimeout(2.0)
        sock.connect(f"ipc://{folder}/curt")
        hung_up = 0
        with contextlib.suppress(TimeoutError):
            while hung_up < 2 * EVENTS:
                listener.accept()[0].close()
                hung_up += 1
    assert hung_up >= EVENTS / 2  # two events each
    leaving = threading.Thread(target=presence.leave, args=(sock,), daemon=True)
    leaving.start()
    leaving.join(60)
    assert not leaving.is_alive()
    sock.close()
    context.term()


@pytest.mark.parametrize("words", [["--endpoint", "{}"], ["--endpoint={}"]])
def test_a_server_that_is_being_loaded_is_waited_for(folder: Path, words: list[str]) -> None:
    endpoint = f"ipc://{folder}/soon"
    loading = subprocess.Popen(
        [sys.executable, "-c", "import time; time.sleep(60)", *(word.format(endpoint) for word in words)]
    )
    with Client(endpoint, timeout_s=1.5, retries=0, absent_s=0.1) as client:
        with pytest.raises(BridgeTimeout):
            client.request("hello")
        loading.kill()
        loading.wait()
        with pytest.raises(BridgeAbsent):
            client.request("hello", timeout_s=60.0)
