"""Images that are overexposed without anybody having said so."""

from __future__ import annotations

import numpy as np
import pytest

from numerics.arrays import Grey
from tests.vision_server.edge_scenes import polygon_with_shadows, square_outline
from vision_server.channels.channel import channel_statistics
from vision_server.channels.overexposure import overexposures
from vision_server.edges.merging import merge_channels


def overexposed(image: Grey, times: float) -> Grey:
    return np.asarray(np.clip(np.round(times * image.astype(np.float64)), 0, 255), dtype=np.uint8)


def outline_strength(images: list[Grey], exposures: list[float]) -> float:
    """What the outline of the square keeps of the merged magnitude, beside the strongest of what is left."""
    channels = [
        channel_statistics(image, exposure) for image, exposure in zip(images, exposures, strict=True)
    ]
    ridge, outline = merge_channels(channels).ridge, square_outline()
    kept = float(np.quantile(ridge[outline & (ridge > 0)], 0.2))
    return kept / max(float(np.quantile(ridge[~outline], 0.999)), 1.0)


def test_images_of_single_lights_and_of_all_are_as_they_should() -> None:
    single = polygon_with_shadows(3)
    together = np.asarray(np.mean(single, axis=0), dtype=np.uint8)
    assert overexposures([*single, together], [1.0] * 4) == [1.0] * 4
    assert overexposures(single[:1], [1.0]) == [1.0]


@pytest.mark.parametrize("times", [2.0, 4.0, 12.0])
def test_one_saturated_image_is_known_and_harms_no_outline(times: float) -> None:
    single = polygon_with_shadows(4)
    images = [*single[:3], overexposed(single[3], times)]
    found = overexposures(images, [1.0] * 4)
    assert found[:3] == [1.0] * 3
    assert 0.5 * min(times, 4.0) < found[3] <= 1.02 * times
    without = outline_strength(single[:3], [1.0] * 3)
    assert outline_strength(images, found) > 0.9 * without
    if times == 4.0:
        assert outline_strength(images, [1.0] * 4) < 0.5 * without


def test_an_image_that_lights_what_an_overexposed_one_leaves_dark_is_not_overexposed() -> None:
    left, right = np.full((2, 60, 60), 20, np.uint8)
    left[:, :30], right[:, 30:] = 80, 100
    assert overexposures([left, right, overexposed(left, 3.5)], [1.0] * 3)[1] == 1.0


def test_a_tone_curve_is_undone() -> None:
    single = polygon_with_shadows(4)
    images = [*single[:3], overexposed(single[3], 2.0)]
    (_, _, _, linear), (_, _, _, curved) = (overexposures(images, [gamma] * 4) for gamma in (1.0, 2.0))
    assert curved == pytest.approx(linear**2)


def test_black_and_white_images_among_others() -> None:
    single = polygon_with_shadows(3)
    black, white = np.zeros_like(single[0]), np.full_like(single[0], 255)
    found = overexposures([*single, black, white], [1.0] * 5)
    assert found[:4] == [1.0] * 4
    assert found[4] > 1.5
