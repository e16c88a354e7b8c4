"""Short pieces of bent edges, judged together."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from vision_server.channels.channel import channel_statistics
from vision_server.edges.edge_map import EdgeMap
from vision_server.edges.merging import merge_channels
from vision_server.segments.curves import GAP_PX, LINK, SHORTEST_PX, chained_surprise
from vision_server.segments.extraction import extract_segments, extract_with_pieces


def edges_of(image: np.ndarray) -> EdgeMap:
    return merge_channels([channel_statistics(image)])


def discs(radius_px: float, noise: float = 2.0) -> np.ndarray:
    """Six dark discs on grey, blurred, with noise."""
    y, x = np.mgrid[:240, :320]
    image = np.full((240, 320), 140.0)
    for place in [(60, 60), (160, 70), (260, 55), (70, 170), (150, 180), (250, 165)]:
        image[np.hypot(x - place[0], y - place[1]) < radius_px] = 60.0
    image = cv2.GaussianBlur(image, (0, 0), 0.8)
    image += np.random.default_rng(3).normal(0.0, noise, image.shape)
    return np.clip(np.round(image), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("radius_px", [9.0, 12.0])
def test_small_holes_have_pieces_most_of_the_way_around(radius_px: float) -> None:
    edges = edges_of(discs(radius_px))
    around = 6 * 2.0 * np.pi * radius_px
    found = extract_with_pieces(edges)
    assert found.length.sum() > 0.7 * around
    assert extract_segments(edges).length.sum() < 0.35 * around
    assert found.length.min() >= SHORTEST_PX


def test_noise_alone_has_none() -> None:
    rng = np.random.default_rng(5)
    for _ in range(6):
        image = np.clip(np.round(120.0 + rng.normal(0.0, 12.0, (240, 320))), 0, 255).astype(np.uint8)
        assert len(extract_with_pieces(edges_of(image))) == 0


def test_pieces_that_meet_end_to_end_add_up_and_others_do_not() -> None:
    ends = np.array(
        [
            [0.0, 0.0, 5.0, 0.0],
            [10.0, 2.0, 5.5, 0.2],  # goes on from there, written the other way round
            [10.0, 2.0 + 2.0 * GAP_PX, 15.0, 5.0],  # too far from its end
            [5.0, 0.0, 5.0, 5.0],  # turns by a right angle
            [0.5, 0.0, -4.0, -1.0],  # goes on at the other end
        ]
    )
    surprise = np.array([10.0, 8.0, 6.0, 5.0, 4.0])
    together = 22.0 - 2.0 * LINK
    assert chained_surprise(ends, np.ones(5), surprise) == pytest.approx(
        [together, together, 6.0, 5.0, together]
    )
    faint = np.array([1.0, 4.0, 1.0, 1.0, 1.0])
    assert chained_surprise(ends, faint, surprise)[1] == 8.0
