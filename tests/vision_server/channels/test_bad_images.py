"""Images that hold no edges, or cannot be an image set, from the command line to the segments."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from bridge.errors import BadInput
from numerics.arrays import Grey
from tests.vision_server.edge_scenes import step
from vision_server.baselines import MERGE_RULES
from vision_server.baselines.merge_rules import comparison_edges
from vision_server.channels.channel import channel_statistics
from vision_server.channels.image_files import read_image_set
from vision_server.channels.noise import SATURATED_GREY
from vision_server.edges.merging import merge_channels
from vision_server.segments.extraction import extract_segments

NOTHING_TO_SEE = {
    "black": np.zeros((48, 64), np.uint8),
    "white": np.full((48, 64), 255, np.uint8),
    "one grey": np.full((48, 64), 93, np.uint8),
    "odd size": np.full((47, 63), 93, np.uint8),
    "three pixels": np.zeros((3, 3), np.uint8),
    "three columns": np.zeros((200, 3), np.uint8),
}


@pytest.mark.parametrize("image", NOTHING_TO_SEE.values(), ids=NOTHING_TO_SEE)
def test_where_there_is_nothing_nothing_is_found(image: Grey) -> None:
    for count in (1, 3):
        edges = merge_channels([channel_statistics(image)] * count)
        assert len(edges) == 0
        assert edges.ridge.shape == image.shape
        assert len(extract_segments(edges)) == 0
    for method in MERGE_RULES:
        assert not comparison_edges([image, image], method).ridge.any()


@pytest.mark.parametrize("shape", [(1, 1), (1, 100), (100, 1), (2, 100), (0, 0)])
def test_an_image_too_small_for_a_gradient_is_refused(shape: tuple[int, int]) -> None:
    with pytest.raises(BadInput, match="at least 3x3"):
        channel_statistics(np.zeros(shape, np.uint8))


def test_images_of_different_sizes_are_refused(tmp_path: Path) -> None:
    for name, shape in (("a.png", (40, 50)), ("b.png", (40, 51))):
        cv2.imwrite(str(tmp_path / name), np.zeros(shape, np.uint8))
    with pytest.raises(BadInput, match=r"b\.png"):
        read_image_set([tmp_path / "a.png", tmp_path / "b.png"])
    with pytest.raises(BadInput, match="51x40"):
        merge_channels([channel_statistics(np.zeros(shape, np.uint8)) for shape in ((40, 50), (40, 51))])


def test_sizes_that_are_odd_lose_no_edge() -> None:
    """Weight and noise are kept for 2 x 2 px; the last row and column of an odd size have no such square."""
    whole = step(0.4, 0.0, 60, 160)
    for rows, columns in ((95, 128), (96, 127), (95, 127)):
        part = merge_channels([channel_statistics(whole[:rows, :columns].copy())])
        x, y = part.points.T
        assert x.max() > columns - 16 or y.max() > rows - 4
        across = (part.points[part.strength > 50] - [63.5, 47.5]) @ [np.cos(0.4), np.sin(0.4)]
        assert np.abs(across).max() < 0.6


def test_a_saturated_area_has_no_edges_inside() -> None:
    rng = np.random.default_rng(0)
    image = np.clip(rng.normal(120, 30, (80, 100)), 0, 255).astype(np.uint8)
    image[20:60, 30:70] = 255
    channel = channel_statistics(image)
    assert not channel.contrast[24:56, 34:66].any()
    assert (channel.light.brightest[11:29, 16:34] >= SATURATED_GREY).all()
