"""What the live view costs a session: sessions in pairs, with a view that somebody watches and without.

python -m benchmarks.view_overhead [--pairs N]
"""

from __future__ import annotations

import json
import os
import re
import statistics
import subprocess
import tempfile
import threading
import urllib.request
from pathlib import Path
from typing import Annotated, Any

import typer

ROOT = Path(__file__).resolve().parent.parent
ADDRESS = re.compile(rb"http://127\.0\.0\.1:\d+/\?token=\S+")
IMAGES = 10
DEADLINE_S = 120.0


def watched(address: str) -> None:
    """Follow the page's events to their end, as a browser does."""
    base, token = address.split("/?")
    with urllib.request.urlopen(f"{base}/events?{token}", timeout=DEADLINE_S) as events:
        while events.readline():
            pass


def session(folder: Path, seed: int, view: bool) -> dict[str, float]:
    """Seconds that one session took by the wall clock, and of the processor for all its processes."""
    command = ["swipl", "main.pl", "--out", str(folder), "--seed", str(seed), "--threshold", "0.000001",
               "--max-iterations", str(IMAGES), "--no-report", "--quiet"]  # fmt: skip
    watchers: list[threading.Thread] = []
    process = subprocess.Popen(
        [*command, *["--view"] * view], cwd=ROOT, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL
    )
    assert process.stderr is not None
    for line in process.stderr:
        if found := ADDRESS.search(line):
            watchers.append(threading.Thread(target=watched, args=(found[0].decode(),), daemon=True))
            watchers[-1].start()
    _, _, used = os.wait4(process.pid, 0)
    for watcher in watchers:
        watcher.join(DEADLINE_S)
    result: dict[str, Any] = json.loads((folder / "result.json").read_text())
    return {"wall": result["seconds"]["total"], "processor": used.ru_utime + used.ru_stime}


def main(pairs: Annotated[int, typer.Option(help="Sessions of each kind.")] = 5) -> None:
    """Run the pairs in turn; one JSON object a line."""
    ratios: dict[str, list[float]] = {"wall": [], "processor": []}
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(1, pairs + 1):
            order = (False, True) if seed % 2 else (True, False)
            took = {view: session(Path(folder, f"{seed}-{view}"), seed, view) for view in order}
            for clock, found in ratios.items():
                found.append(took[True][clock] / took[False][clock])
    for clock, found in ratios.items():
        value = 100 * (statistics.median(found) - 1)
        told = {"name": f"view_overhead_{clock}", "value": round(value, 1), "unit": "%", "pairs": pairs}
        print(json.dumps(told | {"all": [round(100 * (ratio - 1), 1) for ratio in found]}))


if __name__ == "__main__":
    typer.run(main)
