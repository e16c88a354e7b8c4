"""Image files as grey arrays (H, W), of their own depth: 8 or 16 bits, or floats."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from bridge.errors import BadInput
from numerics.arrays import Grey
from vision_server.channels.depth import Pixels, Raw

MOST_PIXELS = 150_000_000  # more than any camera's sensor has: 2.5 GB for its channel
PLAIN = Raw()  # of any depth, without a mosaic
PNG_HEAD_BYTES = 24  # signature, length and type of the first chunk, width, height


def read_pixels(path: Path) -> NDArray[Any]:
    """The file's pixels, grey, (H, W): uint8, uint16 or float32 0..1; upright, as its EXIF says.

    Raises
    ------
    BadInput
        The file is missing, unreadable or no 8-bit, 16-bit or float32 image.
    """
    try:
        content = np.frombuffer(path.read_bytes(), np.uint8)
    except OSError as error:
        reason = error.strerror or str(error)
        raise BadInput(f"Cannot read image {path}: {reason}.", "Check the path.") from error
    _check_size(path, content)
    # what it warns of, a broken file, is said here
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_ERROR)
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
    if pixels.ndim == 3:
        pixels = cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY)  # BT.601
    return np.ascontiguousarray(pixels, dtype=pixels.dtype.type)


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


def read_image_set(paths: Sequence[str | Path], raw: Raw = PLAIN) -> list[Pixels]:
    """Several files as grey images of one size; the depth of the 16-bit ones is that of all of them.

    Raises
    ------
    BadInput
        No files, one that cannot be read, or one whose size differs from the first.
    """
    if not paths:
        raise BadInput("No image files given.", "Name at least one.")
    files = [read_pixels(Path(path)) for path in paths]
    highest = max((int(pixels.max()) for pixels in files if pixels.dtype == np.uint16), default=0)
    images: list[Pixels] = []
    while files:  # a large one is not held in two forms longer than need be
        images.append(raw.grey(files.pop(0), highest))
    first = images[0].shape
    for path, image in zip(paths, images, strict=True):
        if image.shape != first:
            raise BadInput(
                f"{path} has {image.shape[1]}x{image.shape[0]} px, {paths[0]} has {first[1]}x{first[0]}.",
                "The images of a set must be of one size.",
            )
        if min(image.shape) < 3:
            raise BadInput(
                f"{path} is only {image.shape[1]}x{image.shape[0]} px.", "Edges need at least 3x3 px."
            )
    return images
