"""Sub-pixel edge points: maxima of the Gaussian derivative along the normals of model lines."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]

PEAKS = 3  # kept for each sample and channel, strongest first
STEP_PX = 0.5  # between the points where the derivative is looked at
MIN_SNR = 4.0  # of the derivative against its noise, for a maximum to count
MIN_ALIGNED = 0.85  # least |cos| between the gradient and the line's normal: about 30 degrees
CLIPPED_SD_PX = 0.5  # saturation moves an edge towards its dark side by up to the blur
DERIVATIVE_NOISE = 1.0 / math.sqrt(8.0 * math.pi)  # sd of the first derivative: this * sd / sigma^2
CURVATURE_NOISE = math.sqrt(3.0 / (16.0 * math.pi))  # sd of the second derivative: this * sd / sigma^3


@njit(cache=True)
def _bilinear(field: NDArray[np.float32], x: float, y: float) -> float:
    """Value between pixels; the caller keeps 0 <= x < W - 1 and 0 <= y < H - 1."""
    column, row = int(x), int(y)
    a, b = x - column, y - row
    top = (1.0 - a) * field[row, column] + a * field[row, column + 1]
    bottom = (1.0 - a) * field[row + 1, column] + a * field[row + 1, column + 1]
    return float((1.0 - b) * top + b * bottom)


@njit(cache=True)
def find_edge_points(
    gx: NDArray[np.float32],
    gy: NDArray[np.float32],
    noise: NDArray[np.float32],
    near_clipped: NDArray[np.uint8],
    sigmas: Floats,
    scale: NDArray[np.int64],
    image: Floats,
    normal: Floats,
    reach_px: Floats,
) -> tuple[Floats, Floats, Floats, Floats]:
    """Look for edges on the normals of samples, in one channel.

    A maximum of |g . n| along the normal, where g is the gradient smoothed with the sample's scale, is placed
    by a parabola through the logarithm of the three values one px apart (exact for a Gaussian-shaped
    response).
    Its standard deviation follows from the noise of the second derivative divided by the curvature.

    Parameters
    ----------
    gx, gy, near_clipped
        (S, H, W), see `GradientChannel`; noise (H, W).
    sigmas
        (S,) px. scale: (N,), index into them for each sample.
    image, normal
        (N, 2) px; the unit normal of the line in the image.
    reach_px
        (N,), how far to look to either side.

    Returns
    -------
    offset (N, PEAKS) px along the normal, NaN where there is none; snr (N, PEAKS); sd_px (N, PEAKS);
    strength (N, PEAKS), the signed derivative, grey per px.
    """
    count = len(image)
    rows, columns = noise.shape
    offset = np.full((count, PEAKS), np.nan)
    snr = np.zeros((count, PEAKS))
    sd = np.zeros((count, PEAKS))
    strength = np.zeros((count, PEAKS))
    longest = int(np.ceil(reach_px.max() / STEP_PX)) if count > 0 else 0
    profile = np.empty(2 * longest + 7)
    around = int(1.0 / STEP_PX)  # steps to the neighbours of the parabola
    for i in range(count):
        s = scale[i]
        sigma = sigmas[s]
        half = int(np.ceil(reach_px[i] / STEP_PX)) + around
        length = 2 * half + 1
        nx, ny = normal[i, 0], normal[i, 1]
        for k in range(length):
            u = (k - half) * STEP_PX
            x, y = image[i, 0] + u * nx, image[i, 1] + u * ny
            if x < 0.0 or y < 0.0 or x >= columns - 1 or y >= rows - 1:
                profile[k] = 0.0
            else:
                profile[k] = nx * _bilinear(gx[s], x, y) + ny * _bilinear(gy[s], x, y)
        found = 0
        for k in range(around, length - around):
            here = abs(profile[k])
            if here <= abs(profile[k - 1]) or here < abs(profile[k + 1]):
                continue
            u = (k - half) * STEP_PX
            x, y = image[i, 0] + u * nx, image[i, 1] + u * ny
            if x < 1.0 or y < 1.0 or x >= columns - 2 or y >= rows - 2:
                continue
            row, column = int(y + 0.5), int(x + 0.5)
            pixel_noise = noise[row, column]
            ratio = here * sigma * sigma / (DERIVATIVE_NOISE * pixel_noise)
            if ratio < MIN_SNR:
                continue
            along = -ny * _bilinear(gx[s], x, y) + nx * _bilinear(gy[s], x, y)
            if here < MIN_ALIGNED * math.sqrt(here * here + along * along):
                continue
            sign = 1.0 if profile[k] > 0.0 else -1.0
            before, after = sign * profile[k - around], sign * profile[k + around]
            if before <= 0.0 or after <= 0.0:
                before, after = max(before, 0.02 * here), max(after, 0.02 * here)
            before, middle, after = math.log(before), math.log(here), math.log(after)
            bend = before - 2.0 * middle + after
            if bend >= -1e-6:
                continue
            shift = 0.5 * (before - after) / bend
            if abs(shift) > 0.75:
                continue
            place = u + shift
            if abs(place) > reach_px[i]:
                continue
            curvature = here * -bend
            uncertainty = CURVATURE_NOISE * pixel_noise / (sigma * sigma * sigma * curvature)
            if near_clipped[s, row, column] != 0:
                uncertainty = math.sqrt(uncertainty * uncertainty + (CLIPPED_SD_PX * sigma) ** 2)
                ratio *= 0.5
            slot = found
            if found == PEAKS:
                slot = -1
                weakest = ratio
                for m in range(PEAKS):
                    if snr[i, m] < weakest:
                        weakest, slot = snr[i, m], m
                if slot < 0:
                    continue
            else:
                found += 1
            offset[i, slot], snr[i, slot], sd[i, slot] = place, ratio, uncertainty
            strength[i, slot] = sign * here
    return offset, snr, sd, strength
