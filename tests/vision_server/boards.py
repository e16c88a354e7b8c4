"""Images of a chessboard as a camera with lens distortion takes them."""

from pathlib import Path

import cv2
import numpy as np

from geometry.camera import Camera
from geometry.pose import Pose
from geometry.rotation import matrix_of
from numerics.arrays import Floats, Grey

FINER = 3  # samples across a pixel
RIM = 1.5  # of paper around the squares, in squares


def board_pose(rng: np.random.Generator, corners: tuple[int, int], nearer: float = 1.0) -> Pose:
    """The board tilted by 20 to 45 degrees, filling most of a frame of focal length 1.2 ``nearer`` widths."""
    turn, tilt = rng.uniform(-np.pi, np.pi), np.radians(rng.uniform(20.0, 45.0))
    lean = matrix_of(np.array([np.cos(turn), np.sin(turn), 0.0]) * tilt)
    rotation = lean @ matrix_of(np.array([0.0, 0.0, rng.uniform(-0.3, 0.3)]))
    middle = np.array([corners[0] - 1, corners[1] - 1, 0.0]) / 2.0
    ahead = np.array([*rng.uniform(-1.0, 1.0, 2), nearer * rng.uniform(2.0, 2.6) * corners[0]])
    return Pose.from_matrix(rotation, ahead - rotation @ middle)


def rays_of(camera: Camera) -> Floats:
    """Directions (3, N) of the samples of a frame, row by row, single precision.

    Where the lens puts a pixel is asked for each, and one around them: between two it bends by less than a
    hundredth of a pixel, and to ask for each sample takes longer than all that is done with the answers.
    """
    row, column = np.mgrid[-1 : camera.height + 1, -1 : camera.width + 1]
    pixels = np.column_stack([column.ravel(), row.ravel()]).astype(np.float64)
    ideal = camera.undistort_points(pixels).reshape(*row.shape, 2)
    samples = _samples(_samples(ideal).transpose(1, 0, 2)).transpose(1, 0, 2)
    x, y = ((samples.reshape(-1, 2) - [camera.cx, camera.cy]) / [camera.fx, camera.fy]).T
    return np.stack([x, y, np.ones_like(x)]).astype(np.float32)


def _samples(values: Floats) -> Floats:
    """Values (FINER (N - 2), ...) at the samples of pixels, of (N, ...) at middles and beyond both ends."""
    before, here, after = values[:-2], values[1:-1], values[2:]
    shares = (np.arange(FINER) + 0.5) / FINER - 0.5
    finer = [here + share * (after - here if share > 0.0 else here - before) for share in shares]
    return np.stack(finer, axis=1).reshape(-1, *values.shape[1:])


def photographed(
    camera: Camera,
    rays: Floats,
    pose: Pose,
    corners: tuple[int, int],
    rng: np.random.Generator,
) -> Grey:
    """The board, of squares of one unit, at a pose, before grey; noise of one grey value."""
    onto_board = np.linalg.inv(np.column_stack([pose.matrix[:, :2], pose.translation]))
    x, y, far = onto_board.astype(rays.dtype) @ rays
    x, y = x / far, y / far
    inside = (x > -1) & (x < corners[0]) & (y > -1) & (y < corners[1])
    paper = (x > -1 - RIM) & (x < corners[0] + RIM) & (y > -1 - RIM) & (y < corners[1] + RIM)
    dark = (np.floor(x) + np.floor(y)) % 2 == 0
    grey = np.where(inside, np.where(dark, 25.0, 210.0), np.where(paper, 210.0, 70.0))
    fine = grey.reshape(camera.height, FINER, camera.width, FINER)
    seen = fine.mean(axis=(1, 3)) + rng.normal(0.0, 1.0, fine.shape[::2])
    return np.asarray(np.clip(np.round(seen), 0, 255), np.uint8)


def write_boards(
    folder: Path, camera: Camera, corners: tuple[int, int], count: int, nearer: float = 1.0
) -> list[Path]:
    """Photographs ``board01.png`` and so on."""
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    rays = rays_of(camera)
    for number in range(1, count + 1):
        rng = np.random.default_rng(number)
        files.append(folder / f"board{number:02d}.png")
        cv2.imwrite(
            str(files[-1]), photographed(camera, rays, board_pose(rng, corners, nearer), corners, rng)
        )
    return files
