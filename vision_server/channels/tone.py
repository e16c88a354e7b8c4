"""The tone curve of an image file, where its format tells: edges are measured on linear intensity."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path

# How far a tone curve that is left in the images may move edges, px per relative height: what is left of a
# known curve; of a nominal one (0.19 was seen on sRGB read as linear).
KNOWN_TONE_SD_PX = 0.01
NOMINAL_TONE_SD_PX = 0.15
SRGB_GAMMA = 2.2  # the power that is closest to the sRGB curve
PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
JPEG_SIGNATURE = b"\xff\xd8\xff"
HEADER_BYTES = 4096  # chunks that tell the curve come before the pixels


def file_gamma(path: Path) -> float:
    """Exponent that makes the file's grey linear: linear = grey^gamma.

    JPEG files are sRGB by convention (JFIF, Exif); PNG files say so in a gAMA or sRGB chunk, which the
    libraries that write camera frames leave out. A file that does not tell counts as linear.
    """
    try:
        with path.open("rb") as file:
            head = file.read(HEADER_BYTES)
    except OSError:
        return 1.0
    if head.startswith(JPEG_SIGNATURE):
        return SRGB_GAMMA
    if head.startswith(PNG_SIGNATURE):
        return _png_gamma(head)
    return 1.0


def file_tone(paths: Sequence[Path], gamma: float | None) -> tuple[list[float], float]:
    """Exponents for some files, and how well edges are known to be free of the tone curve.

    Parameters
    ----------
    gamma
        What the camera's description or the user says, None if nothing.

    Returns
    -------
    One exponent a file; the standard deviation that refinement assumes of the shift of an edge, px. sRGB is
    only nominal (renderers and cameras bend the curve further), so that a file that was decoded as sRGB
    leaves room.
    """
    if gamma is not None:
        return [gamma] * len(paths), KNOWN_TONE_SD_PX
    exponents = [file_gamma(path) for path in paths]
    nominal = any(exponent != 1.0 for exponent in exponents)
    return exponents, NOMINAL_TONE_SD_PX if nominal else KNOWN_TONE_SD_PX


def _png_gamma(head: bytes) -> float:
    at = len(PNG_SIGNATURE)
    gamma = 1.0
    while at + 12 <= len(head):
        length, kind = struct.unpack(">I4s", head[at : at + 8])
        if kind == b"sRGB":
            return SRGB_GAMMA
        if kind == b"gAMA" and at + 12 <= len(head):
            stored = struct.unpack(">I", head[at + 8 : at + 12])[0]
            if stored > 0:
                gamma = 100000.0 / stored
        if kind == b"IDAT":
            break
        at += 12 + length
    return gamma
