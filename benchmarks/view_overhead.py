"""What the live view costs a session: without one, with one that nobody opens, with one that is watched.

python -m benchmarks.view_overhead [--pairs N] [--images N]
"""

from __future__ import annotations

import ctypes
import json
import os
import re
import subprocess
import tempfile
import threading
import time
import urllib.request
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from benchmarks.lines import show

ROOT = Path(__file__).resolve().parent.parent
ADDRESS = re.compile(rb"http://127\.0\.0\.1:\d+/\?token=\S+")
WITHOUT, UNWATCHED, WATCHED = "without", "unwatched", "watched"
CLOCKS = {
    "session": "until its result is known",
    "process": "until the command ends",
    "processor": "of all its processes",
}
DEADLINE_S = 120.0
PR_SET_CHILD_SUBREAPER = 36  # <linux/prctl.h>
DRAWS = 4000  # of the bootstrap


def watched(address: str) -> None:
    """Follow the page's events to their end, as a browser does."""
    base, token = address.split("/?")
    with urllib.request.urlopen(f"{base}/events?{token}", timeout=DEADLINE_S) as events:
        while events.readline():
            pass


def session(folder: Path, seed: int, images: int, kind: str) -> dict[str, float]:
    """Seconds that one session took by each clock; the pose never satisfies it, and the strategy goes on."""
    endless = ["--controller", "greedy", "--threshold", "0.000001", "--max-iterations", str(images)]
    command = [
        "swipl",
        "main.pl",
        "--out",
        str(folder),
        "--seed",
        str(seed),
        *endless,
        "--no-report",
        "--quiet",
    ]
    watchers: list[threading.Thread] = []
    began = time.monotonic()
    process = subprocess.Popen(
        command + ["--view"] * (kind != WITHOUT), cwd=ROOT, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL
    )
    assert process.stderr is not None
    for line in process.stderr:
        if kind == WATCHED and (found := ADDRESS.search(line)):
            watchers.append(threading.Thread(target=watched, args=(found[0].decode(),), daemon=True))
            watchers[-1].start()
    used_s = reaped(process.pid)
    ended = time.monotonic()
    for watcher in watchers:
        watcher.join(DEADLINE_S)
    used_s += reaped(-1)  # its view, which has shown the end
    result: dict[str, Any] = json.loads((folder / "result.json").read_text())
    return {
        "session": result["seconds"]["total"],
        "process": ended - began,
        "processor": used_s,
    }


def reaped(process: int) -> float:
    """Wait for a process of ours, or with -1 for all; processor seconds that they used."""
    used_s = 0.0
    while True:
        try:
            _, _, used = os.wait4(process, 0)
        except ChildProcessError:
            return used_s
        used_s += used.ru_utime + used.ru_stime
        if process > 0:
            return used_s


def adopt_orphans() -> None:
    """A view ends after its session, whose child it is: then it becomes ours (prctl(2))."""
    if ctypes.CDLL(None, use_errno=True).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0) != 0:
        raise OSError(ctypes.get_errno(), "prctl")


def tell(kind: str, clock: str, ratios: list[float], images: int) -> None:
    """The median of the pairs, with the 95 % interval of a bootstrap over them."""
    draws = np.random.default_rng(0).choice(ratios, (DRAWS, len(ratios)))
    low, high = np.percentile(np.median(draws, axis=1), (2.5, 97.5))
    low, value, high = (round(float(100 * (one - 1)), 1) for one in (low, np.median(ratios), high))
    of = CLOCKS[clock]
    show(f"view_{kind}_{clock}", value, "%", of=of, interval=[low, high], pairs=len(ratios), images=images)


def main(
    pairs: Annotated[int, typer.Option(help="Sessions of each kind.")] = 8,
    images: Annotated[int, typer.Option(help="Images of each session.")] = 20,
) -> None:
    """Run the sessions in turn, each round in another order; one JSON object a line."""
    adopt_orphans()
    ratios: dict[tuple[str, str], list[float]] = {}
    kinds = [WITHOUT, UNWATCHED, WATCHED]
    with tempfile.TemporaryDirectory() as folder:
        session(Path(folder, "first"), 1, 1, WITHOUT)  # files are read once, kernels are there
        for seed in range(1, pairs + 1):
            order = [*kinds[seed % 3 :], *kinds[: seed % 3]][:: -1 if seed % 2 else 1]
            took = {kind: session(Path(folder, f"{seed}-{kind}"), seed, images, kind) for kind in order}
            for kind in (UNWATCHED, WATCHED):
                for clock in CLOCKS:
                    ratios.setdefault((kind, clock), []).append(took[kind][clock] / took[WITHOUT][clock])
    for (kind, clock), found in ratios.items():
        tell(kind, clock, found, images)


if __name__ == "__main__":
    typer.run(main)
