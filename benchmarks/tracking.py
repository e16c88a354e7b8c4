"""Tracking on simulated films: motion, an arm, lights that switch, a target that leaves and comes back.

    .venv/bin/python -m benchmarks.tracking [--films 4] [--frames 120] [--kind NAME ...] [--first 0]
    .venv/bin/python -m benchmarks.tracking --recorded FOLDER [--visp PREFIX]

With ``--first-sight`` no pose is given for the first frame, which counts then, too; with ``--recorded`` each
frame of the folder is the first of three. With ``--visp``, as of `benchmarks.planar_track`, ViSP's trackers
follow it, too.

Targets of the project and parts drawn at random, before clutter, at 640x480; each film moves by up to 20 px
and 3 degrees a frame. One JSON object for each kind of film: shares of frames that are sure, sure and wrong
(1 degree, 1 % of the range), unsure and right, and lost; frames until a loss is said and until the target is
found again; how many poses are within the 99 % bound of their covariance; processor time of sure frames.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from benchmarks.films import CAMERA, KINDS, Shown, film
from benchmarks.pose_accuracy import true_poses
from benchmarks.visp_tracker import KINDS as VISP
from benchmarks.visp_tracker import Step, visp
from experiments.kinds.estimate import normalised_error_squared
from geometry.model import Model, load_model
from geometry.pose import Pose
from geometry.symmetries import symmetry_of
from numerics.arrays import Floats
from vision_server.channels.image_files import read_grey
from vision_server.channels.tone import file_tone
from vision_server.matching.match import Anywhere
from vision_server.serve.inputs import read_camera
from vision_server.tracking.motion import Motion, about
from vision_server.tracking.tracked import Tracked
from vision_server.tracking.tracker import Tracker

WRONG = (1.0, 0.01)  # degrees, share of the range
LOOSE = (3.0, 0.02)
FAR = (15.0, 0.1)  # beyond, it is not an error of measurement
BOUND_99 = 16.81  # of a squared error of six dimensions in units of its covariance
GONE, BACK = 0.05, 0.95  # share of the target in the frame and not behind the arm


def followed(model: Model, frames: Iterator[Shown], first_sight: bool = False) -> list[tuple[Shown, Tracked]]:
    """A tracker on a film, from the true first pose, or at ``first_sight`` from none."""
    rows: list[tuple[Shown, Tracked]] = []
    tracker: Tracker | None = None
    for shown in frames:
        if tracker is None:
            tracker = Tracker(model, CAMERA, Anywhere() if first_sight else shown.pose)
        rows.append((shown, tracker.step(shown.pixels, shown.time_s)))
    return rows


def truth(shown: Shown, told: Pose) -> Pose:
    """The true pose, or the nearest one in which the target's wireframe is just the same."""
    poses = (shown.pose, *(shown.pose.compose(turn) for turn in shown.turns))
    return min(poses, key=lambda pose: told.error_to(pose).rotation_deg)


def is_right(shown: Shown, told: Tracked, limits: tuple[float, float] = WRONG) -> bool:
    """Within the limits of the truth."""
    return told.pose is not None and told.pose.error_to(truth(shown, told.pose)).within(*limits)


def losses(film: list[tuple[Shown, Tracked]]) -> tuple[list[int], list[int]]:
    """Frames from when the target was gone until that is said, and from when it is back until it is found."""
    said: list[int] = []
    found: list[int] = []
    gone = back = told_lost = None
    for k, (shown, told) in enumerate(film):
        if shown.visible < GONE:
            gone, back = k if gone is None else gone, None
            if told.state != "sure" and told_lost is None:
                told_lost = k
                said.append(k - gone)
        elif gone is not None and shown.visible > BACK:
            back = k if back is None else back
            if told.state == "sure" and is_right(shown, told):
                found.append(k - back)
                gone = back = told_lost = None
    return said, found


def filtered(films: list[list[tuple[Shown, Tracked]]], middles: list[Floats]) -> dict[str, object]:
    """The motion filter on sure frames in a row: squared innovations (NIS), and its squared errors (NEES)."""
    innovations, errors = [], []
    for one, middle in zip(films, middles, strict=True):
        motion, last = None, 0.0
        for shown, told in one:
            if told.state != "sure" or told.pose is None or told.covariance is None:
                motion = None
            elif motion is None:
                motion = Motion.at_rest(told.pose, told.covariance, middle)
            else:
                motion = motion.after(shown.time_s - last)
                innovation = motion.innovation(told.pose, told.covariance, middle)
                innovations.append(innovation.squared)
                motion = motion.corrected(innovation)
                pose = motion.pose(middle)
                covariance = about(-motion.centre, motion.covariance[:6, :6])
                errors.append(normalised_error_squared(pose, covariance, truth(shown, pose)))
            last = shown.time_s
    found: dict[str, object] = {}
    for name, squares in (("nis", innovations), ("nees", errors)):
        if squares:
            within = float(np.mean(np.array(squares) <= BOUND_99))
            found[f"filter_{name}_mean_99"] = [round(float(np.mean(squares)), 2), round(within, 3)]
    return found


def summary(kind: str, films: list[list[tuple[Shown, Tracked]]], given: int = 1) -> dict[str, object]:
    """What is printed of a kind of film, of which the poses of the first frames are ``given``."""
    rows = [row for one in films for row in one[given:]]
    sure = [row for row in rows if row[1].state == "sure"]
    squares = [
        normalised_error_squared(t.pose, t.covariance, truth(s, t.pose))
        for s, t in sure
        if t.pose is not None and s.visible >= GONE and is_right(s, t, FAR)
    ]
    errors = [t.pose.error_to(truth(s, t.pose)).rotation_deg for s, t in sure if t.pose is not None]
    seen = [row for row in rows if row[0].visible >= GONE]
    times = [told.seconds for _, told in sure]
    return {
        "name": f"tracking {kind}", "value": len(sure) / len(rows), "unit": "share sure", "frames": len(rows),
        "sure_and_wrong": sum(s.visible < GONE or not is_right(s, t) for s, t in sure),
        "sure_and_off": sum(s.visible < GONE or not is_right(s, t, LOOSE) for s, t in sure),
        "right_where_seen": sum(is_right(*row) for row in seen) / len(seen) if seen else None,
        "lost": sum(told.state == "lost" for _, told in rows) / len(rows),
        "within_99": float(np.mean(np.array(squares) <= BOUND_99)) if squares else None,
        "squared_error_median": float(np.median(squares)) if squares else None,
        "squared_error_mean": float(np.mean(squares)) if squares else None,
        "degrees_median_99": np.percentile(errors, [50, 99]).round(3).tolist() if errors else None,
        "not_sure_after": [k for one in films for k in losses(one)[0]],
        "found_after": [k for one in films for k in losses(one)[1]],
        "ms_sure_median": 1e3 * float(np.median(times)) if times else None,
    }  # fmt: skip


def recorded(folder: Path, first_sight: bool = False) -> dict[str, object]:
    """A tracker on the images of a folder as `benchmarks.pose_accuracy` reads it, from the first pose.

    At ``first_sight`` one on each frame and the two after it, from none; which of the turns that the model
    does not tell is found then does not matter.
    """
    frames = sorted(true_poses(folder).items())
    camera, table = read_camera(folder / "camera.toml")
    (gamma,), tone_sd_px = file_tone([frames[0][0]], table.get("gamma"))
    model = load_model(next(folder.glob("*.cao")))
    runs = [frames[k : k + 3] for k in range(len(frames))] if first_sight else [frames]
    turns = symmetry_of(model).turns if first_sight else (Pose(np.zeros(3), np.zeros(3)),)
    told, true = [], []
    for run in runs:
        tracker = Tracker(model, camera, Anywhere() if first_sight else run[0][1][0], gamma, tone_sd_px)
        for image, poses in run:
            told.append(tracker.step(read_grey(image)))
            true.append([one.compose(turn) for one in poses for turn in turns])
    return compared(f"tracking {folder.name}", told, true)


def recorded_by_visp(folder: Path, prefix: Path) -> Iterator[dict[str, object]]:
    """ViSP's trackers on the same, by the settings of its file visp.xml."""
    frames = sorted(true_poses(folder).items())
    images, true = [image for image, _ in frames], [list(poses) for _, poses in frames]
    for one in VISP:
        told = visp(images, folder, next(folder.glob("*.cao")), true[0][0], prefix, one)
        yield compared(f"visp {one} {folder.name}", told, true)


def compared(name: str, told: Sequence[Tracked | Step], true: Sequence[list[Pose]]) -> dict[str, object]:
    """What is told of frames beside their true poses, of each the nearest."""
    errors = []
    for one, poses in zip(told, true, strict=True):
        if one.pose is not None:
            near = [error for error in map(one.pose.error_to, poses) if error.rotation_deg < LOOSE[0]]
            errors.append(min(near or map(one.pose.error_to, poses), key=lambda error: error.translation_m))
    return {
        "name": name, "value": sum(e.within(*LOOSE) for e in errors) / len(told),
        "unit": "share within 3 degrees and 2 %", "frames": len(told),
        "within_1": sum(e.within(*WRONG) for e in errors) / len(told),
        **{state: sum(one.state == state for one in told) for state in ("sure", "unsure", "lost")},
        "mm_median": 1e3 * float(np.median([e.translation_m for e in errors])),
        "deg_median": float(np.median([e.rotation_deg for e in errors])),
        "ms_sure_median": 1e3 * float(np.median([one.seconds for one in told if one.state == "sure"])),
    }  # fmt: skip


def main(
    films: int = 4,
    frames: int = 120,
    first: int = 0,
    folder: Annotated[Path | None, typer.Option("--recorded", help="Images with poses instead.")] = None,
    kind: Annotated[list[str] | None, typer.Option(help=f"Of {', '.join(KINDS)}.")] = None,
    first_sight: Annotated[bool, typer.Option("--first-sight", help="No first pose is given.")] = False,
    prefix: Annotated[Path | None, typer.Option("--visp", help="Where ViSP is: beside its trackers.")] = None,
) -> None:
    """One line a kind of film, or one of a folder."""
    if folder is not None:
        print(json.dumps(recorded(folder.resolve(), first_sight)), flush=True)
        for theirs in [] if prefix is None else recorded_by_visp(folder.resolve(), prefix):
            print(json.dumps(theirs), flush=True)
        return
    for one in kind or KINDS:
        made = [film(number, one, frames) for number in range(first, first + films)]
        rows = [followed(model, shown, first_sight) for model, shown in made]
        middles = [model.middle for model, _ in made]
        told = summary(one, rows, given=int(not first_sight))
        print(json.dumps(told | filtered(rows, middles)), flush=True)


if __name__ == "__main__":
    typer.run(main)
