import contextlib
import socket
import threading
from pathlib import Path

import zmq

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
