"""Connections on which a hostile client says what it likes, byte for byte."""

import socket
from contextlib import suppress

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
        heard = b""  # a message before the other side is ready now and then ends the connection
        while len(heard) < len(GREETING) + 2 or len(heard) < len(GREETING) + 2 + heard[len(GREETING) + 1]:
            if not (piece := sock.recv(4096)):
                break
            heard += piece
    return sock
