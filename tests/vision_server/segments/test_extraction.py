"""Segments of whole images."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from tests.vision_server.edge_scenes import polygon_with_shadows, step
from vision_server.baselines.splitting import split_segments
from vision_server.channels.channel import channel_statistics
from vision_server.edges.edge_map import EdgeMap
from vision_server.edges.merging import merge_channels
from vision_server.segments.extraction import MIN_LENGTH_PX, extract_segments
from vision_server.segments.line_fit import Segments

Extract = Callable[[EdgeMap], Segments]
BOTH = pytest.mark.parametrize("extract", [extract_segments, split_segments])


def segments_of(*images: np.ndarray, extract: Extract = extract_segments) -> Segments:
    return extract(merge_channels([channel_statistics(i) for i in images]))


def error_to_line(segments: Segments, index: int, angle: float, shift: float) -> tuple[float, float]:
    """Largest distance of the ends from the step's line, px, and the angle to it, deg."""
    x0, y0, x1, y1 = segments.endpoints[index]
    normal = np.array([np.cos(angle), np.sin(angle)])
    ends = np.array([[x0 - 63.5, y0 - 47.5], [x1 - 63.5, y1 - 47.5]]) @ normal - shift
    turn = (np.arctan2(y1 - y0, x1 - x0) - angle - np.pi / 2 + np.pi / 2) % np.pi - np.pi / 2
    return float(np.abs(ends).max()), float(np.rad2deg(abs(turn)))


@BOTH
@pytest.mark.parametrize("angle", [0.0, 0.4, 0.9, 1.571, 2.3, 2.8])
def test_a_step_is_one_segment_in_its_place(angle: float, extract: Extract) -> None:
    segments = segments_of(step(angle, 0.3, 50, 150, noise=2.0), extract=extract)
    assert segments.length[0] > 70
    distance, turn = error_to_line(segments, 0, angle, 0.3)
    assert distance < 0.3
    assert turn < 0.3


@pytest.mark.parametrize("blur_px", [2.0, 3.0, 4.0])
def test_blur_does_not_move_a_segment(blur_px: float) -> None:
    segments = segments_of(step(0.5, 0.0, 40, 160, blur_px=blur_px, noise=1.0))
    distance, turn = error_to_line(segments, 0, 0.5, 0.0)
    assert distance < 0.6
    assert turn < 0.6


def test_different_light_on_the_two_sides_does_not_move_a_segment() -> None:
    images = [step(0.5, 0.0, 30, 160, blur_px=3.0), step(0.5, 0.0, 120, 40, blur_px=3.0, seed=1)]
    distance, turn = error_to_line(segments_of(*images), 0, 0.5, 0.0)
    assert distance < 0.7
    assert turn < 0.6


def test_a_square_has_four_sides_and_its_shadows_none() -> None:
    segments = segments_of(*polygon_with_shadows(4))
    long = segments.take(segments.length > 30)
    assert len(long) == 4
    assert sorted(np.round(long.length / 10).astype(int)) == [5, 5, 6, 6]


def test_texture_beside_an_outline_does_not_break_it() -> None:
    texture = gaussian_filter(np.random.default_rng(0).normal(0, 1, (96, 128)), 1.2)
    image = step(0.2, 0.0, 40, 150).astype(float)
    image += np.where(image > 100, 100 * texture, 0)
    grown = segments_of(np.clip(image, 0, 255).astype(np.uint8))
    split = segments_of(np.clip(image, 0, 255).astype(np.uint8), extract=split_segments)
    assert grown.length.max() > 75
    assert grown.length.max() >= split.length.max() - 1.0


def test_pure_noise_has_hardly_any_segments() -> None:
    image = np.random.default_rng(1).normal(120, 20, (240, 320))
    assert len(segments_of(np.clip(image, 0, 255).astype(np.uint8))) <= 2


def test_limits_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(0)
    image = np.kron(rng.integers(40, 220, (15, 20)), np.ones((16, 16))).astype(np.uint8)
    edges = merge_channels([channel_statistics(image)])
    weakest = extract_segments(edges).strength.min()
    monkeypatch.setattr("vision_server.segments.extraction.MAX_SEGMENTS", 25)
    segments = extract_segments(edges)
    assert len(segments) == 25
    assert segments.length.min() >= MIN_LENGTH_PX
    merit = segments.length * segments.strength
    assert np.all(np.diff(merit) <= 1e-9)
    assert merit[-1] >= weakest


@pytest.mark.parametrize(
    "image",
    [
        np.zeros((50, 60), np.uint8),
        np.full((50, 60), 255, np.uint8),
        np.full((3, 3), 9, np.uint8),
        np.zeros((400, 3), np.uint8),
    ],
)
@BOTH
def test_empty_images_have_no_segments(image: np.ndarray, extract: Extract) -> None:
    segments = segments_of(image, extract=extract)
    assert len(segments) == 0
    assert segments.endpoints.shape == (0, 4)
    assert segments.normal_sd.shape == (0, 2)


def test_segments_do_not_depend_on_chance() -> None:
    images = polygon_with_shadows(3)
    a, b = segments_of(*images), segments_of(*images)
    np.testing.assert_array_equal(a.endpoints, b.endpoints)


def test_edge_maps_keep_their_promise_of_types() -> None:
    edges = merge_channels([channel_statistics(polygon_with_shadows(1)[0])])
    assert isinstance(edges, EdgeMap)
    for name in ("strength", "mass", "axis", "offset", "floor", "ridge", "points", "normals"):
        assert getattr(edges, name).dtype == np.float32
    assert edges.places.dtype == np.int32
    assert np.all(np.diff(edges.places) > 0)
