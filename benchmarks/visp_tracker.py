"""ViSP's trackers, as a program of its own that is compiled for each run."""

from __future__ import annotations

import os
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from geometry.pose import Pose
from numerics.arrays import Floats

SOURCE = Path(__file__).with_name("visp_tracker.cpp")
LIBRARIES = ("mbt", "io", "core", "me", "klt", "vision", "visual_features")
KINDS = ("edge", "both")


@dataclass(frozen=True, eq=False)
class Step:
    """One frame of a track; the covariance (6, 6) is of a left-multiplied step, None where none is stated."""

    pose: Pose | None
    covariance: Floats | None
    state: str
    seconds: float


def visp(
    images: list[Path], folder: Path, model: Path, seed_pose: Pose, prefix: Path, kind: str
) -> list[Step]:
    """ViSP's tracker of moving edges (`edge`), or of these and KLT points (`both`)."""
    libraries = prefix / "lib" / "x86_64-linux-gnu"
    places = [libraries, libraries / "lapack", libraries / "blas", prefix / "lib"]
    found = os.environ | {"LD_LIBRARY_PATH": ":".join(map(str, places))}
    includes = ("include/x86_64-linux-gnu", "include", "include/opencv4")
    with tempfile.TemporaryDirectory() as place:
        program = Path(place) / "visp_tracker"
        subprocess.run(
            ["g++", "-O2", *(f"-I{prefix / one}" for one in includes), str(SOURCE), "-o", str(program),
             f"-L{libraries}", *(f"-lvisp_{one}" for one in LIBRARIES), "-Wl,--allow-shlib-undefined"],
            check=True, env=found,
        )  # fmt: skip
        first = [repr(float(x)) for x in (*seed_pose.translation, *seed_pose.rotation_vector)]
        command = [str(program), str(folder / "visp.xml"), str(model), kind, *first, *map(str, images)]
        told = subprocess.run(command, check=True, capture_output=True, text=True, env=found).stdout
    steps = []
    for line in told.splitlines():
        if line == "lost":
            steps.append(Step(None, None, "lost", 0.0))
            continue
        numbers = np.array(line.split(), dtype=np.float64)
        steps.append(Step(Pose(numbers[3:6], numbers[:3]), None, "sure", 1e-3 * float(numbers[6])))
    return steps
