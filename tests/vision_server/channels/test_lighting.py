"""Weight and noise of 2 x 2 px, against OpenCV's smoothing, erosion and dilation."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from vision_server.channels.lighting import light_rows

CLIPPED, FACTOR = 200, np.float32(0.25)


@pytest.mark.parametrize("reach", [1, 2, 7])
@pytest.mark.parametrize("shape", [(1, 1), (5, 3), (40, 61)])
def test_rows_are_those_of_opencv_in_whatever_parts(reach: int, shape: tuple[int, int]) -> None:
    random = np.random.default_rng(reach)
    half = random.integers(0, 256, shape).astype(np.uint8)
    root, noise_of = random.uniform(0.1, 3.0, (2, 256)).astype(np.float32)
    smooth = np.asarray(cv2.GaussianBlur(half, (3, 3), 0.5, borderType=cv2.BORDER_REPLICATE))
    window = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    darkest, brightest = cv2.erode(smooth, window), cv2.dilate(smooth, window)
    expected = root[darkest] * root[brightest] * np.where(brightest < CLIPPED, np.float32(1.0), FACTOR)
    for cut in (0, shape[0] // 2, shape[0]):
        level, clear = np.empty(shape, np.uint8), np.empty(shape, np.bool_)
        weight, noise = np.empty((2, *shape), np.float32)
        for first, end in ((0, cut), (cut, shape[0])):
            light_rows(half, reach, root, noise_of, CLIPPED, FACTOR, first, end, level, weight, noise, clear)
        np.testing.assert_array_equal(level, smooth)
        np.testing.assert_array_equal(clear, brightest < CLIPPED)
        np.testing.assert_array_equal(noise, noise_of[smooth])
        np.testing.assert_allclose(weight, expected, rtol=1e-6)
