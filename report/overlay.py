"""A model's wireframe drawn over an image, so that its fit can be judged at a glance."""

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from bridge.errors import BadInput
from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from geometry.wireframe import Run, bounds_of, visible_runs
from numerics.arrays import Floats, Grey
from report.strokes import is_supported

Colour = tuple[int, int, int]

# Sizes and colours are chosen by hand; these two are Okabe and Ito's colour-blind-safe sky blue and orange,
# brightened for thin lines on dark images (BGR).
SUPPORTED: Colour = (255, 190, 70)
UNSUPPORTED: Colour = (30, 150, 255)
HALO: Colour = (20, 14, 10)
HALO_SHARE = 0.3
FRAME: Colour = (235, 235, 235)

DASH_PX, DASH_GAP_PX = 7.0, 4.0
WIDE_PX = 1300  # of a frame, for each pixel that its lines are wide
SMALL_TARGET = 0.35  # a target smaller than this share of the frame gets an inset
INSET_SHARE = 0.42  # of the frame; looks chosen by hand, like the colours above
INSET_PAD_PX = 8
SHIFT = 4  # sub-pixel bits of cv2's line drawing


def draw_overlay(
    image: Grey,
    model: Model,
    camera: Camera,
    pose: Pose | None,
    support: Mapping[int, float] | None = None,
    inset: bool = True,
) -> Grey:
    """Draw the visible lines of a model at a pose over an image.

    Parameters
    ----------
    image : (H, W) grey or (H, W, 3) BGR, uint8, of the camera's size.
    pose : camera_T_target; None leaves the image as it is.
    support : share (0 to 1) of each line that the images support, by line index. Lines below
        `SUPPORT_ENOUGH` or not named are drawn dashed and orange, the others blue; without it, all are blue.
    inset : adds an enlarged view of the target in a corner when it is small in the frame.

    Returns
    -------
    (H, W, 3) BGR, uint8; the given image is not changed.

    Raises
    ------
    BadInput : an image of another type or size than the camera's.
    GeometryError : a model or camera that cannot be used.
    """
    if pose is None:
        return _canvas(image, camera)
    return draw_runs(image, visible_runs(model, camera, pose), camera, support, inset)


def draw_runs(
    image: Grey,
    runs: Sequence[Run],
    camera: Camera,
    support: Mapping[int, float] | None = None,
    inset: bool = True,
) -> Grey:
    """The same, with what is seen of the model given as runs."""
    canvas = _canvas(image, camera)
    out = _drawn(canvas, runs, support)
    bounds = bounds_of(runs)
    if inset and bounds is not None and is_small(bounds, camera):
        _add_inset(out, canvas, runs, support, bounds)
    return out


def _canvas(image: Grey, camera: Camera) -> Grey:
    canvas = colour(image)
    if canvas.shape[:2] != (camera.height, camera.width):
        height, width = canvas.shape[:2]
        raise BadInput(f"image is {width}×{height}, its camera {camera.width}×{camera.height}")
    return canvas


def is_small(bounds: tuple[float, float, float, float], camera: Camera) -> bool:
    """Whether a target with these image bounds is small in the frame."""
    left, top, right, bottom = bounds
    return max((right - left) / camera.width, (bottom - top) / camera.height) < SMALL_TARGET


def colour(image: Grey) -> Grey:
    """A BGR copy (H, W, 3) of a uint8 image, grey (H, W) or BGR.

    Raises
    ------
    BadInput : another type or shape.
    """
    if image.dtype != np.uint8 or image.size == 0:
        raise BadInput(f"a picture needs uint8 pixels, got {image.dtype} of shape {image.shape}")
    if image.ndim == 2:
        return np.repeat(image[:, :, None], 3, axis=2)
    if image.ndim == 3 and image.shape[2] == 3:
        return image.copy()
    raise BadInput(f"a picture needs shape (H, W) or (H, W, 3), got {image.shape}")


def _drawn(canvas: Grey, runs: Sequence[Run], support: Mapping[int, float] | None) -> Grey:
    """Lines with a dark halo, wider in a large image."""
    wide = max(1, round(max(canvas.shape) / WIDE_PX))
    blue: list[NDArray[np.int32]] = []
    orange: list[NDArray[np.int32]] = []
    for run in runs:
        if is_supported(run.line, support):
            blue.append(_fixed(run.points))
        else:
            orange.extend(_fixed(dash) for dash in _dashes(run.points, wide))
    shade = canvas.copy()
    cv2.polylines(shade, blue + orange, False, HALO, 3 * wide, cv2.LINE_AA, SHIFT)
    out = np.asarray(cv2.addWeighted(shade, HALO_SHARE, canvas, 1 - HALO_SHARE, 0), dtype=np.uint8)
    cv2.polylines(out, orange, False, UNSUPPORTED, wide, cv2.LINE_AA, SHIFT)
    cv2.polylines(out, blue, False, SUPPORTED, wide, cv2.LINE_AA, SHIFT)
    return out


def _fixed(points: Floats) -> NDArray[np.int32]:
    return np.round(points * (1 << SHIFT)).astype(np.int32).reshape(-1, 1, 2)


def _dashes(points: Floats, wide: int) -> list[Floats]:
    """Cut a polyline into dashes, for lines so wide."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    out = []
    for start in np.arange(0.0, along[-1], wide * (DASH_PX + DASH_GAP_PX)):
        stop = min(start + wide * DASH_PX, along[-1])
        at = np.array([start, *along[(along > start) & (along < stop)], stop])
        out.append(np.column_stack([np.interp(at, along, points[:, k]) for k in range(2)]))
    return out


def _add_inset(
    out: Grey,
    canvas: Grey,
    runs: Sequence[Run],
    support: Mapping[int, float] | None,
    bounds: tuple[float, float, float, float],
) -> None:
    """Paste an enlarged view of the target into the corner that is farthest from it."""
    height, width = canvas.shape[:2]
    left, top, right, bottom = bounds
    margin = 0.15 * max(right - left, bottom - top) + 4
    x0, y0 = max(0, int(left - margin)), max(0, int(top - margin))
    x1, y1 = min(width, int(right + margin) + 1), min(height, int(bottom + margin) + 1)
    factor = INSET_SHARE * min(width / (x1 - x0), height / (y1 - y0))
    if factor <= 1.2:
        return
    columns, rows = round((x1 - x0) * factor), round((y1 - y0) * factor)
    target = canvas[y0:y1, x0:x1]
    view = np.asarray(cv2.resize(target, (columns, rows), interpolation=cv2.INTER_CUBIC), dtype=np.uint8)
    stretch = np.array([columns / (x1 - x0), rows / (y1 - y0)])
    moved = [Run(run.line, (run.points - [x0, y0] + 0.5) * stretch - 0.5) for run in runs]
    view = _drawn(view, moved, support)
    at_right = (left + right) / 2 < width / 2
    at_bottom = (top + bottom) / 2 < height / 2
    column = width - columns - INSET_PAD_PX if at_right else INSET_PAD_PX
    row = height - rows - INSET_PAD_PX if at_bottom else INSET_PAD_PX
    cv2.rectangle(out, (x0, y0), (x1 - 1, y1 - 1), FRAME, 1, cv2.LINE_AA)
    out[row : row + rows, column : column + columns] = view
    cv2.rectangle(out, (column, row), (column + columns - 1, row + rows - 1), FRAME, 1)
