"""The live view's page: what it shows of a session, and what its buttons do."""

from __future__ import annotations

import asyncio
import json
import os
import re
import threading
import time
from collections.abc import AsyncIterator
from contextlib import suppress
from html import escape
from typing import Any

from bridge.errors import BadInput
from report.following import WORK_NICENESS, Follower
from report.holding import hold
from report.loopback import refused

IMAGE = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*\.png")
LOOK_S = 0.25  # between two looks at the folder; chosen by hand
SHARE = 0.03  # of a processor that looks may take; python -m benchmarks.view_overhead
LONGEST_PAUSE_S = 2.0  # between looks, after one that took long; chosen by hand
KEEP_ALIVE_S = 10.0  # a browser that went away is noticed when it is written to
LAST_WORDS_S = 3.0  # for the last state to reach the browsers


class LiveView:
    """The page's server: one follower, any number of browsers.

    Parameters
    ----------
    follower : of the run folder of a session that runs or has ended.
    token : what the page's address must have; who does not have it sees and does nothing.
    """

    def __init__(self, follower: Follower, token: str) -> None:
        self._follower = follower
        self._folder = follower.folder
        self.token = token
        self._parts: dict[str, str] = {}
        self._version = 0
        self._viewers = 0
        self._ending = False
        self._looking = asyncio.Lock()
        self._wanted = asyncio.Event()  # a look at once

    def app(self) -> Any:
        """The page as an ASGI application."""
        from starlette.applications import Starlette
        from starlette.routing import Route

        return Starlette(
            routes=[
                Route("/", self._page),
                Route("/events", self._events),
                Route("/images/{name}", self._image),
                Route("/control", self._control, methods=["POST"]),
            ]
        )

    async def follow(self) -> None:
        """Look at the folder while somebody watches, until the view ends; the last look is told, too.

        The pause between looks is as long as their share of the processor asks for, but for what is pressed.
        """
        while not self._ending:
            before = self._spent_s()
            self._wanted.clear()
            if self._viewers:
                await self._look()
            pause_s = min(max(LOOK_S, (self._spent_s() - before) / SHARE), LONGEST_PAUSE_S)
            with suppress(TimeoutError):
                async with asyncio.timeout(pause_s):
                    await self._wanted.wait()

    def _spent_s(self) -> float:
        return time.process_time() + self._follower.spent_s

    async def end(self, within_s: float) -> None:
        """Tell the browsers how it ended, as far as that can be drawn in this time, and no more."""
        if self._viewers:
            with suppress(TimeoutError):
                async with asyncio.timeout(within_s):
                    await self._look()
        self._ending = True
        deadline = time.monotonic() + LAST_WORDS_S
        while self._viewers and time.monotonic() < deadline:
            await asyncio.sleep(LOOK_S / 5)
        self._follower.close()

    async def _look(self) -> None:
        async with self._looking:
            parts = await asyncio.to_thread(self._drawn)
            if parts is not None:
                self._parts = parts
                self._version += 1

    def _drawn(self) -> dict[str, str] | None:
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), WORK_NICENESS)  # of this thread alone
        from report.fragments import fragments  # late: the page is there before NumPy is

        try:
            state = self._follower.look()
            return None if state is None else fragments(self._folder, state, self.token)
        except (BadInput, OSError, ValueError) as error:
            return {"status": f'<p class="detail">{escape(f"This cannot be shown: {error}")}</p>'}

    # --- what a browser asks for ---

    def _refused(self, request: Any, token: str | None) -> Any:
        return refused(request, token, self.token)

    async def _page(self, request: Any) -> Any:
        from starlette.responses import HTMLResponse

        from report.fragments import live_page

        refusal = self._refused(request, request.query_params.get("token"))
        return refusal or HTMLResponse(live_page(self.token), headers={"Referrer-Policy": "no-referrer"})

    async def _image(self, request: Any) -> Any:
        from starlette.responses import FileResponse, PlainTextResponse

        refusal = self._refused(request, request.query_params.get("token"))
        name = request.path_params["name"]
        file = self._folder / "images" / name
        if refusal is None and not (IMAGE.fullmatch(name) and file.is_file()):
            refusal = PlainTextResponse(f"There is no image {name}.\n", 404)
        return refusal or FileResponse(file)

    async def _control(self, request: Any) -> Any:
        from starlette.responses import PlainTextResponse

        refusal = self._refused(request, request.headers.get("x-token"))
        if refusal is not None:
            return refusal
        try:
            await asyncio.to_thread(hold, self._folder, (await request.body())[:20].decode(errors="replace"))
        except BadInput as error:
            return PlainTextResponse(f"{error}\n", 409)
        self._wanted.set()
        return PlainTextResponse("")

    async def _events(self, request: Any) -> Any:
        from starlette.responses import StreamingResponse

        refusal = self._refused(request, request.query_params.get("token"))
        return refusal or StreamingResponse(self._stream(), media_type="text/event-stream")

    async def _stream(self) -> AsyncIterator[str]:
        """Parts of the page that have changed since this browser was told last."""
        told: dict[str, str] = {}
        version, spoke = 0, time.monotonic()
        self._viewers += 1
        self._wanted.set()
        try:
            while True:
                ending = self._ending
                if self._version != version:
                    version = self._version
                    changed = {name: html for name, html in self._parts.items() if told.get(name) != html}
                    told = self._parts
                    spoke = time.monotonic()
                    yield f"data: {json.dumps(changed)}\n\n"
                elif time.monotonic() - spoke > KEEP_ALIVE_S:
                    spoke = time.monotonic()
                    yield ": still here\n\n"
                if ending:
                    yield "event: end\ndata: {}\n\n"
                    return
                await asyncio.sleep(LOOK_S)
        finally:
            self._viewers -= 1
