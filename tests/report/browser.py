"""Headless Chromium for the tests, over the pipe of its DevTools protocol."""

import atexit
import base64
import json
import os
import select
import shutil
import subprocess
import tempfile
import time
from functools import cache
from pathlib import Path
from typing import Any, Self

import pytest

DEADLINE_S = 180.0  # a machine that runs much else beside the tests


def chromium() -> str:
    """The program; where there is none, the test is skipped: before it makes what it would look at."""
    program = shutil.which("chromium") or shutil.which("google-chrome")
    if program is None:
        pytest.skip("no chromium to look at pages with")
    return program


class _Chromium:
    """The program, which shows pages to whom it is told by the pipe."""

    def __init__(self, program: str) -> None:
        self._folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        there, self._to = os.pipe()
        self._from, back = os.pipe()
        self._process = subprocess.Popen(
            ["bash", "-c", f'exec "$0" "$@" 3<&{there} 4>&{back}', program, "--headless",
             "--no-sandbox", "--disable-gpu", "--in-process-gpu", "--disable-extensions",
             "--no-startup-window", "--remote-debugging-pipe", f"--user-data-dir={self._folder.name}"],
            pass_fds=(there, back), stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
        )  # fmt: skip
        os.close(there)
        os.close(back)
        self._buffer = b""
        self._number = 0

    def close(self) -> None:
        os.close(self._to)  # then it ends by itself, its children too
        os.close(self._from)
        try:
            self._process.wait(60)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait(60)
        self._folder.cleanup()

    def call(self, method: str, session: str | None = None, **params: Any) -> dict[str, Any]:
        """The result of one DevTools method, of the program or of one of its pages."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": params}
        if session is not None:
            message["sessionId"] = session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        deadline = time.monotonic() + DEADLINE_S
        while True:
            while b"\0" not in self._buffer:
                assert select.select([self._from], [], [], max(0.0, deadline - time.monotonic()))[0], method
                part = os.read(self._from, 1 << 20)
                assert part, "chromium has ended"
                self._buffer += part
            answer, _, self._buffer = self._buffer.partition(b"\0")
            found = json.loads(answer)
            if found.get("id") == self._number:
                assert "error" not in found, found
                result: dict[str, Any] = found["result"]
                return result


@cache
def _shared(program: str) -> _Chromium:
    """The one of this process: to start it takes longer than most pages."""
    running = _Chromium(program)
    atexit.register(running.close)
    return running


class Browser:
    """One page of headless Chromium that shares nothing with others; a test without Chromium is skipped.

    Parameters
    ----------
    width, height : of the window, CSS px.
    dark : whether the page is told that dark colours are preferred.
    alone : in a program of its own, which ends with the page.
    """

    def __init__(self, width: int = 1200, height: int = 900, dark: bool = False, alone: bool = False) -> None:
        program = chromium()
        self._alone = alone
        self._chromium = _Chromium(program) if alone else _shared(program)
        self._session: str | None = None
        self._context = self.call("Target.createBrowserContext")["browserContextId"]
        page = self.call("Target.createTarget", url="about:blank", browserContextId=self._context)
        self._session = self.call("Target.attachToTarget", targetId=page["targetId"], flatten=True)[
            "sessionId"
        ]
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=False,
        )
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.call("Emulation.setEmulatedMedia", features=[scheme])

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._alone:
            self._chromium.close()
        else:
            self._session = None
            self.call("Target.disposeBrowserContext", browserContextId=self._context)

    def call(self, method: str, **params: Any) -> dict[str, Any]:
        """The result of one DevTools method."""
        return self._chromium.call(method, self._session, **params)

    def open(self, address: str) -> None:
        """Go to a page."""
        self.call("Page.navigate", url=address)
        self.until('location.href != "about:blank" && document.readyState == "complete"')

    def value(self, script: str) -> Any:
        """Value of a JavaScript expression in the page."""
        answer = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def until(self, script: str, within_s: float = DEADLINE_S) -> Any:
        """Value of an expression as soon as it is true."""
        deadline = time.monotonic() + within_s
        while not (value := self.value(script)):
            assert time.monotonic() < deadline, (script, self.value("document.body.innerText"))
            time.sleep(0.05)
        return value

    def picture(self, file: Path) -> None:
        """The whole page as PNG."""
        height = self.value("document.documentElement.scrollHeight")
        width = self.value("window.innerWidth")
        clip = {"x": 0, "y": 0, "width": width, "height": height, "scale": 1}
        answer = self.call("Page.captureScreenshot", captureBeyondViewport=True, clip=clip)
        file.write_bytes(base64.b64decode(answer["data"]))
