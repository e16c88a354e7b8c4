"""Those who look at a live view in the tests: its address, and what is asked of it without a browser."""

import http.client
import json
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import urlsplit

from tests.session.command import ROOT

ADDRESS = re.compile(r"Open (http://127\.0\.0\.1:\d+/\?token=\S+)")


@contextmanager
def view_of(folder: Path) -> Iterator[str]:
    """Address of `python -m report live FOLDER`, which runs meanwhile and ends by SIGTERM."""
    process = subprocess.Popen(
        [sys.executable, "-m", "report", "live", str(folder)], cwd=ROOT, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    try:
        found = ADDRESS.match(process.stdout.readline())
        assert found is not None
        yield found[1]
        process.send_signal(signal.SIGTERM)
        assert process.wait(120) == 0
    finally:
        process.kill()
        process.communicate()


def asked(address: str, path: str = "/", token: str | None = None, **headers: str) -> tuple[int, str]:
    """Status and text of one request; `token` instead of the address's."""
    parts = urlsplit(address)
    right = parts.query.removeprefix("token=")
    client = http.client.HTTPConnection("127.0.0.1", parts.port or 0, timeout=120)
    client.request("GET", f"{path}?token={right if token is None else token}", headers=headers)
    answer = client.getresponse()
    text = answer.read().decode(errors="replace")
    client.close()
    return answer.status, text


def told(address: str, browser: str) -> tuple[int, str]:
    """Status and text of a word from a page's buttons."""
    parts = urlsplit(address)
    client = http.client.HTTPConnection("127.0.0.1", parts.port or 0, timeout=120)
    client.request("POST", "/control", body=browser, headers={"X-Token": parts.query.removeprefix("token=")})
    answer = client.getresponse()
    text = answer.read().decode()
    client.close()
    return answer.status, text


def listening(address: str) -> tuple[http.client.HTTPConnection, http.client.HTTPResponse]:
    """One more viewer, who has heard of the session once."""
    parts = urlsplit(address)
    client = http.client.HTTPConnection("127.0.0.1", parts.port or 0, timeout=120)
    client.request("GET", f"/events?{parts.query}")
    answer = client.getresponse()
    next_part(answer)
    return client, answer


def next_part(answer: http.client.HTTPResponse) -> dict[str, str]:
    """What a viewer is told next."""
    while not (line := answer.readline()).startswith(b"data: "):
        assert line, "the view has left"  # an empty line, or one that says that it is still here
    changed: dict[str, str] = json.loads(line.removeprefix(b"data: "))
    return changed
