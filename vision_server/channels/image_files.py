"""Image files as grey arrays (H, W), of their own depth: 8 or 16 bits, or floats."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from bridge.errors import BadInput
from numerics.arrays import Grey
from vision_server.channels.colours import BANDS, ONE
from vision_server.channels.depth import Pixels, Raw

MOST_PIXELS = 150_000_000  # more than any camera's sensor has: 2.5 GB for its channel
PLAIN = Raw()  # of any depth, without a mosaic
PNG_HEAD_BYTES = 24  # signature, length and type of the first chunk, width, height
MORE_IN_COLOUR = 2.0  # times the mean gradient of the grey: a band has edges that the grey lacks; by hand


@dataclass(frozen=True, eq=False)
class Picture:
    """One image of a set.

    Attributes
    ----------
    pixels
        Grey, (H, W), see `depth`.
    file, number
        It is of, and which of the files that is.
    band
        Of the file's colours; empty: their grey.
    """

    pixels: Pixels
    file: Path
    number: int
    band: str

    def __str__(self) -> str:
        """What it is called in messages."""
        return f"{self.file} ({self.band})" if self.band else str(self.file)


def read_pixels(path: Path, colour: str = "grey") -> NDArray[Any]:
    """The file's pixels, (H, W): uint8, uint16 or float32 0..1; upright, as its EXIF says.

    Parameters
    ----------
    colour
        One of `ONE`: what is taken of a colour image, its luma by BT.601 or a band.

    Raises
    ------
    BadInput
        The file is missing, unreadable or no 8-bit, 16-bit or float32 image.
    """
    return one_band(_decoded(path), colour)


def one_band(pixels: NDArray[Any], colour: str) -> NDArray[Any]:
    """What is taken of pixels, (H, W) or blue, green and red (H, W, 3), see `read_pixels`: (H, W)."""
    if pixels.ndim == 3:
        if colour == "grey":
            pixels = cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY)  # BT.601
        else:
            pixels = pixels[..., BANDS.index(colour)]
    return np.ascontiguousarray(pixels, dtype=pixels.dtype.type)


def shows_more_in_colour(path: Path) -> bool:
    """Whether a band of a colour image has far more edges than its grey: where colours are equally bright."""
    pixels = _decoded(path)
    if pixels.ndim != 3:
        return False
    grey, *bands = (_mean_gradient(one_band(pixels, name)) for name in ONE)
    return max(bands) > MORE_IN_COLOUR * grey


def _mean_gradient(pixels: NDArray[Any]) -> float:
    """Mean length of the gradient, of pixels smoothed as much as noise asks for."""
    smooth = cv2.GaussianBlur(pixels.astype(np.float32), (0, 0), 2.0)
    return float(np.hypot(cv2.Sobel(smooth, -1, 1, 0), cv2.Sobel(smooth, -1, 0, 1)).mean())


def _decoded(path: Path) -> NDArray[Any]:
    """Pixels of a file, (H, W), or blue, green and red, (H, W, 3); raises as `read_pixels`."""
    try:
        content = np.frombuffer(path.read_bytes(), np.uint8)
    except OSError as error:
        reason = error.strerror or str(error)
        raise BadInput(f"Cannot read image {path}: {reason}.", "Check the path.") from error
    _check_size(path, content)
    # what it tells of, a broken file, is said here
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        pixels = cv2.imdecode(content, cv2.IMREAD_ANYDEPTH | cv2.IMREAD_ANYCOLOR) if content.size else None
    except cv2.error as error:  # of a size that OpenCV itself refuses
        raise BadInput(
            f"{path} is not an image that can be read: {error.err}.", "Give a smaller one."
        ) from error
    if pixels is None:
        raise BadInput(f"{path} is not an image that can be read.", "Give a PNG, JPEG, TIFF or PGM file.")
    if pixels.dtype not in (np.uint8, np.uint16, np.float32):
        raise BadInput(f"{path} holds {pixels.dtype} pixels.", "Give an 8-bit, 16-bit or float32 image.")
    if pixels.dtype == np.float32 and not (pixels.min() >= 0.0 and pixels.max() <= 1.0):
        raise BadInput(f"{path} holds float32 pixels that are not 0 to 1.", "Divide them by the clip level.")
    return np.asarray(pixels)


def _check_size(path: Path, content: Grey) -> None:
    """Look at the size that a PNG's header tells, before memory is taken for it."""
    head = content[:PNG_HEAD_BYTES].tobytes()
    if len(head) < PNG_HEAD_BYTES or not head.startswith(b"\x89PNG\r\n\x1a\n"):
        return
    width, height = struct.unpack(">II", head[16:])
    if width * height > MOST_PIXELS:
        raise BadInput(
            f"{path} has {width}x{height} px; at most {MOST_PIXELS} px are read.", "Scale it down."
        )


def read_grey(path: str | Path, raw: Raw = PLAIN) -> Pixels:
    """An image file as grey, (H, W): of the file's depth, see `depth`; colour by BT.601.

    Raises
    ------
    BadInput
        The file is missing, unreadable, no 8-bit, 16-bit or float32 image, or one of more bits than told.
    """
    return raw.grey(read_pixels(Path(path)))


def read_image_set(paths: Sequence[Path], raw: Raw = PLAIN, colour: str = "grey") -> list[Picture]:
    """Several files as grey images of one size; the depth of the 16-bit ones is that of all of them.

    Parameters
    ----------
    colour
        One of `COLOURS`; with "each" a colour image is three of the set.

    Raises
    ------
    BadInput
        No files, one that cannot be read, or one whose size differs from the first.
    """
    if not paths:
        raise BadInput("No image files given.", "Name at least one.")
    files = [
        (number, band, pixels) for number, path in enumerate(paths) for band, pixels in _bands(path, colour)
    ]
    highest = max((int(pixels.max()) for _, _, pixels in files if pixels.dtype == np.uint16), default=0)
    images: list[Picture] = []
    while files:  # a large one is not held in two forms longer than need be
        number, band, pixels = files.pop(0)
        images.append(Picture(raw.grey(pixels, highest), paths[number], number, band))
    first = images[0].pixels.shape
    for image in images:
        height, width = image.pixels.shape
        if (height, width) != first:
            raise BadInput(
                f"{image.file} has {width}x{height} px, {paths[0]} has {first[1]}x{first[0]}.",
                "The images of a set must be of one size.",
            )
        if min(height, width) < 3:
            raise BadInput(f"{image.file} is only {width}x{height} px.", "Edges need at least 3x3 px.")
    return images


def _bands(path: Path, colour: str) -> list[tuple[str, NDArray[Any]]]:
    """What is taken of a file: bands, with their names, or its grey without one."""
    pixels = _decoded(path)
    alike = pixels.ndim == 2 or bool((pixels == pixels[..., :1]).all())
    if colour == "grey" or alike:
        return [("", one_band(pixels, "grey"))]
    return [(band, one_band(pixels, band)) for band in (ONE[1:] if colour == "each" else [colour])]
