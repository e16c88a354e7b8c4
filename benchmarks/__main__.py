"""What `make bench` prints: one JSON object a line, peers measured in the same run."""

import json
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import msgspec
import numpy as np

from benchmarks.edge_times import all_edge_times, simulated
from benchmarks.simulator_times import simulator
from benchmarks.transport import transport
from geometry.camera import Camera
from geometry.model import load_model
from image_server.simulator import Simulator
from vision_server.image_set import ImageSet
from vision_server.pipeline import estimate_pose

ROOT = Path(__file__).resolve().parent.parent
REPEATS = 9


def show(name: str, value: float, unit: str, **more: float) -> None:
    """Print one measurement."""
    rounded = {key: round(number, 4) for key, number in more.items()}
    print(json.dumps({"name": name, "value": round(value, 4), "unit": unit, **rounded}), flush=True)


def milliseconds(run: Callable[[], object]) -> float:
    """Median time of a call, after one that does not count."""
    run()
    times = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        run()
        times.append(1000.0 * (time.perf_counter() - began))
    return float(np.median(times))


def poses() -> None:
    """Stages of an estimate from four images, against cv2's LSD on the same four."""
    for target in ("cube", "fixture", "satellite"):
        pose(target)


def pose(target: str) -> None:
    """One target's estimate."""
    simulator = Simulator(target, "nominal", 1)
    images = simulated(target)
    described = simulator.describe()
    assert described.camera is not None
    assert described.target is not None
    camera = Camera.from_dict(msgspec.to_builtins(described.camera))
    model = load_model(Path(described.target.model), described.target.unit)
    seed_pose = simulator.seed_pose
    assert seed_pose is not None
    image_set = ImageSet(camera.width, camera.height)
    for number, image in enumerate(images):
        image_set.add(f"i{number}", image, 2.0, 1.0)
    names = list(image_set.images)
    whole = milliseconds(lambda: estimate_pose(image_set, names, model, camera, seed_pose))
    stages = estimate_pose(image_set, names, model, camera, seed_pose).seconds
    detector = cv2.createLineSegmentDetector()
    lsd = milliseconds(lambda: [detector.detect(image) for image in images])
    show(
        f"estimate/{target}", whole, "ms", lsd_ms=lsd, ratio=whole / lsd,
        **{f"{stage}_ms": 1000.0 * seconds for stage, seconds in stages.items()},
    )  # fmt: skip


def golog() -> None:
    """Steps of Golog programs, against the published interpreter; memory of a long run."""
    script = ROOT / "benchmarks" / "golog.pl"
    for words in ([], ["memory", "offline"], ["memory", "online"]):
        subprocess.run(["swipl", str(script), *words], check=True, stdin=subprocess.DEVNULL)


if __name__ == "__main__":
    all_edge_times(show)
    poses()
    golog()
    simulator(show)
    transport(show)
