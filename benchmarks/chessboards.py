"""Poses of a printed chessboard in photographs, against those that its corners tell.

    .venv/bin/python -m benchmarks.chessboards FOLDER [--starts 3] [--tolerance 0.0004] [--whole]

FOLDER holds left*.jpg and right*.jpg of OpenCV's samples (Debian's package opencv-doc, examples/data): a
board that a hand holds in a room, of 9 x 6 inner corners, taken by two cameras. Each camera is calibrated
from its photographs. The pose of a board is that of its inner corners (OpenCV); our own is of the edges of
its black squares, from disturbed starts. Squares at the rim are cut, as RIM has it; with --whole the model
does not know that. One JSON object an estimate, then one of them all: *normalised* is the squared error in
units of the stated covariance, and with that of the corners' pose added to it.
"""

from __future__ import annotations

import json
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from itertools import chain, product
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import cv2
import numpy as np
import typer

from experiments.kinds.estimate import normalised_error_squared
from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import RIGHT, SEARCH_ROTATION_DEG, SEARCH_TRANSLATION_PX, Pose, disturbed
from geometry.surface import Surface
from numerics.arrays import Floats
from vision_server.calibration import board_corners, calibrated
from vision_server.channels.image_files import read_grey
from vision_server.channels.tone import file_tone
from vision_server.image_set import ImageSet
from vision_server.pipeline import SURE_SCORE, PipelineSettings, estimate_pose
from vision_server.pose.steps import step_jacobian
from vision_server.serve.inputs import untold_tolerance_m
from vision_server.trust.judgement import stated

CORNERS = (9, 6)
SQUARE_M = 0.025  # nobody tells the true size: errors in degrees and per cent of the range do not ask for it
# What there is of the squares at the rim, in squares: at the first and last column and row. Measured in these
# photographs, where their dark ends, to 0.02.
RIM = ((0.53, 0.48), (0.96, 0.94))
WHOLE = ((1.0, 1.0), (1.0, 1.0))
HALF_TURN = Pose(np.array([0.0, 0.0, np.pi]), np.zeros(3))  # corners may be told from either end of the board


def board(rim: tuple[tuple[float, float], tuple[float, float]]) -> Model:
    """The black squares, metres, about the middle of the inner corners; one is at the first of these."""
    (left, right), (top, bottom) = rim
    columns, rows = CORNERS
    x = np.array([-left, *range(columns), columns - 1 + right]) - (columns - 1) / 2
    y = np.array([-top, *range(rows), rows - 1 + bottom]) - (rows - 1) / 2
    black = [(i, j) for i, j in product(range(columns + 1), range(rows + 1)) if (i + j) % 2 == 0]
    corners = [(x[i + di], y[j + dj], 0.0) for i, j in black for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1))]
    faces = list(np.arange(len(corners)).reshape(-1, 4))
    groups, drawn = np.full(len(faces), -1), np.empty((0, 2), np.int64)
    surface = Surface(SQUARE_M * np.array(corners), faces, groups, drawn, 1.0, 1.0)
    return Model.of_surface("board", surface)


def grid() -> Floats:
    """The inner corners (N, 3), metres, about their middle, in OpenCV's order."""
    columns, rows = CORNERS
    places = np.mgrid[:columns, :rows].T.reshape(-1, 2) - np.array([columns - 1, rows - 1]) / 2
    return np.column_stack([SQUARE_M * places, np.zeros(len(places))])


def of_corners(camera: Camera, seen: Floats) -> tuple[Pose, Floats]:
    """Pose of a board whose inner corners (N, 2) were seen; its covariance (6, 6) by what they are off."""
    points, lens = grid(), camera.intrinsics
    rays = (camera.undistort_points(seen) - lens[2:]) / lens[:2]
    _, turn, shift = cv2.solvePnP(points, rays, np.eye(3), None)
    pose = Pose(np.asarray(turn, np.float64).ravel(), np.asarray(shift, np.float64).ravel())
    there = pose.apply(points)
    off = camera.project(there) - seen
    rows = np.concatenate(
        [step_jacobian(camera, there, np.tile(axis, (len(there), 1)), np.zeros(3)) for axis in np.eye(2)]
    )
    variance = float((off**2).sum() / (off.size - 6))
    return pose, np.asarray(variance * np.linalg.inv(rows.T @ rows))


def begins_black(image: Any, camera: Camera, pose: Pose) -> bool:
    """Whether the square at the first inner corners is darker than the next one."""
    middles = grid()[[0, 1]] + SQUARE_M * np.array([0.5, 0.5, 0.0])
    (x, y), (next_x, next_y) = np.rint(camera.project(pose.apply(middles))).astype(int)
    return bool(image[y, x] < image[next_y, next_x])


class Photograph(NamedTuple):
    """One image of the board.

    Attributes
    ----------
    true : the pose by its corners; ``spread`` (6, 6) is the covariance of that.
    """

    name: str
    images: ImageSet
    camera: Camera
    true: Pose
    spread: Floats
    tone_sd_px: float


def photograph(file: Path, camera: Camera) -> Photograph | None:
    """An image file, None where the corners are not seen."""
    image = read_grey(file)
    corners = board_corners(image, CORNERS)
    if corners is None:
        return None
    true, spread = of_corners(camera, corners.reshape(-1, 2).astype(np.float64))
    if not begins_black(image, camera, true):
        true = true.compose(HALF_TURN)
    (exponent,), tone_sd_px = file_tone([file], None)
    images = ImageSet(camera.width, camera.height)
    images.add("i1", image, 1.0, exponent)
    return Photograph(file.name, images, camera, true, spread, tone_sd_px)


def rows_of(shot: Photograph, model: Model, starts: int, tolerance: float | None) -> list[dict[str, Any]]:
    """What came of one photograph from so many starts."""
    rows = []
    for number in range(starts):
        rng = np.random.default_rng([number, sum(map(ord, shot.name))])
        start = disturbed(shot.true, rng, SEARCH_ROTATION_DEG, SEARCH_TRANSLATION_PX, shot.camera.fx)
        settings = PipelineSettings(
            seed=number,
            tone_sd_px=shot.tone_sd_px,
            tolerance_m=(tolerance or 0.0) * model.diameter,
            untold_tolerance_m=untold_tolerance_m(tolerance, model),
        )
        found = estimate_pose(shot.images, ["i1"], model, shot.camera, start, settings)
        row = {"image": shot.name, "start": number, "score": found.score, "right": False}
        rows.append(row | {"seconds": sum(found.seconds.values())})
        if found.pose is None:
            continue
        off, covariance = found.pose.error_to(shot.true), stated(found).covariance
        assert covariance is not None
        rows[-1] |= {
            "right": off.within(*RIGHT),
            "degrees": off.rotation_deg,
            "share_of_range": off.translation_fraction_of_range,
            "normalised": normalised_error_squared(found.pose, covariance, shot.true),
            "normalised_by_both": normalised_error_squared(found.pose, covariance + shot.spread, shot.true),
        }
    return rows


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Counts, and medians, 90 % and means of the right ones."""
    right = [row for row in rows if row["right"]]
    sure = [row["right"] for row in rows if row["score"] >= SURE_SCORE]
    told: dict[str, Any] = {
        "estimates": len(rows), "right": len(right), "right_and_trusted": sum(sure),
        "wrong_and_trusted": len(sure) - sum(sure),
    }  # fmt: skip
    for key in ("degrees", "share_of_range"):
        told[key] = np.percentile([row[key] for row in right], (50, 90)).round(6).tolist() if right else None
    for key in ("normalised", "normalised_by_both"):
        told[key] = round(float(np.mean([row[key] for row in right])), 2) if right else None
    return told


def main(
    folder: Path,
    starts: Annotated[int, typer.Option(min=1)] = 3,
    tolerance: Annotated[
        float | None, typer.Option(min=0.0, max=0.05, help="Share of the board's size; else it is not told.")
    ] = None,
    whole: Annotated[bool, typer.Option(help="The model does not know that the rim is cut.")] = False,
) -> None:
    """Estimate all poses of both cameras, on all cores."""
    model, shots = board(WHOLE if whole else RIM), []
    for name in ("left", "right"):
        files = sorted(folder.glob(f"{name}[0-9][0-9].jpg"))
        if not files:
            raise typer.BadParameter(f"{folder} has no {name}01.jpg and so on")
        camera = Camera.from_dict(calibrated({file.name: read_grey(file) for file in files}, CORNERS).camera)
        shots += [shot for shot in (photograph(file, camera) for file in files) if shot is not None]
    rows = []
    with ProcessPoolExecutor() as pool:
        look = partial(rows_of, model=model, starts=starts, tolerance=tolerance)
        for row in chain.from_iterable(pool.map(look, shots)):
            rows.append(row)
            print(json.dumps(row), flush=True)
    print(json.dumps(summary(rows)))


if __name__ == "__main__":
    typer.run(main)
