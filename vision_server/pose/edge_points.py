"""Sub-pixel edge points: maxima of the Gaussian derivative along the normals of model lines."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from numerics.kernels import kernel

Floats = NDArray[np.float64]

PEAKS = 3  # kept for each sample and channel, strongest first
MIN_SNR = 4.0  # of the derivative against its noise, for a maximum to count
MIN_ALIGNED = 0.85  # least |cos| between the gradient and the line's normal: about 30 degrees
CLIPPED_SD_PX = 0.5  # saturation moves an edge towards its dark side by up to the blur
DERIVATIVE_NOISE = 1.0 / math.sqrt(8.0 * math.pi)  # sd of the first derivative: this * sd / sigma^2
LEAST_SHARE = 0.02  # of the peak, that its neighbours count with at least
MOST_SHIFT_PX = 1.0  # of a peak from where the pixel-wide steps see it
CURVATURE_NOISE = math.sqrt(3.0 / (16.0 * math.pi))  # sd of the second derivative: this * sd / sigma^3


@kernel(error_model="numpy")
def _gradient(gradient: NDArray[np.float32], x: float, y: float) -> tuple[float, float]:
    """Derivatives along x and y between pixels, bilinear; the caller keeps 0 <= x < W - 1, 0 <= y < H - 1.

    ``gradient`` (H, W, 2); unsigned places spare the look for negative ones.
    """
    column, row = np.uint32(x), np.uint32(y)
    right, below = column + np.uint32(1), row + np.uint32(1)
    a, b = x - np.float64(column), y - np.float64(row)
    c, d = (1.0 - a) * (1.0 - b), a * (1.0 - b)
    e, f = (1.0 - a) * b, a * b
    along_x = (
        c * gradient[row, column, 0]
        + d * gradient[row, right, 0]
        + e * gradient[below, column, 0]
        + f * gradient[below, right, 0]
    )
    along_y = (
        c * gradient[row, column, 1]
        + d * gradient[row, right, 1]
        + e * gradient[below, column, 1]
        + f * gradient[below, right, 1]
    )
    return along_x, along_y


@kernel(error_model="numpy")
def _derivative(gradient: NDArray[np.float32], x: float, y: float, nx: float, ny: float) -> float:
    """Derivative along (nx, ny) at a place as in `_gradient`."""
    along_x, along_y = _gradient(gradient, x, y)
    return float(nx * along_x + ny * along_y)


@kernel(error_model="numpy")
def _parabola(before: float, here: float, after: float) -> tuple[float, float]:
    """Place of the maximum of a Gaussian through three values one px apart, and minus its log curvature."""
    least = LEAST_SHARE * here
    before, here, after = math.log(max(before, least)), math.log(here), math.log(max(after, least))
    bend = 2.0 * here - before - after
    return (0.5 * (after - before) / bend if bend > 0.0 else np.inf), bend


@kernel(error_model="numpy")
def find_edge_points(
    gradient: NDArray[np.float32],
    noise: NDArray[np.float32],
    near_clipped: NDArray[np.uint8],
    sigmas: Floats,
    scale: NDArray[np.int64],
    image: Floats,
    normal: Floats,
    reach_px: Floats,
) -> tuple[Floats, Floats, Floats, Floats]:
    """Look for edges on the normals of samples, in one channel.

    The derivative g . n along the normal, where g is the gradient smoothed with the sample's scale, is looked
    at in steps of a pixel. Each maximum of its magnitude is placed by a parabola through the logarithms of
    three values one px apart (exact for a Gaussian-shaped response), first on the steps and then around the
    place so found, which frees it from their phase. Its standard deviation follows from the noise of the
    second derivative divided by the curvature.

    Parameters
    ----------
    gradient, near_clipped
        (S, H, W, 2) and (S, H, W), see `GradientChannel`; noise (H, W).
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
    right, bottom = columns - 2.0, rows - 2.0
    offset = np.full((count, PEAKS), np.nan)
    snr = np.zeros((count, PEAKS))
    sd = np.zeros((count, PEAKS))
    strength = np.zeros((count, PEAKS))
    profile = np.empty(2 * int(np.ceil(reach_px.max())) + 3 if count > 0 else 0)
    for i in range(count):
        s = scale[i]
        sigma = sigmas[s]
        half = int(np.ceil(reach_px[i])) + 1
        nx, ny = normal[i, 0], normal[i, 1]
        at_scale = gradient[s]
        for k in range(2 * half + 1):
            u = float(k - half)
            x, y = image[i, 0] + u * nx, image[i, 1] + u * ny
            inside = x >= 0.0 and y >= 0.0 and x < columns - 1 and y < rows - 1
            profile[k] = _derivative(at_scale, x, y, nx, ny) if inside else 0.0
        found = 0
        for k in range(1, 2 * half):
            here = abs(profile[k])
            if here <= abs(profile[k - 1]) or here < abs(profile[k + 1]):
                continue
            u = float(k - half)
            x, y = image[i, 0] + u * nx, image[i, 1] + u * ny
            if x < 1.0 or y < 1.0 or x >= right or y >= bottom:
                continue
            pixel_noise = noise[int(y + 0.5), int(x + 0.5)]
            to_snr = sigma * sigma / (DERIVATIVE_NOISE * pixel_noise)
            if here * to_snr < MIN_SNR:
                continue
            sign = 1.0 if profile[k] > 0.0 else -1.0
            shift, bend = _parabola(sign * profile[k - 1], here, sign * profile[k + 1])
            if not abs(shift) <= MOST_SHIFT_PX:
                continue
            place = u + shift
            x, y = image[i, 0] + place * nx, image[i, 1] + place * ny
            if x < 2.0 or y < 2.0 or x >= right - 1.0 or y >= bottom - 1.0:
                continue
            along_x, along_y = _gradient(at_scale, x, y)
            here = sign * (nx * along_x + ny * along_y)
            if not here > 0.0:
                continue
            before = sign * _derivative(at_scale, x - nx, y - ny, nx, ny)
            after = sign * _derivative(at_scale, x + nx, y + ny, nx, ny)
            shift, bend = _parabola(before, here, after)
            if not abs(shift) <= 0.5:
                continue
            place += shift
            across = nx * along_y - ny * along_x
            if here < MIN_ALIGNED * math.sqrt(here * here + across * across) or abs(place) > reach_px[i]:
                continue
            ratio = here * to_snr
            if ratio < MIN_SNR:
                continue
            uncertainty = CURVATURE_NOISE * pixel_noise / (sigma * sigma * sigma * here * bend)
            if near_clipped[s, int(y + 0.5), int(x + 0.5)] != 0:
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
