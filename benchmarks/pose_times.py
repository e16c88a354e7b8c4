"""Times of matching, refinement and whole estimates, and of the vision server's start; LSD is the peer."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np

from benchmarks.lines import Show
from benchmarks.photographs import image_set, simulated_studio
from bridge.client import Client
from bridge.errors import LightsAndCameraError
from geometry.pose import disturbed
from vision_server.baselines.genetic import match_genetic
from vision_server.image_set import ImageSet
from vision_server.matching import match_search
from vision_server.pipeline import estimate_pose
from vision_server.pose.observation import PoseProblem
from vision_server.pose.sampling import spacing_for
from vision_server.segments.extraction import extract_segments
from vision_server.trust.ranking import COARSE_REACHES_PX, FINE_REACHES_PX, best_first, refined

ROOT = Path(__file__).resolve().parent.parent
REPEATS = 9
STARTS = 3  # of the server
START_DEADLINE_S = 30.0
RETRY_S = 0.01


def milliseconds(run: Callable[[], object]) -> float:
    """Median time of a call, after one that does not count."""
    run()
    times = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        run()
        times.append(1000.0 * (time.perf_counter() - began))
    return float(np.median(times))


def pose_times(show: Show) -> None:
    """Print all of them."""
    for target in ("cube", "fixture", "satellite"):
        _target(show, target)
    seconds = [_start() for _ in range(STARTS)]
    show("vision_server/start", float(np.median(seconds)), "s", least=min(seconds), most=max(seconds))


def _target(show: Show, target: str) -> None:
    studio = simulated_studio(target, "nominal", 1)
    lights = [*(studio.full(only) for only in range(len(studio.middle))), studio.middle]
    shots = [studio.photograph(levels) for levels in lights]
    camera, model, middle = studio.camera, studio.model, shots[-1]
    seed = disturbed(studio.true, np.random.default_rng(1), 25.0, 40.0, camera.fx)
    detector = cv2.createLineSegmentDetector()
    lsd = milliseconds(lambda: detector.detect(middle.pixels))

    def features() -> ImageSet:
        return image_set([middle])

    def matched() -> object:
        segments = extract_segments(features().edge_map(["i0"])).endpoints
        return match_search(segments, model, camera, seed, 0)

    matching = milliseconds(matched)
    show(f"matching/{target}(features included)", matching, "ms", lsd_ms=lsd, ratio=matching / lsd)
    one = features()
    segments = extract_segments(one.edge_map(["i0"])).endpoints
    genetic = milliseconds(lambda: match_genetic(segments, model, camera, seed, 0))
    show(f"matching/{target}(genetic)", genetic, "ms", lsd_ms=lsd, ratio=genetic / lsd)
    start = match_search(segments, model, camera, seed, 0)[0].pose
    problem = PoseProblem.at_scale(one.gradients(["i0"]), model, camera)
    problem = best_first(problem, [start])[0].problem
    reaches = (*COARSE_REACHES_PX, *FINE_REACHES_PX[1:])
    spacing = spacing_for(model, camera, start)
    alone = milliseconds(lambda: refined(problem, start, reaches, spacing))
    show(f"refinement/{target}(one pose)", alone, "ms", lsd_ms=lsd, ratio=alone / lsd)
    images = image_set(shots)
    names = list(images.images)
    whole = milliseconds(lambda: estimate_pose(images, names, model, camera, seed))
    stages = estimate_pose(images, names, model, camera, seed).seconds
    show(
        f"estimate/{target}(four images)", whole, "ms", lsd_ms=4 * lsd, ratio=whole / (4 * lsd),
        **{f"{stage}_ms": 1000.0 * seconds for stage, seconds in stages.items()},
    )  # fmt: skip


def _start() -> float:
    """Seconds from starting the vision server to its first reply."""
    with TemporaryDirectory() as folder:
        endpoint = f"ipc://{folder}/vision.sock"
        began = time.perf_counter()
        command = [sys.executable, "-m", "vision_server", "serve", "--endpoint", endpoint]
        server = subprocess.Popen(command, cwd=ROOT)
        try:
            while not Path(folder, "vision.sock").exists():
                if time.perf_counter() - began > START_DEADLINE_S or server.poll() is not None:
                    raise LightsAndCameraError("The vision server did not start.", "See its message above.")
                time.sleep(RETRY_S)
            client = Client(endpoint, timeout_s=START_DEADLINE_S)
            client.request("hello")
            seconds = time.perf_counter() - began
            client.request("shutdown")
            client.close()
            server.wait(START_DEADLINE_S)
        finally:
            if server.poll() is None:
                server.kill()
                server.wait()
    return seconds
