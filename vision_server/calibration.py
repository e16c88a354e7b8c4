"""A camera's focal lengths, middle and lens distortion, from images of a chessboard (OpenCV, Zhang 2000)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import cv2
import numpy as np

from bridge.errors import BadInput
from numerics.arrays import Field, Floats, Grey
from vision_server.channels.depth import Pixels, stretched

Corners = Field
FEWEST_BOARDS = 5  # seven unknowns of the lens and six of each board; fewer leave them to chance
LENS = cv2.CALIB_FIX_K3  # k3 of a dozen boards is noise: it was drawn as 2.8 where it is 0
FISHEYE = cv2.CALIB_RECOMPUTE_EXTRINSIC | cv2.CALIB_FIX_SKEW | cv2.CALIB_USE_INTRINSIC_GUESS
FISHEYE_RMS = 0.9  # of a pinhole's, under which the lens is taken for a fisheye; chosen by hand
ENDS = cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS
FISHEYE_ENDS, CORNER_ENDS = (ENDS, 100, 1e-9), (ENDS, 40, 1e-3)
SEARCHED_PX = 1600  # of a longer image's side: 12 of 12 megapixels take 10 s of processor time, not 86
REACH, LEAST_REACH_PX = 0.25, 3  # of the least distance of two corners: how far around one is looked at
BOARD_DPI = 300.0
SQUARE_GREYS = (0, 255)


@dataclass(frozen=True)
class Calibration:
    """What the boards tell.

    Attributes
    ----------
    camera : of a ``[camera]`` table: width, height, fx, fy, cx, cy (px), distortion (k1, k2, p1, p2, 0), or
        (k1, k2, k3, k4) and ``lens`` of a fisheye.
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
    found = {name: board_corners(image, corners) for name, image in images.items()}
    seen = {name: places for name, places in found.items() if places is not None}
    missed = tuple(name for name in found if name not in seen)
    if len(seen) < FEWEST_BOARDS:
        raise BadInput(
            f"The board of {corners[0]}x{corners[1]} inner corners was found in {len(seen)} of {len(found)} "
            f"images, and {FEWEST_BOARDS} are needed.",
            "Count the corners where four squares meet; show the whole board with its rim, sharp and flat.",
        )
    height, width = next(iter(shapes))
    grid = np.zeros((corners[0] * corners[1], 3))
    grid[:, :2] = np.mgrid[: corners[0], : corners[1]].T.reshape(-1, 2)
    places = [seen[name] for name in seen]
    fits = [_pinhole(grid, places, (width, height))]
    fits += _fisheye(grid, places, (width, height), fits[0].matrix)
    best = fits[-1] if fits[-1].rms_px < FISHEYE_RMS * fits[0].rms_px else fits[0]
    if not (np.isfinite(best.matrix).all() and np.isfinite(best.rms_px)) or best.matrix[0, 0] <= 0.0:
        raise BadInput("These boards tell nothing of the lens.", "Tilt the board differently in each image.")
    camera = {
        "width": width,
        "height": height,
        **{key: round(float(best.matrix[at]), 4) for key, at in _PLACES.items()},
        "distortion": [round(float(value), 6) for value in best.distortion],
    }
    if best.lens != "pinhole":
        camera["lens"] = best.lens
    return Calibration(camera, best.rms_px, best.focal_sd, tuple(seen), missed)


_PLACES = {"fx": (0, 0), "fy": (1, 1), "cx": (0, 2), "cy": (1, 2)}


class _Fit(NamedTuple):
    """A lens that puts the corners where they were seen; ``focal_sd`` is a share of the focal length."""

    lens: str
    rms_px: float
    matrix: Floats
    distortion: Floats
    focal_sd: float


def _fit(lens: str, rms: float, matrix: Any, distortion: Any, focal_sd: float) -> _Fit:
    return _Fit(
        lens, float(rms), np.asarray(matrix, np.float64), np.asarray(distortion, np.float64), focal_sd
    )


def _pinhole(grid: Floats, places: Sequence[Corners], size: tuple[int, int]) -> _Fit:
    """Brown-Conrady distortion without k3, of corners (N, 1, 2) of each board."""
    boards = [np.asarray(grid, np.float32)] * len(places)
    rms, matrix, distortion, _, _, deviations, _, _ = cv2.calibrateCameraExtended(
        boards, list(places), size, np.eye(3), np.zeros(5), flags=LENS
    )
    focal_sd = float(deviations[0, 0] / matrix[0, 0])
    return _fit("pinhole", rms, matrix, distortion.ravel()[:5], focal_sd)


def _fisheye(grid: Floats, places: Sequence[Corners], size: tuple[int, int], start: Floats) -> list[_Fit]:
    """The equidistant lens (Kannala and Brandt 2006), none where OpenCV finds none."""
    boards = [grid.reshape(1, -1, 3)] * len(places)
    seen = [np.asarray(one, np.float64).reshape(1, -1, 2) for one in places]
    try:
        rms, matrix, distortion, turns, shifts = cv2.fisheye.calibrate(
            boards, seen, size, start.copy(), np.zeros((4, 1)), flags=FISHEYE, criteria=FISHEYE_ENDS
        )
    except cv2.error:
        return []
    information = np.zeros((8, 8))  # of focal lengths, middle and distortion, each board's pose left free
    for board, turn, shift in zip(boards, turns, shifts, strict=True):
        _, rows = cv2.fisheye.projectPoints(board, turn, shift, matrix, distortion)
        lens, pose = rows[:, :8], rows[:, 8:14]
        information += lens.T @ (lens - pose @ np.linalg.lstsq(pose, lens, rcond=None)[0])
    variance = 0.5 * rms**2 * np.linalg.pinv(information)[0, 0]  # rms: of both coordinates of a corner
    return [_fit("fisheye", rms, matrix, distortion.ravel(), float(np.sqrt(variance) / matrix[0, 0]))]


def board_corners(image: Pixels, corners: tuple[int, int]) -> Corners | None:
    """The board's inner corners (N, 1, 2), px, or None where the whole board is not seen.

    A large image is looked at in fewer pixels. Corners are then placed in all of them, where the gradients
    around each meet (Foerstner and Guelch 1987): they are 0.02 px off so, and 0.07 as they are found; the
    focal length by 9 to 15 drawn boards is 0.05 % off (RMS), and would be 0.26 %.
    """
    whole = stretched(image)
    finer = max(1.0, max(whole.shape) / SEARCHED_PX)
    small = cv2.resize(whole, None, fx=1.0 / finer, fy=1.0 / finer, interpolation=cv2.INTER_AREA)
    flags = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_ACCURACY
    there, found = cv2.findChessboardCornersSB(small if finer > 1.0 else whole, corners, flags=flags)
    if not there:
        return None
    places = np.asarray((found + 0.5) * finer - 0.5, np.float32)
    beside = np.diff(places.reshape(corners[1], corners[0], 2), axis=1)
    reach = max(LEAST_REACH_PX, int(REACH * np.linalg.norm(beside, axis=2).min()))
    placed = cv2.cornerSubPix(whole, places, (reach, reach), (-1, -1), CORNER_ENDS)
    return np.asarray(placed, np.float32).reshape(-1, 1, 2)


def drawn_board(corners: tuple[int, int], square_mm: float) -> Grey:
    """A board to print at BOARD_DPI, uint8 (H, W), with a white rim of one square."""
    side = round(square_mm / 25.4 * BOARD_DPI)
    columns, rows = corners[0] + 1, corners[1] + 1
    dark = np.add.outer(np.arange(rows), np.arange(columns)) % 2 == 0
    squares: Sequence[int] = SQUARE_GREYS
    board = np.where(np.kron(dark, np.ones((side, side), bool)), squares[0], squares[1])
    return np.pad(board.astype(np.uint8), side, constant_values=squares[1])
