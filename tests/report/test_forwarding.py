"""The live view through a forwarded port, as `ssh -L` makes one: another port, and another name."""

import re
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from urllib.parse import urlsplit

import pytest

from tests.report.browser import Browser
from tests.report.run_folders import RunMaker
from tests.report.viewers import asked, listening, told, view_of
from tests.session.command import ROOT

pytestmark = pytest.mark.slow


def carry(source: socket.socket, sink: socket.socket) -> None:
    """Bytes from one to the other until either is closed."""
    with suppress(OSError):
        while part := source.recv(1 << 16):
            sink.sendall(part)
    for one in (source, sink):
        with suppress(OSError):
            one.shutdown(socket.SHUT_RDWR)


@contextmanager
def forwarded(port: int) -> Iterator[int]:
    """A port of this machine behind which another one is."""
    with socket.create_server(("127.0.0.1", 0)) as door:

        def serve() -> None:
            with suppress(OSError):  # the door is closed
                while True:
                    here, _ = door.accept()
                    there = socket.create_connection(("127.0.0.1", port))
                    for pair in ((here, there), (there, here)):
                        threading.Thread(target=carry, args=pair, daemon=True).start()

        threading.Thread(target=serve, daemon=True).start()
        yield door.getsockname()[1]
        door.shutdown(socket.SHUT_RDWR)


def test_who_is_here_by_ssh_is_told_how_the_port_is_forwarded(
    make_run: RunMaker, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SSH_CONNECTION", "192.0.2.1 50000 192.0.2.2 22")
    command = [sys.executable, "-m", "report", "live", str(make_run())]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as view:
        assert view.stdout is not None
        line = view.stdout.readline()
        view.terminate()
    found = re.fullmatch(r"Open http://127\.0\.0\.1:(\d+)/\S+ \(.*: ssh -L (\S+) \S+\)\n", line)
    assert found is not None and found[2] == f"{found[1]}:127.0.0.1:{found[1]}"


def test_the_page_works_through_a_forwarded_port(make_run: RunMaker) -> None:
    folder = make_run()
    with view_of(folder) as address:
        there = urlsplit(address)
        with forwarded(there.port or 0) as port, Browser() as page:
            for name in ("127.0.0.1", "localhost"):
                page.open(f"http://{name}:{port}/?{there.query}")
                page.until('document.querySelector("#status .badge")?.innerText == "converged"')
                picture = page.value('document.querySelector("#now image").href.baseVal')
                assert page.value(f'fetch("{picture}").then(answer => answer.status)') == 200
            here = f"http://127.0.0.1:{port}/?{there.query}"
            listening(here)[0].close()
            assert told(here, "stop")[0] == 409  # it is heard: the session has ended
            assert asked(here, token="wrong")[0] == 403
            page.open("about:blank#left")
