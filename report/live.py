"""The live view's server: an address at once, all the rest when somebody opens it."""

from __future__ import annotations

import os
import secrets
import select
import socket
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bridge.lifeline import Lifeline
from report.errors import ReportError
from report.following import NICENESS, Follower

if TYPE_CHECKING:
    from report.live_view import LiveView

HOST = "127.0.0.1"
TOLD_TO_END_S = (
    8.0  # for the last state to be drawn and sent when somebody waits for the view's end; chosen by hand
)
ALONE_S = (
    60.0  # the same when the session has ended, and nobody waits; it takes one or two, more on a busy machine
)
NEEDED = ("starlette", "uvicorn")


def serve_view(folder: Path, port: int = 0, parent: int | None = None) -> None:
    """Serve the page until Ctrl-C, SIGTERM or the parent's end; its address is printed first.

    Until a browser asks for the page, nothing is loaded, read or drawn.

    Raises
    ------
    ReportError : a folder without a session, a port that is taken, packages that are not installed.
    """
    for package in NEEDED:
        if find_spec(package) is None:
            raise ReportError(
                f"the live view needs the package {package};"
                " install it: pip install 'lights-and-camera[view]'"
            )
    follower = Follower(folder)
    token = secrets.token_urlsafe(16)
    with _listening(port) as listening:
        lifeline = Lifeline(parent, signals=True)
        port = listening.getsockname()[1]
        print(f"Open http://{HOST}:{port}/?token={token}{_way_here(port)}", flush=True)
        os.nice(NICENESS)
        if parent is not None:
            _write_to(Path(os.devnull))  # who reads what the session writes need not wait for its view
        if _somebody_came(listening, lifeline):
            if parent is not None:
                _write_to(folder / "view.log")
            _serve(follower, token, listening, lifeline)


def _way_here(port: int) -> str:
    """For who is here by ssh, and whose browser is not: how the port is forwarded."""
    if "SSH_CONNECTION" not in os.environ:
        return ""
    return f" (on your own machine, first: ssh -L {port}:{HOST}:{port} {socket.gethostname()})"


def _write_to(file: Path) -> None:
    """From now on standard output and error go there."""
    descriptor = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
    for standard in (1, 2):
        os.dup2(descriptor, standard)
    os.close(descriptor)


def _listening(port: int) -> socket.socket:
    listening = socket.socket()
    try:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.bind((HOST, port))
        listening.listen()
    except OSError as error:
        listening.close()
        raise ReportError(
            f"port {port} of {HOST} cannot be used ({error.strerror}); choose another"
        ) from error
    return listening


def _somebody_came(listening: socket.socket, lifeline: Lifeline) -> bool:
    """Wait for the first browser; false where the view is to end before."""
    poll = select.poll()
    for descriptor in (listening.fileno(), *lifeline.filenos()):
        poll.register(descriptor, select.POLLIN)
    return {descriptor for descriptor, _ in poll.poll()} == {listening.fileno()}


def _serve(follower: Follower, token: str, listening: socket.socket, lifeline: Lifeline) -> None:
    import asyncio  # late, as all that only a page needs

    from report.live_view import LiveView

    asyncio.run(_served(LiveView(follower, token), listening, lifeline))


async def _served(view: LiveView, listening: socket.socket, lifeline: Lifeline) -> None:
    import asyncio
    from contextlib import nullcontext

    import uvicorn

    config = uvicorn.Config(view.app(), log_level="error", lifespan="off", timeout_graceful_shutdown=1)
    server: Any = uvicorn.Server(config)
    stop = asyncio.Event()
    loop = asyncio.get_running_loop()
    for descriptor in lifeline.filenos():
        loop.add_reader(descriptor, stop.set)
    server.capture_signals = nullcontext  # a signal ends the view first, then its server
    serving = asyncio.create_task(server.serve(sockets=[listening]))
    following = asyncio.create_task(view.follow())
    for task in (serving, following):
        task.add_done_callback(lambda _: stop.set())
    await stop.wait()
    for descriptor in lifeline.filenos():
        loop.remove_reader(descriptor)  # it stays readable, and would be told again and again
    await view.end(TOLD_TO_END_S if lifeline.status else ALONE_S)
    server.should_exit = True
    await asyncio.gather(serving, following)
