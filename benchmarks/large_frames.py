"""What frames of 12 megapixels cost `estimate`: memory and processor time, by the target's size.

    .venv/bin/python -m benchmarks.large_frames [--fills 0.25,0.75] [--bits 8] [--first-sight]

One JSON object per size of the target (its diameter over the frame's height): by how much the peak of the
command's memory grows with each image from one to four, that peak with one image, the processor's seconds.
"""

from __future__ import annotations

import os
import subprocess
import sys
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import cv2
import numpy as np
import typer

from benchmarks.lines import show
from geometry.camera import Camera
from geometry.model import Model, find_target, load_model
from geometry.pose import Pose, disturbed, search_translation_px
from vision_server.commands.warm import drawn

CAMERA = Camera(4000, 3000, 4800.0, 4800.0, 1999.5, 1499.5)
TARGET = "cube"
TURNED = np.array([0.5, 0.7, 0.1])
IMAGES = 4
BLUR_PX, NOISE_GREY = 0.8, 1.0
DEPTHS = {8: np.uint8, 16: np.uint16}


def write_scene(folder: Path, model: Model, fills: float, bits: int) -> None:
    """Photographs that differ by their noise, the camera and a poor seed pose, into a folder."""
    range_m = CAMERA.fy * model.diameter / (fills * CAMERA.height)
    pose, rng = Pose(TURNED, np.array([0.0, 0.0, range_m])), np.random.default_rng(0)
    picture = drawn(model, CAMERA, pose, BLUR_PX)
    for number in range(IMAGES):
        noisy = np.clip(picture + rng.normal(0.0, NOISE_GREY, picture.shape), 0, 255)
        stored = np.rint(noisy * ((2**bits - 1) / 255)).astype(DEPTHS[bits])
        cv2.imwrite(str(folder / f"{number}.png"), stored)
    start = disturbed(pose, rng, 25.0, search_translation_px(CAMERA.width), CAMERA.fx)
    for name, table in (("camera", CAMERA.to_dict()), ("target.seed_pose", start.to_dict())):
        rows = "".join(f"{key} = {value}\n" for key, value in table.items())
        (folder / f"{name}.toml").write_text(f"[{name}]\n{rows}")


def measured(folder: Path, count: int, first_sight: bool = False) -> tuple[float, float]:
    """Peak of the memory, MB, and processor time, s, of the command on so many of the images."""
    command = [sys.executable, "-m", "vision_server", "estimate", "--model", str(find_target(TARGET))]
    command += ["--camera", str(folder / "camera.toml")]
    command += [] if first_sight else ["--seed-pose", str(folder / "target.seed_pose.toml")]
    command += ["--exposures", ",".join(["1"] * count), "--json"]
    command += [str(folder / f"{number}.png") for number in range(count)]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as process:
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f"estimate ended with {process.returncode}")
    return used.ru_maxrss / 1024.0, used.ru_utime + used.ru_stime


def main(
    fills: Annotated[str, typer.Option(help="Diameters, over the frame's height.")] = "0.25,0.75",
    bits: Annotated[int, typer.Option(help="Of the files: 8 or 16.")] = 8,
    first_sight: Annotated[bool, typer.Option("--first-sight", help="Without a seed pose.")] = False,
) -> None:
    """Memory and time of one and of four images."""
    model = load_model(find_target(TARGET))
    for share in map(float, fills.split(",")):
        with TemporaryDirectory() as name:
            write_scene(Path(name), model, share, bits)
            of = partial(measured, Path(name), first_sight=first_sight)
            (one_mb, one_s), (all_mb, all_s) = of(1), of(IMAGES)
        show(
            "12 megapixels",
            (all_mb - one_mb) / (IMAGES - 1),
            "MB an image",
            fills=share,
            bits=bits,
            one_image_mb=round(one_mb),
            one_image_s=one_s,
            all_images_s=all_s,
        )


if __name__ == "__main__":
    typer.run(main)
