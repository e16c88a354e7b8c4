"""What every served page needs: a port of this machine, an address with a token, a server and its end."""

from __future__ import annotations

import os
import secrets
import select
import socket
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, nullcontext
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from bridge.errors import BadInput

if TYPE_CHECKING:
    import asyncio

    from bridge.lifeline import Lifeline

HOST = "127.0.0.1"
NEEDED = ("starlette", "uvicorn")


def must_be_installed() -> None:
    """Raise BadInput where a package that serves pages is missing."""
    for package in NEEDED:
        if find_spec(package) is None:
            raise BadInput(
                f"a live page needs the package {package}; install it: pip install 'lights-and-camera[view]'"
            )


def listening_on(port: int) -> socket.socket:
    """A socket that listens on a port of this machine, 0 for any; BadInput where it is taken."""
    listening = socket.socket()
    try:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.bind((HOST, port))
        listening.listen()
    except OSError as error:
        listening.close()
        raise BadInput(f"port {port} of {HOST} cannot be used ({error.strerror}); choose another") from error
    return listening


def address_of(listening: socket.socket, token: str) -> str:
    """What to open; for who is here by ssh, and whose browser is not, how the port is forwarded."""
    port = listening.getsockname()[1]
    address = f"http://{HOST}:{port}/?token={token}"
    if "SSH_CONNECTION" not in os.environ:
        return address
    return f"{address} (on your own machine, first: ssh -L {port}:{HOST}:{port} {socket.gethostname()})"


def somebody_came(listening: socket.socket, lifeline: Lifeline, within_s: float | None = None) -> bool:
    """Wait for the first browser; false where the lifeline ends before, or nobody comes in time."""
    poll = select.poll()
    for descriptor in (listening.fileno(), *lifeline.filenos()):
        poll.register(descriptor, select.POLLIN)
    found = poll.poll(None if within_s is None else 1e3 * within_s)
    return {descriptor for descriptor, _ in found} == {listening.fileno()}


def refused(request: Any, given: str | None, token: str) -> Any:
    """The answer to a request by another name or without the page's token; None where it is welcome."""
    from starlette.responses import PlainTextResponse

    host = request.headers.get("host", "").rpartition(":")[0]
    if host not in (HOST, "localhost"):  # a page of elsewhere whose name leads here
        return PlainTextResponse(f"This page is at {HOST} and localhost only.\n", 403)
    if given is None or not secrets.compare_digest(given.encode(), token.encode()):
        return PlainTextResponse(
            "The token is missing or wrong: use the whole address that was printed.\n", 403
        )
    return None


@asynccontextmanager
async def serving(app: Any, listening: socket.socket) -> AsyncIterator[asyncio.Task[None]]:
    """An ASGI application on a socket as long as the block lasts; the task ends before where it fails."""
    import asyncio

    import uvicorn

    config = uvicorn.Config(app, log_level="error", lifespan="off", timeout_graceful_shutdown=1)
    server: Any = uvicorn.Server(config)
    server.capture_signals = nullcontext  # a signal ends what is served first, then its server
    task = asyncio.create_task(server.serve(sockets=[listening]))
    try:
        yield task
    finally:
        server.should_exit = True
        await task


async def told_to_end(lifeline: Lifeline, *tasks: asyncio.Task[Any]) -> None:
    """Wait until the lifeline ends or one of the tasks does."""
    import asyncio

    stop = asyncio.Event()
    loop = asyncio.get_running_loop()
    for descriptor in lifeline.filenos():
        loop.add_reader(descriptor, stop.set)
    for task in tasks:
        task.add_done_callback(lambda _: stop.set())
    await stop.wait()
    for descriptor in lifeline.filenos():
        loop.remove_reader(descriptor)  # it stays readable, and would be told again and again
