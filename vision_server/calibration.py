"""A camera's focal lengths, middle and lens distortion, from images of a chessboard (OpenCV, Zhang 2000)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from bridge.errors import BadInput
from vision_server.channels.depth import Pixels, stretched

Grey = NDArray[np.uint8]
FEWEST_BOARDS = 5  # seven unknowns of the lens and six of each board; fewer leave them to chance
LENS = cv2.CALIB_FIX_K3  # k3 of a dozen boards is noise: it was drawn as 2.8 where it is 0
BOARD_DPI = 300.0
SQUARE_GREYS = (0, 255)


@dataclass(frozen=True)
class Calibration:
    """What the boards tell.

    Attributes
    ----------
    camera : of a ``[camera]`` table: width, height, fx, fy, cx, cy (px), distortion (k1, k2, p1, p2, 0).
    rms_px : RMS distance of the corners from where this camera puts them.
    focal_sd : standard deviation of the focal length, as a share of it.
    seen : names of the images in which the whole board was found.
    missed : those in which it was not.
    """

    camera: Mapping[str, Any]
    rms_px: float
    focal_sd: float
    seen: tuple[str, ...]
    missed: tuple[str, ...]


def calibrated(images: Mapping[str, Pixels], corners: tuple[int, int]) -> Calibration:
    """Calibrate from images (H, W) by name, of a board with so many inner corners (columns, rows).

    Raises
    ------
    BadInput
        Images of different sizes, fewer than FEWEST_BOARDS boards, or boards that tell nothing of the lens.
    """
    shapes = {image.shape for image in images.values()}
    if len(shapes) != 1:
        raise BadInput("The images are of different sizes.", "Give those of one camera, as it took them.")
    found = {name: _corners(image, corners) for name, image in images.items()}
    seen = {name: places for name, places in found.items() if places is not None}
    missed = tuple(name for name in found if name not in seen)
    if len(seen) < FEWEST_BOARDS:
        raise BadInput(
            f"The board of {corners[0]}x{corners[1]} inner corners was found in {len(seen)} of {len(found)} "
            f"images, and {FEWEST_BOARDS} are needed.",
            "Count the corners where four squares meet; show the whole board with its rim, sharp and flat.",
        )
    height, width = next(iter(shapes))
    grid = np.zeros((corners[0] * corners[1], 3), np.float32)
    grid[:, :2] = np.mgrid[: corners[0], : corners[1]].T.reshape(-1, 2)
    rms, matrix, distortion, _, _, deviations, _, _ = cv2.calibrateCameraExtended(
        [grid] * len(seen), list(seen.values()), (width, height), np.eye(3), np.zeros(5), flags=LENS
    )
    if not (np.isfinite(matrix).all() and np.isfinite(rms)) or matrix[0, 0] <= 0.0:
        raise BadInput("These boards tell nothing of the lens.", "Tilt the board differently in each image.")
    camera = {
        "width": width,
        "height": height,
        **{key: round(float(matrix[at]), 4) for key, at in _PLACES.items()},
        "distortion": [round(float(value), 6) for value in distortion.ravel()[:5]],
    }
    return Calibration(camera, float(rms), float(deviations[0, 0] / matrix[0, 0]), tuple(seen), missed)


_PLACES = {"fx": (0, 0), "fy": (1, 1), "cx": (0, 2), "cy": (1, 2)}


def _corners(image: Pixels, corners: tuple[int, int]) -> NDArray[np.float32] | None:
    """The board's inner corners (N, 1, 2), px, or None where the whole board is not seen."""
    flags = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_ACCURACY
    there, places = cv2.findChessboardCornersSB(stretched(image), corners, flags=flags)
    return np.asarray(places, np.float32) if there else None


def drawn_board(corners: tuple[int, int], square_mm: float) -> Grey:
    """A board to print at BOARD_DPI, uint8 (H, W), with a white rim of one square."""
    side = round(square_mm / 25.4 * BOARD_DPI)
    columns, rows = corners[0] + 1, corners[1] + 1
    dark = np.add.outer(np.arange(rows), np.arange(columns)) % 2 == 0
    squares: Sequence[int] = SQUARE_GREYS
    board = np.where(np.kron(dark, np.ones((side, side), bool)), squares[0], squares[1])
    return np.pad(board.astype(np.uint8), side, constant_values=squares[1])
