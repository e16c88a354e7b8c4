"""The smoothed gradient of one channel at the scales that refinement asks for, computed once and kept."""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np

from vision_server.channel import SATURATED_GREY, ChannelStatistics, Field, Grey
from vision_server.gaussian import gaussian_kernels

SCALES_PX = (1.0, 2.0, 4.0, 8.0)  # Gaussian derivatives: sharp, soft, defocused, motion-blurred


@dataclass(eq=False)
class GradientChannel:
    """One channel as refinement sees it.

    Attributes
    ----------
    name
        Of the image.
    linear
        float32 (H, W), linear intensity at the frame's own exposure, 0..255.
    noise
        float32 (H, W), standard deviation of ``linear`` from sensor noise.
    clipped
        uint8 (H, W), 1 where the sensor was saturated.
    gx, gy
        float32 (S, H, W), derivatives per px; only the first ``ready`` scales are filled.
    smooth
        float32 (H, W), ``linear`` smoothed at the first scale.
    near_clipped
        uint8 (S, H, W), 1 where a saturated pixel is within the filter's reach.
    """

    name: str
    linear: Field
    noise: Field
    clipped: Grey
    ready: int = 0
    gx: Field = field(init=False)
    gy: Field = field(init=False)
    smooth: Field = field(init=False)
    near_clipped: Grey = field(init=False)

    def __post_init__(self) -> None:
        shape = (len(SCALES_PX), *self.linear.shape)
        self.gx, self.gy = np.empty(shape, np.float32), np.empty(shape, np.float32)
        self.near_clipped = np.empty(shape, np.uint8)

    def prepare(self, scales: int) -> None:
        """Fill the first ``scales`` scales of SCALES_PX."""
        if self.ready == 0 and scales > 0:
            blurred = cv2.GaussianBlur(self.linear, (0, 0), SCALES_PX[0], borderType=cv2.BORDER_REPLICATE)
            self.smooth = np.asarray(blurred, dtype=np.float32)
        for index in range(self.ready, scales):
            smooth, derivative = gaussian_kernels(SCALES_PX[index])
            border = cv2.BORDER_REPLICATE
            self.gx[index] = cv2.sepFilter2D(self.linear, cv2.CV_32F, derivative, smooth, borderType=border)
            self.gy[index] = cv2.sepFilter2D(self.linear, cv2.CV_32F, smooth, derivative, borderType=border)
            side = 2 * int(np.ceil(2.0 * SCALES_PX[index])) + 1
            self.near_clipped[index] = cv2.dilate(self.clipped, np.ones((side, side), np.uint8))
        self.ready = max(self.ready, scales)


def gradient_channel(name: str, image: Grey, statistics: ChannelStatistics) -> GradientChannel:
    """The refinement's view of a channel whose edge statistics are known.

    Parameters
    ----------
    image
        uint8 (H, W), the frame as it came, for its saturated pixels.
    statistics
        Of the same frame; its noise is that of the contrast, and is brought back to single pixels here.
    """
    smooth, derivative = gaussian_kernels(statistics.sigma_px)
    height = np.sqrt(2.0 * np.pi) * statistics.sigma_px / statistics.exposure
    gain = float(height * np.linalg.norm(smooth) * np.linalg.norm(derivative)) * statistics.noise_factor
    noise = np.asarray(statistics.noise / np.float32(gain), dtype=np.float32)
    clipped = (image >= SATURATED_GREY).astype(np.uint8)
    return GradientChannel(name, statistics.linear, noise, clipped)
