"""Other ways to make one edge map of several images, kept for comparison with the mixture of `edges`.

All of them see linear intensity with the exposure divided out (Mertens: the images as they are, which is what
exposure fusion is for), use the same Gaussian derivative and the same non-maximum suppression.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from numerics.arrays import Field, Grey
from vision_server.baselines import MergeRule
from vision_server.channels.gaussian import contrast_kernels, gaussian_gradient, noise_gain
from vision_server.channels.noise import grey_noise
from vision_server.edges.edge_map import EdgeMap
from vision_server.edges.suppression import suppress_non_maxima

SIGMA_PX = 1.0  # of the Gaussian derivatives


def comparison_edges(
    images: Sequence[Grey],
    method: MergeRule,
    exposures: Sequence[float] | None = None,
    gamma: float = 1.0,
) -> EdgeMap:
    """Edge map of several images by one of the usual rules.

    Parameters
    ----------
    images
        uint8 grey, (H, W) each, one or more.
    method
        ``mean``: gradient of the mean image; ``max-image``: of the per-pixel maximum; ``max-gradient``: per
        pixel the largest of the gradients; ``di-zenzo``: root of the largest eigenvalue of the mean structure
        tensor (Di Zenzo 1986); ``mertens``: gradient of the exposure fusion
        (Mertens, Kautz & Van Reeth 2007).
    exposures
        Relative exposures, 1 each when left out.
    gamma
        Tone curve to undo.

    Returns
    -------
    EdgeMap. These rules know nothing of noise: ``floor`` is that of the noisiest image alone.
    """
    times = [1.0] * len(images) if exposures is None else exposures
    linear = [
        (255.0 * (image / 255.0) ** gamma / time).astype(np.float32)
        for image, time in zip(images, times, strict=True)
    ]
    floor = max(_noise(image, time) for image, time in zip(images, times, strict=True))
    if method == "di-zenzo":
        return _di_zenzo(linear, floor)
    gx, gy = _merged_gradient(images, linear, method)
    return _edge_map(np.hypot(gx, gy), np.arctan2(gy, gx), floor)


def _merged_gradient(images: Sequence[Grey], linear: Sequence[Field], method: MergeRule) -> Field:
    """Gradient along x and y, (2, H, W), by one of the rules that have one."""
    if method == "max-gradient":
        gradients = np.stack([_gradient(channel) for channel in linear])
        best = np.argmax(np.hypot(gradients[:, 0], gradients[:, 1]), axis=0)
        return np.asarray(np.take_along_axis(gradients, best[None, None], axis=0)[0])
    if method == "mertens":
        fused = cv2.createMergeMertens().process([cv2.cvtColor(i, cv2.COLOR_GRAY2BGR) for i in images])
        return _gradient(np.ascontiguousarray(fused[:, :, 0] * np.float32(255.0)))
    one = np.mean(linear, axis=0) if method == "mean" else np.max(linear, axis=0)
    return _gradient(one.astype(np.float32))


def _gradient(channel: Field) -> Field:
    """Gaussian derivatives along x and y, (2, H, W), scaled to the height of an ideal step."""
    return np.stack(gaussian_gradient(channel, contrast_kernels(SIGMA_PX)))


def _noise(image: Grey, exposure: float) -> float:
    """Standard deviation of one image's gradient at its middle grey."""
    gain = noise_gain(contrast_kernels(SIGMA_PX, exposure))
    return float(grey_noise(image)[int(np.median(image))] * gain)


def _di_zenzo(linear: Sequence[Field], floor: float) -> EdgeMap:
    """Strongest direction of the summed structure tensors."""
    gradients = np.stack([_gradient(channel) for channel in linear]).astype(np.float64)
    xx, yy = np.mean(gradients[:, 0] ** 2, axis=0), np.mean(gradients[:, 1] ** 2, axis=0)
    xy = np.mean(gradients[:, 0] * gradients[:, 1], axis=0)
    largest = 0.5 * (xx + yy + np.sqrt((xx - yy) ** 2 + 4.0 * xy**2))
    return _edge_map(np.sqrt(largest), 0.5 * np.arctan2(2.0 * xy, xx - yy), floor)


def _edge_map(magnitude: NDArray[np.floating], angle: NDArray[np.floating], floor: float) -> EdgeMap:
    """Suppression of non-maxima, and the fields that `edges` gives too."""
    strength, axis = magnitude.astype(np.float32), np.mod(angle, np.pi).astype(np.float32)
    ridge, offset = suppress_non_maxima(strength, axis)
    return EdgeMap.from_fields(ridge, axis, offset, floor)
