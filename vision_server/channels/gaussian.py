"""The Gaussian derivative: its sampled kernels, the gradient they give, and the noise that this carries."""

from __future__ import annotations

import math
from functools import cache

import cv2
import numpy as np

from numerics.arrays import Field, Grey

Kernels = tuple[Field, Field]  # across and along the derivative, float32 (2 R + 1,) each


@cache
def gaussian_kernels(sigma_px: float) -> Kernels:
    """Sampled Gaussian (sum 1) and its derivative (unit response to a unit ramp); shared."""
    radius = int(np.ceil(3.0 * sigma_px))
    x = np.arange(-radius, radius + 1, dtype=np.float64)
    smooth = np.exp(-0.5 * (x / sigma_px) ** 2)
    smooth /= smooth.sum()
    derivative = x * smooth
    derivative /= (derivative * x).sum()
    return smooth.astype(np.float32), derivative.astype(np.float32)


@cache
def contrast_kernels(sigma_px: float, exposure: float = 1.0) -> Kernels:
    """The same, scaled so that an ideal step answers with its height at reference exposure."""
    smooth, derivative = gaussian_kernels(sigma_px)
    return smooth, derivative * np.float32(np.sqrt(2.0 * np.pi) * sigma_px / exposure)


def noise_gain(kernels: Kernels) -> float:
    """Standard deviation of a derivative over that of the white noise of single pixels."""
    smooth, derivative = kernels
    return math.sqrt(float(smooth @ smooth) * float(derivative @ derivative))


def gaussian_gradient(image: Grey | Field, kernels: Kernels) -> tuple[Field, Field]:
    """Derivatives along x and y, float32 (H, W) each; outside, the image is as at its border."""
    smooth, derivative = kernels
    border = cv2.BORDER_REPLICATE
    along_x = cv2.sepFilter2D(image, cv2.CV_32F, derivative, smooth, borderType=border)
    along_y = cv2.sepFilter2D(image, cv2.CV_32F, smooth, derivative, borderType=border)
    return np.asarray(along_x, np.float32), np.asarray(along_y, np.float32)
