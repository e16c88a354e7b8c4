"""Pixel formats: a buffer of the camera as a grey image, with one copy."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np

from image_server.v4l2.kernel import COLORSPACE_JPEG, FULL_RANGE, PixFormat, fourcc_name
from numerics.arrays import Grey

Bytes = Grey

VIDEO_BLACK, VIDEO_WHITE = 16, 235  # limited range of an 8-bit luma sample, ITU-R BT.601


@dataclass(frozen=True)
class Layout:
    """How a buffer holds an image."""

    name: str
    width: int
    height: int
    bytes_per_line: int
    full_range: bool = True

    @classmethod
    def of(cls, pix: PixFormat) -> "Layout":
        """The layout that the driver has agreed to.

        Without a word on quantisation, luma of YUYV is limited to 16..235 except in JPEG's colour space
        (V4L2_MAP_QUANTIZATION_DEFAULT); grey formats use every value.
        """
        name = fourcc_name(pix.pixelformat)
        full = pix.quantization == FULL_RANGE or (
            pix.quantization == 0 and (name != "YUYV" or pix.colorspace == COLORSPACE_JPEG)
        )
        return cls(name, pix.width, pix.height, pix.bytesperline, full)


class DamagedFrameError(ValueError):
    """A buffer that does not hold a whole image."""


def decoded(data: Bytes, layout: Layout) -> Grey:
    """The grey image in a buffer, (H, W) uint8, in memory of its own.

    Raises
    ------
    DamagedFrameError : too short, or not decodable.
    """
    return DECODERS[layout.name](data, layout)


def _lines(data: Bytes, layout: Layout, bytes_per_pixel: int) -> Bytes:
    """The buffer as (H, W · bytes_per_pixel), without the padding of the lines; no copy."""
    stride = layout.bytes_per_line or layout.width * bytes_per_pixel
    wanted = stride * (layout.height - 1) + layout.width * bytes_per_pixel
    if data.size < wanted:
        raise DamagedFrameError(f"{data.size} of {wanted} bytes came")
    shape = (layout.height, layout.width * bytes_per_pixel)
    lines: Bytes = np.ndarray(shape, np.uint8, data, strides=(stride, 1))
    return lines


def _grey(data: Bytes, layout: Layout) -> Grey:
    return _ranged(_lines(data, layout, 1).copy(), layout)


def _grey16(data: Bytes, layout: Layout) -> Grey:
    image = cv2.convertScaleAbs(_lines(data, layout, 2).view("<u2"), alpha=1 / 257)
    return _ranged(np.asarray(image, dtype=np.uint8), layout)


def _luma_of_yuyv(data: Bytes, layout: Layout) -> Grey:
    return _ranged(_lines(data, layout, 2)[:, ::2].copy(), layout)


def _motion_jpeg(data: Bytes, layout: Layout) -> Grey:
    image = cv2.imdecode(data, cv2.IMREAD_GRAYSCALE)
    if image is None or image.shape != (layout.height, layout.width):
        raise DamagedFrameError(f"{data.size} bytes are no JPEG image of {layout.width}×{layout.height} px")
    return np.asarray(image, np.uint8)


DECODERS: dict[str, Callable[[Bytes, Layout], Grey]] = {
    "GREY": _grey,
    "Y16": _grey16,
    "YUYV": _luma_of_yuyv,
    "MJPG": _motion_jpeg,
}
"""By the format's four letters, the one that keeps most of the image first."""


@cache
def _expansion() -> Grey:
    """Table from limited to full range."""
    values = (np.arange(256.0) - VIDEO_BLACK) * (255.0 / (VIDEO_WHITE - VIDEO_BLACK))
    table: Grey = np.rint(values.clip(0, 255)).astype(np.uint8)
    return table


def _ranged(image: Grey, layout: Layout) -> Grey:
    return image if layout.full_range else np.asarray(cv2.LUT(image, _expansion()), np.uint8)
