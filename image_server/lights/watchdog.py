"""A child process that turns the lights off when the server has died without doing so itself.

It inherits the serial line and the read end of a pipe whose write end only the server holds. The end of the
pipe means that the server is gone, however it ended; the byte `LEAVE` means that it has put its lights out.
It uses the standard library alone, ignores the signals that end a session, and is in a session of its own.
"""

import os
import signal
import subprocess
import sys
from contextlib import suppress

LEAVE = b"l"
DEADLINE_S = 5  # chosen by hand


class Watchdog:
    """The server's end.

    Parameters
    ----------
    line : descriptor of the serial line.
    dark : what to write there when the server is gone.
    """

    def __init__(self, line: int, dark: bytes) -> None:
        end, self._pipe = os.pipe()
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-I", __file__, str(end), str(line), dark.hex()],
                pass_fds=(end, line),
                stdin=subprocess.DEVNULL,
                start_new_session=True,
            )
        except BaseException:
            os.close(self._pipe)
            raise
        finally:
            os.close(end)

    def leave(self) -> None:
        """Send it away: the lights are out. May be called twice."""
        if self._pipe < 0:
            return
        with suppress(OSError):
            os.write(self._pipe, LEAVE)
        os.close(self._pipe)
        self._pipe = -1
        try:
            self._process.wait(DEADLINE_S)
        except subprocess.TimeoutExpired:  # a busy machine; it has nothing left to do
            self._process.kill()
            self._process.wait()


def watch(end: int, line: int, dark: bytes) -> None:
    """Wait for the server's end, then write."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    if os.read(end, 1) == LEAVE:
        return
    signal.alarm(DEADLINE_S)  # a line that takes nothing must not keep this process
    with suppress(OSError):
        os.set_blocking(line, True)
        while dark:
            dark = dark[os.write(line, dark) :]


if __name__ == "__main__":
    watch(int(sys.argv[1]), int(sys.argv[2]), bytes.fromhex(sys.argv[3]))
