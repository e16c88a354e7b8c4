"""Success and error of the pose on recorded images from disturbed starts, through the whole pipeline.

    .venv/bin/python -m benchmarks.pose_accuracy FOLDER [--starts 8] [--rotation-deg 25] [--translation-px 40]
        [--command-line]

FOLDER holds images, `camera.toml`, a `.cao` model and poses, either one 4x4 matrix per image
(`Camera_L_*.txt`, or `CameraPose/Camera_*.txt` of `Images/Image_*.pgm`, exact) or tracks of a tracker
(`visp_*_poses.txt`; then the error is that to the nearer track).
One JSON object per estimate, then one with the success rate, the median and the 90th percentile.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from geometry.camera import Camera
from geometry.model import Model, load_model
from geometry.pose import RIGHT, Pose, disturbed
from vision_server.channels.image_files import read_grey
from vision_server.channels.tone import file_tone
from vision_server.image_set import ImageSet
from vision_server.matching import SearchRange
from vision_server.pipeline import PipelineSettings, estimate_pose
from vision_server.serve.inputs import read_camera

COMMAND_DEADLINE_S = 60.0
TRACK_LIMITS_MM_DEG = (6.4, 2.7)  # how far apart two trackers are on the same frames, 90th percentile


@dataclass(frozen=True)
class Trial:
    """One image, a start, and the poses that count as true."""

    folder: Path
    image: Path
    number: int
    true: tuple[Pose, ...]
    rotation_deg: float
    translation_px: float
    matcher: str
    command_line: bool


def true_poses(folder: Path) -> dict[Path, tuple[Pose, ...]]:
    """Images of a folder with their true poses, or with one pose of each track."""
    matrices = {
        folder / f"{file.stem.removeprefix('Camera_L_')}_L.jpg": file
        for file in folder.glob("Camera_L_*.txt")
    } | {
        folder / "Images" / f"Image_{int(file.stem.removeprefix('Camera_')):04d}.pgm": file
        for file in folder.glob("CameraPose/Camera_*.txt")
    }
    if matrices:
        read = {image: np.loadtxt(matrices[image]) for image in sorted(matrices)}
        return {image: (Pose.from_matrix(m[:3, :3], m[:3, 3]),) for image, m in read.items()}
    tracks = [np.loadtxt(file) for file in sorted(folder.glob("visp_*_poses.txt"))]
    if not tracks:
        raise typer.BadParameter(f"{folder} has no poses (Camera_L_*.txt or visp_*_poses.txt)")
    return {
        folder / f"image{int(rows[0][0]):04d}.png": tuple(Pose(row[4:7], row[1:4]) for row in rows)
        for rows in zip(*tracks, strict=True)
    }


@cache
def _scene(folder: Path) -> tuple[Camera, Model, float | None]:
    camera, table = read_camera(folder / "camera.toml")
    return camera, load_model(next(folder.glob("*.cao"))), table.get("gamma")


def in_process(trial: Trial, start: Pose) -> dict[str, Any]:
    """The estimate from a start pose, with the keys of the command's JSON."""
    camera, model, gamma = _scene(trial.folder)
    (exponent,), tone_sd_px = file_tone([trial.image], gamma)
    images = ImageSet(camera.width, camera.height)
    images.add("i1", read_grey(trial.image), 1.0, exponent)
    settings = PipelineSettings(matcher=trial.matcher, seed=trial.number, tone_sd_px=tone_sd_px)
    estimate = estimate_pose(images, ["i1"], model, camera, start, settings)
    return {
        "pose": None if estimate.pose is None else estimate.pose.to_dict(),
        "score": estimate.score,
        "ambiguity": estimate.ambiguity,
        "rms_px": estimate.rms_px,
        "supported_fraction": estimate.supported_fraction,
        "uncertainty": estimate.uncertainty,
        "seconds": {"total": sum(estimate.seconds.values())},
    }


def by_command(trial: Trial, start: Pose) -> dict[str, Any]:
    """What `python -m vision_server estimate` prints for one image and a start pose."""
    with tempfile.TemporaryDirectory() as scratch:
        seed_pose = Path(scratch) / "seed_pose.toml"
        values = (f"{key} = {list(value)}\n" for key, value in start.to_dict().items())
        seed_pose.write_text("[target.seed_pose]\n" + "".join(values))
        command: list[str | Path] = [
            sys.executable, "-m", "vision_server", "estimate", trial.image,
            "--model", next(trial.folder.glob("*.cao")), "--camera", trial.folder / "camera.toml",
            "--seed-pose", seed_pose, "--matcher", trial.matcher, "--seed", str(trial.number), "--json",
        ]  # fmt: skip
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=COMMAND_DEADLINE_S, check=False
        )
    if done.returncode not in (0, 3):
        raise RuntimeError(f"exit {done.returncode}: {done.stderr.strip()}")
    out: dict[str, Any] = json.loads(done.stdout)
    return out


def run_trial(trial: Trial) -> dict[str, Any]:
    """Estimate one pose and compare it with the truth."""
    camera, model, _ = _scene(trial.folder)
    rng = np.random.default_rng([trial.number, int(trial.rotation_deg)])
    start = disturbed(trial.true[0], rng, trial.rotation_deg, trial.translation_px, camera.fx, model.middle)
    estimate = (by_command if trial.command_line else in_process)(trial, start)
    row: dict[str, Any] = {"image": trial.image.name, "start": trial.number, "right": False}
    row |= {
        "seconds": estimate["seconds"]["total"],
        "score": estimate["score"],
        "ambiguity": estimate["ambiguity"],
    }
    if estimate["pose"] is None:
        return row
    pose = Pose.from_dict(estimate["pose"])
    errors = [pose.error_to(true) for true in trial.true]
    nearest = min(errors, key=lambda error: error.translation_m / TRACK_LIMITS_MM_DEG[0] * 1e3)
    if len(trial.true) == 1:
        right = nearest.within(*RIGHT)
    else:
        limit_mm, limit_deg = TRACK_LIMITS_MM_DEG
        right = any(e.translation_m * 1e3 <= limit_mm and e.rotation_deg <= limit_deg for e in errors)
    return row | {
        "right": right,
        "translation_mm": nearest.translation_m * 1e3,
        "rotation_deg": nearest.rotation_deg,
        "fraction_of_range": nearest.translation_fraction_of_range,
        "rms_px": estimate["rms_px"],
        "supported_fraction": estimate["supported_fraction"],
        "uncertainty": estimate["uncertainty"],
    }


def trials(
    folder: Path, starts: int, rotation_deg: float, translation_px: float, matcher: str, command_line: bool
) -> Iterator[Trial]:
    """Every image of a folder with so many starts each."""
    for index, (image, true) in enumerate(sorted(true_poses(folder).items())):
        for start in range(starts):
            yield Trial(
                folder, image, 1000 * index + start, true, rotation_deg, translation_px, matcher, command_line
            )


def summary(name: str, rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Success rate, and median and 90th percentile of the errors of all poses that were found."""
    found = [row for row in rows if "rotation_deg" in row]
    out: dict[str, Any] = {
        "name": name,
        "value": sum(row["right"] for row in rows) / max(1, len(rows)),
        "unit": "share right",
        "trials": len(rows),
        "no_pose": len(rows) - len(found),
    }
    for key in ("translation_mm", "rotation_deg", "rms_px", "score"):
        values = [row[key] for row in found] or [float("nan")]
        out[key] = {"median": float(np.median(values)), "p90": float(np.percentile(values, 90))}
    out["wrong_with_score_over_0.9"] = sum(not row["right"] and row["score"] > 0.9 for row in rows)
    out["seconds_median"] = float(np.median([row["seconds"] for row in rows]))
    return out


def main(
    folder: Path,
    starts: Annotated[int, typer.Option(min=1)] = 8,
    rotation_deg: Annotated[float, typer.Option(min=0)] = SearchRange.rotation_deg,
    translation_px: Annotated[float, typer.Option(min=0)] = SearchRange.translation_px,
    matcher: str = "search",
    command_line: Annotated[bool, typer.Option(help="Run `vision_server estimate` for each trial.")] = False,
    quiet: Annotated[bool, typer.Option(help="Print the summary alone.")] = False,
) -> None:
    """Run all trials on all cores."""
    todo = list(trials(folder.resolve(), starts, rotation_deg, translation_px, matcher, command_line))
    rows = []
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        for row in pool.map(run_trial, todo, chunksize=4):
            rows.append(row)
            if not quiet:
                print(json.dumps(row), flush=True)
    name = f"pose {folder.name} ±{rotation_deg:g}°/±{translation_px:g} px {matcher}"
    print(json.dumps(summary(name, rows), ensure_ascii=False))


if __name__ == "__main__":
    typer.run(main)
