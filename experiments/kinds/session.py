"""Sessions: `swipl main.pl` against the servers of a warm worker."""

import json
import shutil
import subprocess
import sys
from contextlib import suppress
from typing import Any

from experiments.kinds import TIMES, Row
from experiments.plan import Cell
from experiments.version import ROOT
from experiments.worker import Worker

REPORT_S = 60.0  # for a report, as a session gives it
MESSAGE_CHARACTERS = 500  # of what a session said that failed
DIES_WITH_PARENT = [shutil.which("setpriv"), "--pdeathsig", "TERM"]


def run(cell: Cell, worker: Worker, *options: str) -> Row:
    """Run one session and tell what became of it.

    `status` is the session's own, `failed` with its last words, or `deadline`.
    """
    folder = worker.run_folder(cell)
    try:
        vision_server = worker.vision_server()
        with worker.hosting(cell) as endpoint:
            command = [
                *(DIES_WITH_PARENT if DIES_WITH_PARENT[0] else ()),
                "swipl", str(ROOT / "main.pl"), *session_options(cell), *options,
                "--image-server", endpoint, "--vision-server", vision_server,
                "--json", "--quiet", "--no-report", "--out", str(folder),
            ]  # fmt: skip
            row = outcome(_ran(command, cell.settings.deadline_s))
        if row["status"] == "deadline":
            worker.abandon_vision_server()
        if worker.keeps_folders and row["status"] not in ("failed", "deadline"):
            report = [sys.executable, "-m", "report", str(folder)]
            with suppress(subprocess.TimeoutExpired):
                subprocess.run(report, cwd=ROOT, stdout=subprocess.DEVNULL, timeout=REPORT_S, check=False)
        return row
    finally:
        if not worker.keeps_folders:
            shutil.rmtree(folder, ignore_errors=True)


def session_options(cell: Cell) -> list[str]:
    """The options of `main.pl` that a cell stands for, but for where its images come from."""
    settings = cell.settings
    threshold = [] if settings.threshold is None else ["--threshold", repr(settings.threshold)]
    return [
        "--controller", cell.controller_source, "--seed", str(cell.seed), "--matcher", settings.matcher,
        "--max-iterations", str(settings.max_iterations), *threshold,
    ]  # fmt: skip


def _ran(command: list[str], deadline_s: float) -> subprocess.CompletedProcess[str] | None:
    try:
        return subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=deadline_s,
            check=False,
            start_new_session=True,  # Ctrl-C is for the engine, which lets cells come to their end
        )
    except subprocess.TimeoutExpired:
        return None


def outcome(done: subprocess.CompletedProcess[str] | None) -> Row:
    """The columns of a session that has ended, from what it printed."""
    if done is None:
        return {"status": "deadline"}
    try:
        result: dict[str, Any] = json.loads(done.stdout)
    except json.JSONDecodeError:
        words = done.stderr.strip()[-MESSAGE_CHARACTERS:]
        return {"status": "failed", "message": words or f"exit status {done.returncode}"}
    if result["status"] == "stopped":
        return {"status": "failed", "message": done.stderr.strip()[-MESSAGE_CHARACTERS:] or "stopped"}
    error = result.get("error") or {}
    return {
        "status": result["status"],
        "images": result["iterations"],
        "kept": len(result["kept"]),
        "rotation_deg": error.get("rotation_deg"),
        "translation_fraction": error.get("translation_fraction_of_range"),
        "merit": result["merit_px"],
        "rms_px": result["rms_px"],
        "uncertainty": result["uncertainty"],
        "seconds": result["seconds"]["total"],
        **{f"{part}_s": result["seconds"].get(part) for part in TIMES},
        "holds": result.get("holds"),
    }
