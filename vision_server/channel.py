"""Per-channel statistics: what one image says about edges, computed once and kept.

A *channel* is one image of the set. Its gradient is measured on linear intensity (tone curve undone) with
the exposure divided out, so that channels are comparable; each pixel also gets a weight that says how lit it is in
this channel, and the noise that the gradient carries there.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from bridge.errors import BadInput
from vision_server.noise import grey_noise

Grey = NDArray[np.uint8]
Field = NDArray[np.float32]

WEIGHT_EXPONENT = 12.0  # k in w = 2^(k l): how steeply a channel loses its say where it is darker
LIT_OFFSET_GREY = 8.0  # grey at reference exposure added before the logarithm: black is black
LIT_WINDOW_PX = 5  # side of the window over which the lit-ness is averaged
SATURATED_GREY = 250  # from here on a pixel is clipped
FLOOR_NOISE_RATIO = 3.0  # a gradient under so many of its own standard deviations is no edge
LOG2_WEIGHT_LIMIT = 100.0  # float32 holds 2^126; room for sums


@dataclass(frozen=True)
class ChannelStatistics:
    """What one image contributes to the merged edge map; all arrays (H, W).

    Attributes
    ----------
    linear
        float32, linear intensity at this frame's own exposure, 0..255 (255 is full scale).
    contrast
        float32, gradient magnitude as the height in grey, at reference exposure, of the ideal step edge that
        would give it (gradient times sqrt(2 pi) sigma); 0 where below the noise floor or beside saturation.
    orientation
        float32, direction of the gradient taken as an axis, rad in [0, pi), 0 along x, pi/2 along y (down).
    weight
        float32, 2^(k l): how lit the pixel is in this channel.
    noise
        float32, standard deviation of ``contrast`` from sensor noise.
    unsaturated
        bool, False within reach of a clipped pixel.
    exposure, sigma_px
        relative exposure of the frame; scale of the gradient.
    """

    linear: Field
    contrast: Field
    orientation: Field
    weight: Field
    noise: Field
    unsaturated: NDArray[np.bool_]
    exposure: float
    sigma_px: float

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the image in px."""
        height, width = self.linear.shape
        return height, width


def gaussian_kernels(sigma_px: float) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Sampled Gaussian (sum 1) and its derivative (unit response to a unit ramp), both 1-D float32."""
    radius = int(np.ceil(3.0 * sigma_px))
    x = np.arange(-radius, radius + 1, dtype=np.float64)
    smooth = np.exp(-0.5 * (x / sigma_px) ** 2)
    smooth /= smooth.sum()
    derivative = x * smooth
    derivative /= (derivative * x).sum()
    return smooth.astype(np.float32), derivative.astype(np.float32)


@njit(cache=True)
def _polar(
    gx: Field,
    gy: Field,
    variance: Field,
    log_lit: Field,
    usable: Grey,
    height: float,
    noise_gain: float,
    floor_ratio: float,
    exponent: float,
    contrast: Field,
    orientation: Field,
    weight: Field,
    noise: Field,
) -> None:
    """Contrast, axis, weight and noise at each pixel; the equations of `channel_statistics`."""
    rows, columns = gx.shape
    for y in range(rows):
        for x in range(columns):
            sd = np.float32(np.sqrt(variance[y, x]) * noise_gain)
            noise[y, x] = sd
            exponent_here = exponent * log_lit[y, x]
            exponent_here = min(max(exponent_here, -LOG2_WEIGHT_LIMIT), LOG2_WEIGHT_LIMIT)
            weight[y, x] = np.float32(2.0) ** np.float32(exponent_here)
            a, b = gx[y, x], gy[y, x]
            m = np.float32(np.sqrt(a * a + b * b) * height)
            if usable[y, x] == 0 or m <= floor_ratio * sd:
                contrast[y, x] = 0.0
                orientation[y, x] = 0.0
                continue
            contrast[y, x] = m
            angle = np.arctan2(b, a)
            if angle < 0.0:
                angle += np.pi
            if angle >= np.pi:
                angle -= np.pi
            orientation[y, x] = np.float32(angle)


def channel_statistics(
    image: Grey,
    exposure: float = 1.0,
    gamma: float = 1.0,
    *,
    sigma_px: float = 1.0,
    weight_exponent: float = WEIGHT_EXPONENT,
) -> ChannelStatistics:
    """Edge statistics of one image.

    Parameters
    ----------
    image
        uint8 grey, (H, W).
    exposure
        Relative exposure, > 0: shutter / aperture^2 times gain over that of the reference settings.
        Everything measured is divided by it.
    gamma
        Tone curve to undo: linear = grey^gamma. 1 for linear files.
    sigma_px
        Scale of the Gaussian derivative, px.
    weight_exponent
        k of the weight 2^(k l), with l the mean over 5 x 5 px of log2((I / exposure + 8) / 128). 0 weighs all
        channels alike.

    Returns
    -------
    ChannelStatistics

    Raises
    ------
    BadInput
        Wrong type or shape of the image, exposure or gamma not positive.
    """
    if image.ndim != 2 or image.dtype != np.uint8 or min(image.shape) < 3:
        raise BadInput(
            f"a channel must be a grey uint8 image of at least 3x3 px, not {image.dtype} {image.shape}"
        )
    if not (np.isfinite(exposure) and exposure > 0.0):
        raise BadInput(f"the exposure of a channel must be a positive number, not {exposure}")
    if not (np.isfinite(gamma) and gamma > 0.0):
        raise BadInput(f"gamma must be a positive number, not {gamma}")
    level = np.arange(256, dtype=np.float64) / 255.0
    linear_of = 255.0 * level**gamma
    slope_of = np.maximum(gamma * level ** (gamma - 1.0), 1e-3) if gamma != 1.0 else np.ones(256)
    variance_of = (grey_noise(image) * slope_of) ** 2
    lit_of = np.log2((linear_of / exposure + LIT_OFFSET_GREY) / 128.0)

    linear = cv2.LUT(image, linear_of.astype(np.float32))
    smooth, derivative = gaussian_kernels(sigma_px)
    gx = cv2.sepFilter2D(linear, cv2.CV_32F, derivative, smooth, borderType=cv2.BORDER_REPLICATE)
    gy = cv2.sepFilter2D(linear, cv2.CV_32F, smooth, derivative, borderType=cv2.BORDER_REPLICATE)
    window = (LIT_WINDOW_PX, LIT_WINDOW_PX)
    log_lit = cv2.blur(cv2.LUT(image, lit_of.astype(np.float32)), window, borderType=cv2.BORDER_REPLICATE)
    variance = cv2.blur(
        cv2.LUT(image, variance_of.astype(np.float32)), window, borderType=cv2.BORDER_REPLICATE
    )
    reach = len(smooth) // 2
    clipped = cv2.compare(image, SATURATED_GREY, cv2.CMP_GE)
    usable = 255 - cv2.dilate(clipped, np.ones((2 * reach + 1, 2 * reach + 1), np.uint8))

    height = float(np.sqrt(2.0 * np.pi) * sigma_px / exposure)
    noise_gain = height * float(np.linalg.norm(smooth) * np.linalg.norm(derivative))
    shape = image.shape
    contrast, orientation = np.empty(shape, np.float32), np.empty(shape, np.float32)
    weight, noise = np.empty(shape, np.float32), np.empty(shape, np.float32)
    _polar(
        gx,
        gy,
        variance,
        log_lit,
        usable,
        height,
        noise_gain,
        FLOOR_NOISE_RATIO,
        weight_exponent,
        contrast,
        orientation,
        weight,
        noise,
    )
    return ChannelStatistics(linear, contrast, orientation, weight, noise, usable > 0, exposure, sigma_px)
