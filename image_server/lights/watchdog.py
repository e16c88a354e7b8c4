"""A child process that turns the lights off when the server has died, or has stopped without doing so itself.

It inherits the serial line and one end of a socket whose other end only the server holds. The end of the
socket means that the server is gone, however it ended; the byte `LEAVE` means that it has put its lights out.
Silence means that the server hangs or is stopped: the lights go out, the server is told with `DARK`, and its
next word begins the wait anew. The child uses the standard library alone, ignores the signals that end a
session, and is in a session of its own, so that what stops the server's process group does not stop it.
"""

import os
import select
import signal
import socket
import subprocess
import sys
from contextlib import suppress

LEAVE, ALIVE, DARK = b"l", b"a", b"d"
DEADLINE_S = 5  # chosen by hand


class Watchdog:
    """The server's end.

    Parameters
    ----------
    line : descriptor of the serial line.
    dark : what to write there when the server is gone.
    hold_off_s : how long the server may be silent; 0 is for ever.
    """

    def __init__(self, line: int, dark: bytes, hold_off_s: float = 0.0) -> None:
        self._socket, theirs = socket.socketpair()
        self._socket.setblocking(False)
        end = theirs.fileno()
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-I", __file__, str(end), str(line), dark.hex(), str(hold_off_s)],
                pass_fds=(end, line),
                stdin=subprocess.DEVNULL,
                start_new_session=True,
            )
        except BaseException:
            self._socket.close()
            raise
        finally:
            theirs.close()

    def alive(self) -> None:
        """The server lives."""
        with suppress(OSError):  # full: it has enough to read; gone: its own end is not the server's
            self._socket.send(ALIVE)

    def went_dark(self) -> bool:
        """Whether it has put the lights out since the last question."""
        with suppress(OSError):
            return bool(self._socket.recv(64))
        return False

    def leave(self) -> None:
        """Send it away: the lights are out. May be called twice."""
        if self._socket.fileno() < 0:
            return
        with suppress(OSError):
            self._socket.send(LEAVE)
        self._socket.close()
        try:
            self._process.wait(DEADLINE_S)
        except subprocess.TimeoutExpired:  # a busy machine; it has nothing left to do
            self._process.kill()
            self._process.wait()


def watch(server: socket.socket, line: int, dark: bytes, hold_off_s: float) -> None:
    """Wait for the server's end or silence, then write."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    wait_s = None  # until the server's first word
    while True:
        silent = not select.select([server], [], [], wait_s)[0]
        words = b""
        with suppress(OSError):  # the other end is gone, and had not read everything
            words = words if silent else server.recv(64)
        if LEAVE in words:
            return
        wait_s = hold_off_s or None
        if words:
            continue
        signal.alarm(DEADLINE_S)  # a line that takes nothing must not keep this process
        with suppress(OSError):
            os.set_blocking(line, True)
            left = dark
            while left:
                left = left[os.write(line, left) :]
        signal.alarm(0)
        if not silent:
            return
        wait_s = None
        with suppress(OSError):
            server.send(DARK)


if __name__ == "__main__":
    with socket.socket(fileno=int(sys.argv[1])) as socket_to_server:
        watch(socket_to_server, int(sys.argv[2]), bytes.fromhex(sys.argv[3]), float(sys.argv[4]))
