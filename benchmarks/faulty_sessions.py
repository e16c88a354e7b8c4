"""Whole sessions in which something goes wrong that no one tells: what is trusted at their end; is it right?

    .venv/bin/python -m benchmarks.faulty_sessions [SCENE...] [--seeds 2] [--controller informed] [--rows]

A scene is as `benchmarks.surprises` has it. Each session runs to its end by `swipl main.pl`, once without a
fault and once with each kind of `benchmarks.planted_faults`: after the first image (`--after`) a light dies,
two are swapped, the sun changes, the target moves by 1 % of the range, or an arm comes in front; or the model
is 2 % too long along an axis from the start. With `--fault flicker` all light of each image is up to 15 %
more or less; whatever is said then is wrong. One JSON object a kind: sessions; in how many the fault had
`happened` before they ended; in how many of those it was `named`, or something else was (`named_otherwise`),
how many poses are `trusted`, `right`, and `wrong_and_trusted`; all their images. A pose is wrong that is off
by 1 degree or 1 % of the range from where the target is at the end, after a move by half of that move. With
`--rows`, an object a session, too.
"""

from __future__ import annotations

import json
import re
import subprocess
import tempfile
from collections import Counter
from itertools import product
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer

from benchmarks.planted_faults import KINDS, MOVED, Planted
from benchmarks.surprises import SCENES
from bridge.serve import Server
from experiments.kinds.session import DIES_WITH_PARENT
from experiments.version import ROOT
from experiments.warm_servers import Served, served_vision
from geometry.pose import RIGHT, Pose
from image_server.serve.server import ImageServer
from numerics.two_cores import use_one_core

DEADLINE_S = 300
SAID = re.compile(r"^exogenous\(\d+,surprise\(\w+,(\w+)(?:\(([^)]*)\))?\)\)", re.MULTILINE)
COUNTED = (
    "sessions", "happened", "named", "named_otherwise", "trusted", "right", "wrong_and_trusted", "images",
)  # fmt: skip


class Ended(NamedTuple):
    """A session at its end: pose or None, whether it is trusted, images taken, what was said."""

    pose: Pose | None
    trusted: bool
    images: int
    said: list[tuple[str, tuple[str, ...]]]


def session(device: Planted, vision_server: str, folder: Path, controller: str, seed: int) -> Ended:
    """Run one to its end."""
    endpoint = f"ipc://{folder}/images"
    served = Served(Server(ImageServer(device), endpoint, f"{endpoint}-events"))
    command = [
        *(DIES_WITH_PARENT if DIES_WITH_PARENT[0] else ()),
        "swipl", str(ROOT / "main.pl"), "--controller", controller, "--seed", str(seed),
        "--image-server", endpoint, "--vision-server", vision_server, "--json", "--quiet", "--no-report",
        "--out", str(folder / "run"),
    ]  # fmt: skip
    try:
        done = subprocess.run(
            command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=DEADLINE_S, check=False
        )
    finally:
        served.stop()
    if done.returncode not in (0, 3):
        raise RuntimeError(f"{' '.join(command)}: {done.stderr.strip()}")
    result: dict[str, Any] = json.loads(done.stdout)
    told = SAID.findall((folder / "run" / "history.pl").read_text())
    said = [(cause, tuple(lights.replace("'", "").split(",")) if lights else ()) for cause, lights in told]
    pose = None if result["pose"] is None else Pose.from_dict(result["pose"])
    return Ended(pose, result["status"] == "converged", result["iterations"], said)


def is_right(device: Planted, pose: Pose | None) -> bool:
    """Whether the target is there, after all that has happened."""
    degrees, share = RIGHT
    if device.fault is not None and device.fault.name == "target_moved":
        share = 0.5 * MOVED
    return pose is not None and pose.error_to(device.true).within(degrees, share)


def outcome(device: Planted, ended: Ended, kind: str) -> Counter[str]:
    """What a session adds to the row of its kind."""
    count = Counter({"sessions": 1, "images": ended.images})
    if device.fault is None and kind != "nothing":
        return count
    names = [light.name for light in device.describe().lights]
    lights = () if device.fault is None else tuple(names[light] for light in device.fault.lights)
    right = is_right(device, ended.pose)
    named = [cause == kind and (about == lights or kind == "model_wrong") for cause, about in ended.said]
    count["happened"] = 1
    count["named"], count["named_otherwise"] = int(any(named)), int(not all(named))
    count["trusted"], count["right"] = int(ended.trusted), int(right)
    count["wrong_and_trusted"] = int(ended.trusted and not right)
    return count


def main(
    scenes: Annotated[list[str] | None, typer.Argument(metavar="SCENE...")] = None,
    seeds: Annotated[int, typer.Option(min=1)] = 2,
    controller: Annotated[str, typer.Option(help="A strategy, as --controller of a session.")] = "informed",
    fault: Annotated[list[str] | None, typer.Option(metavar="KIND", help="Only these.")] = None,
    after: Annotated[int, typer.Option(min=1, help="Images before the fault.")] = 1,
    rows: Annotated[bool, typer.Option(help="Print each session, too.")] = False,
) -> None:
    """Run sessions with and without faults to their end."""
    use_one_core()
    kinds = fault or ["nothing", *KINDS]
    counts = {kind: Counter[str]() for kind in kinds}
    with tempfile.TemporaryDirectory() as scratch:
        vision = served_vision(f"ipc://{scratch}/vision", recorded=True)
        for scene, seed, kind in product(scenes or SCENES, range(1, seeds + 1), kinds):
            with tempfile.TemporaryDirectory() as folder:
                device = Planted(scene, seed, kind, after + 1, Path(folder))
                ended = session(device, vision.endpoint, Path(folder), controller, seed)
            count = outcome(device, ended, kind)
            counts[kind] += count
            if rows:
                off = None if ended.pose is None else ended.pose.error_to(device.true)
                told = {
                    "scene": Path(scene).name,
                    "seed": seed,
                    "fault": str(device.fault),
                    "said": ended.said,
                }
                error = None if off is None else [off.rotation_deg, off.translation_fraction_of_range]
                print(json.dumps({"kind": kind, **told, **count, "error": error}), flush=True)
        vision.stop()
    for kind in kinds:
        row = {what: counts[kind][what] for what in COUNTED}
        print(json.dumps({"name": f"faulty-session-{kind}", **row}))


if __name__ == "__main__":
    typer.run(main)
