"""Draw the docs' pictures of pages as headless Chromium shows them: `python -m tests.report.pictures`."""

import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2

from benchmarks.planted_faults import Planted
from bridge.serve import Server
from experiments.warm_servers import Served
from image_server.serve.server import ImageServer
from tests.report.browser import Browser
from tests.session.command import ROOT, controller

IMAGES = ROOT / "docs" / "images"
WIDE, PHONE = 1200, 390
SHRINK = 0.6  # of a wide page


def session(folder: Path, *options: str) -> Path:
    """A session with its report; its run folder."""
    done = controller("--out", folder, "--quiet", *options)
    assert done.returncode in (0, 3), done.stderr
    return folder


@contextmanager
def live(folder: Path) -> Iterator[str]:
    """The address of a folder's live view."""
    command = [sys.executable, "-m", "report", "live", str(folder)]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as view:
        assert view.stdout is not None
        try:
            yield re.findall(r"http\S+", view.stdout.readline())[0]
        finally:
            view.terminate()


def picture(
    out: Path, address: str, width: int, rows: slice, ready: str = "true", dark: bool = False
) -> None:
    """Rows of a page as a small PNG."""
    with Browser(width, 900, dark) as page:
        page.open(address)
        page.until(ready)
        page.picture(out)
    drawn = cv2.imread(str(out))
    assert drawn is not None
    scale = SHRINK if width == WIDE else 1.0
    drawn = cv2.resize(drawn[rows], None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    assert cv2.imwrite(str(out), drawn, [cv2.IMWRITE_PNG_COMPRESSION, 9])


def with_a_dead_light(folder: Path) -> Path:
    """A session in which a light dies after the first image, and no one tells; its run folder."""
    endpoint = f"ipc://{folder}/images"
    device = Planted("eclipse", 1, "light_dead", 2, folder)
    served = Served(Server(ImageServer(device), endpoint, f"{endpoint}-events"))
    try:
        return session(folder / "surprised", "--controller", "informed", "--image-server", endpoint)
    finally:
        served.stop()


def main(out: Path) -> None:
    """Run the sessions, draw their pages."""
    with tempfile.TemporaryDirectory() as folder:
        informed = session(
            Path(folder, "informed"), "--controller", "informed", "--target", "satellite",
            "--scenario", "grazing", "--threshold", "0.03", "--max-iterations", "6",
        )  # fmt: skip
        with live(informed) as address:
            loaded = (
                'performance.getEntriesByType("resource").filter(one => one.name.includes("images/")).length'
            )
            drawn = f'document.querySelectorAll("#course svg").length > 2 && {loaded} >= 5'
            picture(out / "live.png", address, WIDE, slice(0, 1800), drawn, dark=True)
        approach = session(Path(folder, "approach"), "--approach", "--seed", "3")
        report = (approach / "report.html").as_uri()
        picture(out / "report-approach.png", report, WIDE, slice(1240, 1925))
        with live(approach) as address:
            picture(out / "live-approach.png", address, PHONE, slice(0, 1430), f"{loaded} >= 14", dark=True)
        picture(out / "report-phone.png", (informed / "report.html").as_uri(), PHONE, slice(0, 1500))
        surprised = with_a_dead_light(Path(folder))
        picture(out / "surprise.png", (surprised / "report.html").as_uri(), WIDE, slice(2553, 3853))
        recorded = session(Path(folder, "recorded"), "--target", "satellite", "--scenario", "grazing",
                           "--threshold", "0.0001", "--max-iterations", "4")  # fmt: skip
        wrong = session(Path(folder, "wrong"), "--stack", str(recorded / "images"), "--target",
                        "targets/cube.cao", "--max-iterations", "4")  # fmt: skip
        page = wrong / "report.html"
        page.write_text(page.read_text().replace(folder, "runs"))  # not where this machine has it
        picture(out / "report-failure.png", page.as_uri(), WIDE, slice(0, 1270), dark=True)
        long = session(Path(folder, "long"), "--controller", "simple", "--scenario", "harsh",
                       "--threshold", "0.001", "--max-iterations", "40")  # fmt: skip
        with live(long) as address:
            picture(out / "live-long.png", address, PHONE, slice(0, 2900), drawn)
        subprocess.run(
            [sys.executable, "-m", "report", "whatif", str(informed), "--at", "2",
             "--settings", "left 7 right 7 top 7, 1/15 s, f/2.8", "--out", str(Path(folder, "other"))],
            cwd=ROOT, check=True, stdout=subprocess.DEVNULL,
        )  # fmt: skip
        picture(out / "whatif.png", Path(folder, "other", "whatif.html").as_uri(), WIDE, slice(0, 1070))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if sys.argv[1:] else IMAGES)
