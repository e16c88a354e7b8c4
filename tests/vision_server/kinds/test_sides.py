"""What both sides of an edgel show: how sharp the edge is beside the slope between them."""

from __future__ import annotations

import cv2
import numpy as np

from vision_server.channels.channel import channel_statistics
from vision_server.edges.merging import merge_channels
from vision_server.kinds.sides import Sides, evenly_weighted, sides_of


def sharpness(profile: np.ndarray, seed: int = 0) -> np.ndarray:
    """Of the edgels in the middle of an image, (H, W), that goes across as ``profile`` (W,) does."""
    random = np.random.default_rng(seed)
    noise = random.normal(size=(2, 96, len(profile)))
    images = np.clip(np.array([1.0, 0.6])[:, None, None] * profile + noise, 0, 255).astype(np.uint8)
    channels = [channel_statistics(image, 1.0) for image in images]
    edges = merge_channels([evenly_weighted(channel) for channel in channels])
    found = sides_of(edges).sharpness
    assert found is not None
    middle = np.abs(edges.points[:, 0] - len(profile) / 2) < 4.0
    assert middle.any()
    return np.asarray(found[middle])


def ramp(width: float) -> np.ndarray:
    """From 40 to 200 within ``width`` px."""
    x = np.arange(96) - 47.5
    return np.asarray(40.0 + 160.0 * np.clip(x / width + 0.5, 0.0, 1.0))


def test_a_step_is_sharp_and_a_slope_is_not() -> None:
    step = cv2.GaussianBlur(ramp(1e-6)[None], (0, 0), 0.5).ravel()
    assert np.median(sharpness(step)) > 1.5
    assert 0.9 < np.median(sharpness(ramp(24.0))) < 1.2


def test_some_of_the_edgels_keep_their_sharpness_or_that_it_is_not_known() -> None:
    near, noise = np.ones((2, 2, 3), np.float32), np.ones((2, 3), np.float32)
    sides = Sides(near, near, noise, noise > 0.0, noise[0], sharpness=np.array([1.0, 2.0, 3.0], np.float32))
    np.testing.assert_array_equal(sides.of(np.array([2, 0])).sharpness, [3.0, 1.0])
    assert sides._replace(sharpness=None).of(slice(1)).sharpness is None
