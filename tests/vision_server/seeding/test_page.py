"""The page of a seed pose: what it answers, who is refused, and a person's clicks in a browser."""

import json
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.client import HTTPConnection
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import cv2
import numpy as np
import pytest

from geometry.model import Model
from tests.report.browser import Browser
from tests.session.command import ROOT
from tests.vision_server.synthetic import CAMERA, POSE, camera_file, cuboid, linear_picture, photographed
from vision_server.serve.inputs import read_seed_pose

pytestmark = pytest.mark.slow

CORNERS = (0, 1, 2, 5)
ADDRESS = re.compile(r"Open (http://127\.0\.0\.1:\d+/\?token=\S+)")


class Page:
    """`python -m vision_server seed`, and its address."""

    def __init__(self, process: "subprocess.Popen[str]", address: str, model: Model, out: Path) -> None:
        self.process, self.address, self.model, self.out = process, address, model, out

    def asked(
        self, method: str, path: str, body: object = None, token: str | None = None
    ) -> tuple[int, bytes]:
        parts = urlsplit(self.address)
        token = parts.query.removeprefix("token=") if token is None else token
        client = HTTPConnection("127.0.0.1", parts.port or 0, timeout=120)
        content = body if isinstance(body, bytes) else json.dumps(body).encode()
        client.request(method, f"{path}?token={token}", content, {"X-Token": token})
        answer = client.getresponse()
        found = answer.status, answer.read()
        client.close()
        return found


@contextmanager
def page_in(folder: Path) -> Iterator[Page]:
    model = cuboid(folder)
    cv2.imwrite(str(folder / "a.png"), photographed(linear_picture(model, CAMERA, POSE)))
    camera_file(folder / "camera.toml")
    command = [sys.executable, "-m", "vision_server", "seed", str(folder / "a.png"), "--model",
               str(folder / "cuboid.cao"), "--camera", str(folder / "camera.toml"), "--out",
               str(folder / "seed.toml")]  # fmt: skip
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    guard = threading.Timer(300, process.kill)
    guard.start()
    try:
        found = ADDRESS.match(process.stderr.readline())
        assert found is not None
        yield Page(process, found[1], model, folder / "seed.toml")
    finally:
        guard.cancel()
        process.kill()
        process.communicate()


@pytest.fixture
def page(tmp_path: Path) -> Iterator[Page]:
    with page_in(tmp_path) as one:
        yield one


def clicks(page: Page, corners: tuple[int, ...] = CORNERS) -> list[dict[str, Any]]:
    at = CAMERA.project(POSE.apply(page.model.vertices))
    return [{"corner": corner, "at": at[corner].tolist()} for corner in corners]


def test_it_answers_pairs_with_a_pose_and_ends_when_it_has_saved_one(page: Page) -> None:
    for method, path in (("GET", "/"), ("GET", "/image.png"), ("POST", "/pose"), ("POST", "/save")):
        assert page.asked(method, path, clicks(page), token="wrong")[0] == 403
    assert page.asked("GET", "/")[0] == 200
    picture = cv2.imdecode(np.frombuffer(page.asked("GET", "/image.png")[1], np.uint8), cv2.IMREAD_GRAYSCALE)
    assert picture is not None and picture.shape == (CAMERA.height, CAMERA.width)
    for body, told in (
        (clicks(page)[:2], b"at least 3"),
        (b"{", b"no pairs"),
        ([{"corner": 0}], b"no pairs"),
        ([{"corner": 99, "at": [1, 2]}] * 3, b"names a corner"),
        (b" " * 200_000, b"too many"),
    ):
        status, said = page.asked("POST", "/pose", body)
        assert status == 409 and told in said and said.count(b"\n") == 1
    status, said = page.asked("POST", "/pose", clicks(page))
    found = json.loads(said)
    assert status == 200 and found["rms_px"] < 1e-3 and len(found["errors_px"]) == len(CORNERS)
    assert np.allclose(found["rotation"], POSE.matrix, atol=1e-4)
    assert found["lines"]
    assert not page.out.exists()
    assert page.asked("POST", "/save", clicks(page))[0] == 200
    shown, _ = page.process.communicate(timeout=120)
    assert page.process.returncode == 0
    assert shown == page.out.read_text()
    assert read_seed_pose(page.out, page.model).error_to(POSE).within(0.01, 1e-4)


def test_ctrl_c_ends_it_with_nothing_saved(page: Page) -> None:
    assert page.asked("GET", "/")[0] == 200
    page.process.send_signal(signal.SIGINT)
    page.process.communicate(timeout=120)
    assert page.process.returncode == 130
    assert not page.out.exists()


def test_a_person_clicks_corners_sees_the_model_and_saves(page: Page) -> None:
    with Browser() as browser:
        browser.open(page.address)

        def click(x: float, y: float) -> None:
            for kind in ("mousePressed", "mouseReleased"):
                browser.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

        browser.until('document.querySelector("svg image").getBBox().width > 0')
        for one in clicks(page):
            x, y = browser.value(f"""(() => {{
                const box = drawing.getBoundingClientRect(), scale = box.width / drawing.width
                const [x, y] = place(model.corners[{one["corner"]}])
                return [box.left + x * scale, box.top + y * scale]
            }})()""")
            click(x, y)
            browser.until(f"chosen === {one['corner']}", 20)
            u, v = one["at"]
            x, y = browser.value(f"""(() => {{
                const at = new DOMPoint({u}, {v}).matrixTransform(photo.getScreenCTM())
                return [at.x, at.y]
            }})()""")
            click(x, y)
            browser.until("chosen === null", 20)
        browser.until('!save.disabled && pairs.length === 4 && list.innerText.includes("off by")')
        assert browser.value('document.querySelectorAll("#wire path").length') >= 9
        assert "RMS" in browser.value("said.textContent")
        assert browser.value("document.documentElement.scrollWidth <= window.innerWidth")
        browser.value('document.querySelector("#pairs button").click()')
        browser.until("!save.disabled && pairs.length === 3")
        browser.value("save.click()")
        browser.until('said.textContent.includes("Saved as")')
    page.process.communicate(timeout=120)
    assert page.process.returncode == 0
    assert read_seed_pose(page.out, page.model).error_to(POSE).within(2.0, 0.02)
