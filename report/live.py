"""The live view's server: an address at once, all the rest when somebody opens it."""

from __future__ import annotations

import os
import secrets
import socket
from pathlib import Path
from typing import TYPE_CHECKING

from bridge.lifeline import Lifeline
from report.holding import must_be_session
from report.loopback import address_of, listening_on, must_be_installed, serving, somebody_came, told_to_end

if TYPE_CHECKING:
    from report.live_view import LiveView

NICENESS = 10  # of the view: the session goes first
TOLD_TO_END_S = (
    8.0  # for the last state to be drawn and sent when somebody waits for the view's end; chosen by hand
)
ALONE_S = (
    60.0  # the same when the session has ended, and nobody waits; it takes one or two, more on a busy machine
)


def serve_view(folder: Path, port: int = 0, parent: int | None = None) -> None:
    """Serve the page until Ctrl-C, SIGTERM or the parent's end; its address is printed first.

    Until a browser asks for the page, nothing is loaded, read or drawn.

    Raises
    ------
    BadInput : a folder without a session, a port that is taken, packages that are not installed.
    """
    must_be_installed()
    must_be_session(folder)
    token = secrets.token_urlsafe(16)
    with listening_on(port) as listening:
        lifeline = Lifeline(parent, signals=True)
        print(f"Open {address_of(listening, token)}", flush=True)
        os.nice(NICENESS)
        if parent is not None:
            _write_to(Path(os.devnull))  # who reads what the session writes need not wait for its view
        if somebody_came(listening, lifeline):
            if parent is not None:
                _write_to(folder / "view.log")
            _serve(folder, token, listening, lifeline)


def _write_to(file: Path) -> None:
    """From now on standard output and error go there."""
    descriptor = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
    for standard in (1, 2):
        os.dup2(descriptor, standard)
    os.close(descriptor)


def _serve(folder: Path, token: str, listening: socket.socket, lifeline: Lifeline) -> None:
    import asyncio  # late, as all that only a page needs

    from report.following import Follower
    from report.live_view import LiveView

    asyncio.run(_served(LiveView(Follower(folder), token), listening, lifeline))


async def _served(view: LiveView, listening: socket.socket, lifeline: Lifeline) -> None:
    import asyncio

    async with serving(view.app(), listening) as server:
        following = asyncio.create_task(view.follow())
        await told_to_end(lifeline, server, following)
        await view.end(TOLD_TO_END_S if lifeline.status else ALONE_S)
        await following
