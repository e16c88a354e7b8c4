"""What others do about exposure: several are fused into one image, or one is driven by its gradients."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from numerics.arrays import Field, Grey

# Shim, Lee & Kweon (2014), Auto-adjusting camera exposure for outdoor robotics using gradient information:
# tone curves that stand for other exposures, and what a gradient counts.
GAMMAS = 1 / 1.9, 1 / 1.5, 1 / 1.2, 1.0, 1.2, 1.5, 1.9
LEAST_GRADIENT, GRADIENT_GROWTH = 0.06, 1000.0
POLYNOMIAL = 5


def exposure_fusion(images: Sequence[Grey]) -> Grey:
    """Images of one scene (H, W) fused into one by contrast and exposedness (Mertens et al. 2007)."""
    fused = cv2.createMergeMertens().process([cv2.cvtColor(image, cv2.COLOR_GRAY2BGR) for image in images])
    return np.asarray(np.clip(np.rint(255.0 * fused[:, :, 0]), 0, 255), dtype=np.uint8)


def gradient_information(image: Field) -> float:
    """Sum of what the gradients of an image (H, W), 0..1, count: their logarithm above a least one."""
    across, down = (cv2.Sobel(image, cv2.CV_32F, dx, dy, scale=0.25) for dx, dy in ((1, 0), (0, 1)))
    strong = np.maximum(np.hypot(across, down) - LEAST_GRADIENT, 0.0)
    return float(np.log1p(GRADIENT_GROWTH * strong).sum())


def richest_gamma(image: Grey) -> float:
    """The tone curve under which an image (H, W) tells most by its gradients: below 1 it wants more light."""
    share = image.astype(np.float32) / np.float32(255.0)
    told = np.array([gradient_information(share**gamma) for gamma in GAMMAS])
    if not told.any():
        return GAMMAS[0] if image.mean() < 128.0 else GAMMAS[-1]
    fine = np.linspace(GAMMAS[0], GAMMAS[-1], 200)
    return float(fine[np.argmax(np.polyval(np.polyfit(GAMMAS, told, POLYNOMIAL), fine))])
