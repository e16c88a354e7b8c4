"""Whether the images of a set show one scene."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.statues import Look, statue
from numerics.arrays import Grey
from tests.vision_server.edge_scenes import polygon_with_shadows
from vision_server.channels.channel import channel_statistics
from vision_server.edges.moved import FEWEST_EDGELS, SureEdgels, moved_since, sure_edgels


def edgels(image: Grey) -> SureEdgels:
    return sure_edgels(channel_statistics(image))


@pytest.fixture(scope="module")
def lit() -> list[Grey]:
    return [np.repeat(np.repeat(image, 2, axis=0), 2, axis=1) for image in polygon_with_shadows(4)]


def test_another_light_moves_nothing(lit: list[Grey]) -> None:
    seen = [edgels(image) for image in lit]
    assert len(seen[0].places) > FEWEST_EDGELS
    assert all(moved_since([before], after) is None for before in seen for after in seen)


@pytest.mark.parametrize("shift", [(6, -5), (-9, 14), (25, -20)])
def test_what_moved_is_said_and_where(lit: list[Grey], shift: tuple[int, int]) -> None:
    moved = np.roll(lit[1], (shift[1], shift[0]), axis=(0, 1))
    found = moved_since([edgels(lit[0])], edgels(moved))
    assert found is not None
    np.testing.assert_allclose(found.shift_px, shift, atol=5.0)
    left, top, right, bottom = found.box_px
    centre = 160 + shift[0], 120 + shift[1]
    # the square, 120 x 100 px, and its shadow beside it, up to 28 px away
    assert centre[0] - 90 < left < right < centre[0] + 90
    assert centre[1] - 80 < top < bottom < centre[1] + 80


def test_an_image_that_agrees_with_one_before_it_did_not_move(lit: list[Grey]) -> None:
    moved = edgels(np.roll(lit[1], (12, 12), axis=(0, 1)))
    still = edgels(lit[0])
    assert moved_since([still], moved) is not None
    assert moved_since([still, edgels(np.roll(lit[2], (12, 12), axis=(0, 1)))], moved) is None
    assert moved_since([], moved) is None


def test_nothing_to_see_is_no_movement() -> None:
    nothing = SureEdgels(np.zeros(0, np.int32), np.zeros(0, np.uint8), (240, 320), 1.0)
    assert moved_since([nothing], nothing) is None


def test_bands_that_blur_makes_of_edges_did_not_move(lit: list[Grey]) -> None:
    moved = edgels(np.roll(lit[1], (6, -5), axis=(0, 1)))
    assert moved_since([edgels(lit[0])], moved) is not None
    assert moved_since([edgels(lit[0])], moved._replace(blur_px=5.0)) is None


def test_opposite_low_lights_on_a_statue_move_nothing_and_a_statue_that_moved_is_seen() -> None:
    images = statue(1, Look(painted=True, elevation_deg=15.0)).images
    seen = [edgels(image) for image in images]
    opposite = [(first, (first + 6 + beside) % 12) for first in range(12) for beside in (-1, 0, 1)]
    assert [pair for pair in opposite if moved_since([seen[pair[0]]], seen[pair[1]])] == []
    shift = (14, -9)
    found = moved_since([seen[3]], edgels(np.roll(images[4], (shift[1], shift[0]), axis=(0, 1))))
    assert found is not None
    np.testing.assert_allclose(found.shift_px, shift, atol=5.0)
