"""Image files as grey arrays."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from bridge.errors import BadInput


def _decoded(path: Path) -> NDArray[np.unsignedinteger]:
    """The file's pixels, grey, 8 or 16 bits."""
    try:
        content = np.frombuffer(path.read_bytes(), np.uint8)
    except OSError as error:
        reason = error.strerror or str(error)
        raise BadInput(f"Cannot read image {path}: {reason}.", "Check the path.") from error
    pixels = cv2.imdecode(content, cv2.IMREAD_UNCHANGED) if content.size else None
    if pixels is None:
        raise BadInput(f"{path} is not an image that can be read.", "Give a PNG, JPEG, TIFF or PGM file.")
    if pixels.dtype not in (np.uint8, np.uint16):
        raise BadInput(f"{path} holds {pixels.dtype} pixels.", "Give an 8-bit or 16-bit image.")
    if pixels.ndim == 3:
        code = {3: cv2.COLOR_BGR2GRAY, 4: cv2.COLOR_BGRA2GRAY}.get(pixels.shape[2])
        if pixels.shape[2] == 1:
            pixels = pixels[:, :, 0]
        elif code is None:
            raise BadInput(f"{path} has {pixels.shape[2]} planes.", "Give a grey or colour image.")
        else:
            pixels = cv2.cvtColor(pixels, code)  # BT.601
    return np.ascontiguousarray(pixels, dtype=pixels.dtype.type)


def read_grey(path: str | Path) -> NDArray[np.uint8]:
    """An image file as uint8 grey, (H, W); colour by BT.601, 16 bits scaled to 8.

    Raises
    ------
    BadInput
        The file is missing, unreadable or no 8-bit or 16-bit image.
    """
    pixels = _decoded(Path(path))
    if pixels.dtype == np.uint16:
        return np.round(pixels.astype(np.float32) * np.float32(255.0 / 65535.0)).astype(np.uint8)
    return pixels.astype(np.uint8, copy=False)


def read_linear(path: str | Path) -> NDArray[np.float32]:
    """An image file as float32 grey in 0..1, (H, W), at its full depth; colour by BT.601.

    Raises
    ------
    BadInput
        As `read_grey`.
    """
    pixels = _decoded(Path(path))
    return pixels.astype(np.float32) / np.float32(np.iinfo(pixels.dtype).max)


def read_image_set(paths: Sequence[str | Path]) -> list[NDArray[np.uint8]]:
    """Several files as uint8 grey images of one size.

    Raises
    ------
    BadInput
        No files, one that cannot be read, or one whose size differs from the first.
    """
    if not paths:
        raise BadInput("No image files given.", "Name at least one.")
    images = [read_grey(path) for path in paths]
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
