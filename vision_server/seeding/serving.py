"""The page of a seed pose, served until it has saved one."""

from __future__ import annotations

import asyncio
import socket
import sys
from contextlib import suppress

from bridge.errors import EXIT_NO_POSE, BadInput
from bridge.lifeline import Lifeline
from report.loopback import (
    address_of,
    listening_on,
    must_be_installed,
    serving,
    somebody_came,
    told_to_end,
)
from vision_server.seeding.view import SeedView


def serve_page(page: SeedView, port: int, wait_s: float) -> int:
    """Serve a page until a pose is saved, Ctrl-C or SIGTERM; the exit status.

    Parameters
    ----------
    port : 0 for any that is free.
    wait_s : how long a browser is waited for.

    Raises
    ------
    BadInput
        A port that is taken, packages that are not installed.
    """
    try:
        must_be_installed()
        listening = listening_on(port)
    except BadInput as error:
        raise BadInput(f"{error}.", "Or give --points or --pair, which need no page.") from error
    with listening:
        lifeline = Lifeline(signals=True)
        print(f"Open {address_of(listening, page.token)}", file=sys.stderr, flush=True)
        if not somebody_came(listening, lifeline, wait_s):
            if not lifeline.ended():
                print(
                    f"vision_server: nobody opened the page within {wait_s:g} s (--wait-s)", file=sys.stderr
                )
            return lifeline.status or EXIT_NO_POSE
        asyncio.run(_served(page, listening, lifeline))
        return 0 if page.saved.is_set() else lifeline.status or EXIT_NO_POSE


async def _served(page: SeedView, listening: socket.socket, lifeline: Lifeline) -> None:
    async with serving(page.app(), listening) as server:
        saved = asyncio.create_task(page.saved.wait())
        await told_to_end(lifeline, server, saved)
        saved.cancel()
        with suppress(asyncio.CancelledError):
            await saved
