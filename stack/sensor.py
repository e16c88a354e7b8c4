"""From linear radiance to grey values: one sensor model for replay and simulator.

The frame of a stack is ``255 * clip(signal, 0, 1)^(1/gamma)`` with
``signal = radiance * gain * (shutter_s / aperture^2) / ((1/60) / 4^2)``; 1 is where the output clips.

Noise
-----
``full_well_e`` electrons fill the signal range at gain 1. Gain multiplies electrons after they were counted,
so at gain g the signal clips at ``full_well_e / g`` electrons. A pixel that holds N = signal · full_well_e
/ g electrons gets Gaussian noise of variance N (photons) + read_noise_e² electrons². Per unit of signal:

    variance = (N + read_noise_e²) · (g / full_well_e)²

The slope of variance over mean (the photon-transfer curve) is therefore g / full_well_e. A Gaussian stands
for Poisson: where they differ (a few electrons), the read noise and the step of 8 bits hide it.

Each pixel may have its own sensitivity (`prnu`, a standard deviation relative to 1) and its own dark signal
(`dsnu_e`, electrons); both patterns belong to the sensor (`pattern_seed`), not to the session (EMVA 1288).
Charge beyond `full_well_e` may spill along the column (`blooming`); by default it drains off.

Blur
----
Before noise: a Gaussian of `defocus_sigma_px` at the widest aperture, falling as 1/aperture (thin lens,
fixed focus), and a centred straight line of `motion_px_per_s` × shutter_s. Beyond the border the image goes
on as at the border.
"""

import math
from collections.abc import Sequence
from functools import lru_cache

import cv2
import numpy as np
from numpy.random import SFC64, Generator, SeedSequence

from bridge.errors import BadInput
from numerics.arrays import Field, Grey
from stack.exposure import WHITE, relative_exposure
from stack.format import CameraTable

LEAST_BLUR_PX = 0.05  # a blur below this changes no 8-bit value by more than rounding
LINE_POINTS_PER_PX = 16  # of the motion kernel; chosen by hand, so that its centroid is right to 1/100 px


def check_blur(camera: CameraTable, where: str) -> None:
    """Raise BadInput where a point would be spread over more than the frame of a stack or a scenario."""
    shutter_s = max(camera.shutters_s)
    moved = math.hypot(*camera.motion_px_per_s) * shutter_s
    for key, spread, within in (
        ("defocus_sigma_px", camera.defocus_sigma_px, ""),
        ("motion_px_per_s", moved, f" in {shutter_s:.3g} s"),
    ):
        if spread > max(camera.width, camera.height):
            raise BadInput(
                f"{where}: {key} blurs over {spread:.3g} px{within},"
                f" and the frame has {camera.width}×{camera.height}.",
                "Give less.",
            )


def mixed(images: Sequence[Field], weights: Sequence[float]) -> Field:
    """Weighted sum of radiance images (H, W) float32: light adds up."""
    total: Field = np.zeros_like(images[0])
    for image, weight in zip(images, weights, strict=True):
        if weight != 0.0:
            cv2.scaleAdd(image, weight, total, dst=total)
    return total


def blurred(radiance: Field, camera: CameraTable, shutter_s: float, aperture: float) -> Field:
    """Radiance (H, W) as it falls on the sensor, out of focus and moving."""
    sigma = camera.defocus_sigma_px * min(camera.apertures) / aperture
    out = radiance
    if sigma > LEAST_BLUR_PX:
        out = np.asarray(
            cv2.GaussianBlur(out, (0, 0), sigma, borderType=cv2.BORDER_REPLICATE), dtype=np.float32
        )
    dx, dy = (speed * shutter_s for speed in camera.motion_px_per_s)
    if math.hypot(dx, dy) > LEAST_BLUR_PX:
        kernel = line_kernel(dx, dy)
        out = np.asarray(
            cv2.filter2D(out, cv2.CV_32F, kernel, borderType=cv2.BORDER_REPLICATE), dtype=np.float32
        )
    return out


def line_kernel(dx: float, dy: float) -> Field:
    """Kernel of a straight uniform motion by (dx, dy) px about its middle; odd sizes, sum 1, centroid 0."""
    count = max(2, math.ceil(LINE_POINTS_PER_PX * math.hypot(dx, dy)))
    along = (np.arange(count) + 0.5) / count - 0.5
    half_x, half_y = (math.ceil(abs(d) / 2) for d in (dx, dy))
    x, y = along * dx + half_x, along * dy + half_y
    kernel = np.zeros((2 * half_y + 2, 2 * half_x + 2))
    left, top = np.floor(x).astype(int), np.floor(y).astype(int)
    right_share, low_share = x - left, y - top
    for row, share_y in ((top, 1 - low_share), (top + 1, low_share)):
        for column, share_x in ((left, 1 - right_share), (left + 1, right_share)):
            np.add.at(kernel, (row, column), share_y * share_x / count)
    return kernel[:-1, :-1].astype(np.float32)


@lru_cache(maxsize=2)
def fixed_pattern(shape: tuple[int, int], seed: int) -> tuple[Field, Field]:
    """Standard normal patterns (H, W) of the pixels' sensitivity and of their dark signal."""
    draws = Generator(SFC64(SeedSequence([seed])))
    return draws.standard_normal(shape, np.float32), draws.standard_normal(shape, np.float32)


def exposed(
    radiance: Field, camera: CameraTable, shutter_s: float, aperture: float, seed: Sequence[int] | None
) -> Grey:
    """Expose radiance and read it out.

    Parameters
    ----------
    radiance : (H, W) float32, linear; 1 clips at 1/60 s, f/4 and gain 1.
    camera : its sensor, and the blur in front of it.
    shutter_s, aperture : exposure time in seconds and f-number.
    seed : (session seed, capture number); the same numbers give the same noise. None: no noise.

    Returns
    -------
    (H, W) uint8.
    """
    exposure = relative_exposure(shutter_s, aperture) * camera.gain
    signal: Field = blurred(radiance, camera, shutter_s, aperture) * np.float32(exposure)
    per_electron = camera.gain / camera.full_well_e
    if camera.prnu > 0 or camera.dsnu_e > 0:
        sensitivity, dark = fixed_pattern(signal.shape, camera.pattern_seed)
        # signal (1 + prnu s) + dsnu d
        signal += np.float32(camera.prnu) * sensitivity * signal
        signal += np.float32(camera.dsnu_e * per_electron) * dark
    if camera.blooming > 0:
        from stack.blooming import bloomed  # a compiled kernel that a sensor without it need not load

        signal = bloomed(signal, camera.gain, camera.blooming)
    if seed is not None:
        variance = np.maximum(signal, 0)
        variance *= np.float32(per_electron)
        variance += np.float32((camera.read_noise_e * per_electron) ** 2)
        np.sqrt(variance, out=variance)
        noise = Generator(SFC64(SeedSequence(list(seed))))
        variance *= noise.standard_normal(signal.shape, dtype=np.float32)
        signal += variance
    np.clip(signal, 0, 1, out=signal)
    if camera.gamma != 1.0:
        cv2.pow(signal, 1 / camera.gamma, dst=signal)
    signal *= np.float32(WHITE)
    return np.rint(signal, out=signal).astype(np.uint8)
