"""The lens: zoom, defocus by distance, vignetting, and the light it scatters over the frame.

A thin lens of focal length f and f-number N, focused at s, images a point at depth d as a disc. On the
sensor, in px, its diameter is

    fx · (f / N) · |1/s - 1/d|

(Born and Wolf; fx, the calibrated distance of the image in px, stands for f s / (s - f)).
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np

from geometry.camera import Camera
from numerics.arrays import Field, Floats

DISC_STEP_PX = 0.75  # of diameter, between the discs that are blended
MOST_DISCS = 8  # bounds the time of a frame
LEAST_DISC_PX = 0.25  # a disc below this changes nothing that a pixel does not
LEAST_DRAWN_PX = 3.0  # chosen by hand; a smaller disc becomes three taps
SUBPIXELS = 16  # along each axis, for the coverage of a disc's rim
MOST_SUBPIXELS = 4096  # along each axis of a disc, chosen by hand; bounds its memory
MOST_ROUND_PX = 100  # reach beyond which a square is searched, chosen by hand; bounds the time of a frame
GLARE_CORE_PX = 2.0  # chosen by hand, so that the middle stays finite
GLARE_WIDTH = 160  # to which the frame is reduced before it is scattered


def disc_diameters(inverse_depth: Field, fx: float, aperture_m: float, focus_m: float) -> Field:
    """Diameter (H, W) of the blur disc, px, from 1/depth (0: at infinity) and the width of the aperture."""
    return np.asarray(np.abs(inverse_depth - np.float32(1.0 / focus_m)) * np.float32(fx * aperture_m))


def nearest_around(inverse_depth: Field, reach_px: int) -> Field:
    """Each pixel's largest 1/depth within reach: a blurred outline spreads over what is behind it."""
    size = 2 * reach_px + 1
    round_window = reach_px <= MOST_ROUND_PX
    window = cv2.getStructuringElement(cv2.MORPH_ELLIPSE if round_window else cv2.MORPH_RECT, (size, size))
    return np.asarray(cv2.dilate(inverse_depth, window), dtype=np.float32)


def zoomed(camera: Camera, focals_mm: Sequence[float] | None, focal_mm: float | None) -> Camera:
    """The camera, which is one at the first of these focal lengths, at another: fx and fy grow with it."""
    if focal_mm is None or not focals_mm:
        return camera
    factor = focal_mm / focals_mm[0]
    return replace(camera, fx=camera.fx * factor, fy=camera.fy * factor)


def focused(radiance: Field, inverse_depth: Field, fx: float, aperture_m: float, focus_m: float) -> Field:
    """Radiance (H, W) as a lens focused at `focus_m` shows it.

    Each pixel takes the disc of its own depth, or of the nearest thing whose blurred outline reaches it. So
    what is seen past an outline is as blurred as the outline, within its reach. No disc is wider than the
    frame.
    """
    frame = np.float32(max(radiance.shape))
    own = np.minimum(disc_diameters(inverse_depth, fx, aperture_m, focus_m), frame)
    widest = float(own.max(where=inverse_depth > 0, initial=0.0))
    if widest > 0:
        around = nearest_around(inverse_depth, math.ceil(widest / 2) + 1)
        own = np.minimum(disc_diameters(around, fx, aperture_m, focus_m), frame)
    least, most = float(own.min()), float(own.max())
    if most < LEAST_DISC_PX:
        return radiance
    count = min(MOST_DISCS, 1 + math.ceil((most - least) / DISC_STEP_PX))
    diameters = np.linspace(least, most, count)
    if count == 1:
        return _spread(radiance, most)
    place = (own - np.float32(least)) * np.float32((count - 1) / (most - least))
    out = np.zeros_like(radiance)
    for index, diameter in enumerate(diameters):
        weight = np.maximum(1.0 - np.abs(place - np.float32(index)), 0.0)
        if weight.any():
            out += weight * _spread(radiance, float(diameter))
    return out


def _spread(image: Field, diameter_px: float) -> Field:
    if diameter_px < LEAST_DISC_PX:
        return image
    kernel = disc_kernel(diameter_px)
    return np.asarray(cv2.filter2D(image, cv2.CV_32F, kernel, borderType=cv2.BORDER_REPLICATE), np.float32)


def disc_kernel(diameter_px: float) -> Field:
    """A disc in whole pixels; odd sizes, sum 1, variance diameter²/16 along each axis like the disc's own.

    The share of each pixel that a disc covers would have the 1/12 px² of a pixel on top, which the image
    already has; so the disc that is drawn is so much narrower. One too small for that becomes three taps.
    """
    variance = diameter_px**2 / 16
    if diameter_px < LEAST_DRAWN_PX:
        taps = np.array([variance / 2, 1 - variance, variance / 2])
        return np.asarray(np.outer(taps, taps), dtype=np.float32)
    radius = 2 * math.sqrt(variance - 1 / 12)
    half = math.ceil(radius - 0.5)
    side = 2 * half + 1
    parts = max(1, min(SUBPIXELS, MOST_SUBPIXELS // side))
    fine = (np.arange(side * parts) + 0.5) / parts - 0.5 - half
    inside = fine[:, None] ** 2 + fine[None, :] ** 2 <= radius**2
    covered = inside.reshape(side, parts, side, parts).sum(axis=(1, 3))
    return np.asarray(covered / covered.sum(), dtype=np.float32)


def vignette(camera: Camera, exponent: float) -> Field:
    """Factor (H, W) by which the image darkens: the cosine of the field angle to a power."""
    x = (np.arange(camera.width) - camera.cx) / camera.fx
    y = (np.arange(camera.height) - camera.cy) / camera.fy
    square: Floats = 1.0 + y[:, None] ** 2 + x[None, :] ** 2
    out: Field = (square ** (-exponent / 2)).astype(np.float32)
    return out


def glared(image: Field, share: float) -> Field:
    """Image (H, W) of which a share is scattered over the frame, falling with the square of the distance.

    The frame is reduced first: what is scattered is smooth but for its middle, where the image itself is.
    Light from outside of the frame is not scattered into it.
    """
    height, width = image.shape
    step = max(1, round(width / GLARE_WIDTH))
    small = cv2.resize(
        image, (math.ceil(width / step), math.ceil(height / step)), interpolation=cv2.INTER_AREA
    )
    rows, columns = small.shape
    y = np.minimum(np.arange(2 * rows), 2 * rows - np.arange(2 * rows))[:, None] * float(step)
    x = np.minimum(np.arange(2 * columns), 2 * columns - np.arange(2 * columns))[None, :] * float(step)
    kernel = 1.0 / (x * x + y * y + GLARE_CORE_PX**2)
    kernel /= kernel.sum()
    spectrum = np.fft.rfft2(small, (2 * rows, 2 * columns)) * np.fft.rfft2(kernel)
    scattered = np.fft.irfft2(spectrum, (2 * rows, 2 * columns))[:rows, :columns].astype(np.float32)
    wide = cv2.resize(scattered, (width, height), interpolation=cv2.INTER_LINEAR)
    return np.asarray((1.0 - share) * image + share * np.maximum(wide, 0.0), dtype=np.float32)
