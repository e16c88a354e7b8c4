"""Non-maximum suppression and hysteresis."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from skimage.filters import apply_hysteresis_threshold

from numerics.arrays import Field, Flags
from vision_server.edges.edge_map import EdgeMap
from vision_server.edges.suppression import hysteresis, suppress_non_maxima


def kept_pixels(ridge: Field, low: float | Field, high: float | Field) -> Flags:
    """Hysteresis of a ridge image, as an image; thresholds may be images too."""
    edges = EdgeMap.from_fields(ridge, np.zeros_like(ridge), np.zeros_like(ridge), 0.0)
    limits = [t if isinstance(t, float) else t.ravel()[edges.places] for t in (low, high)]
    return edges.field(hysteresis(edges, *limits).astype(np.float32)) > 0


@pytest.mark.parametrize("angle", [0.0, 0.3, 0.785, 1.2, 1.571, 2.2, 2.9])
@pytest.mark.parametrize("shift", [-0.4, 0.0, 0.3])
def test_a_ridge_is_thinned_to_its_crest(angle: float, shift: float) -> None:
    y, x = np.mgrid[:61, :61].astype(np.float32)
    across = (x - 30) * np.cos(angle) + (y - 30) * np.sin(angle) - shift
    magnitude = np.exp(-0.5 * (across / 1.5) ** 2).astype(np.float32)
    ridge, offset = suppress_non_maxima(magnitude, np.full((61, 61), angle, np.float32))
    on = (ridge > 0.1) & (abs(x - 30) < 25) & (abs(y - 30) < 25)
    assert np.abs(across[on]).max() <= 0.75
    assert np.abs(across[on] + offset[on]).max() < 0.07
    rows_or_columns = 51  # a diagonal ridge crosses the cells of two pixels in each
    assert 0.9 * rows_or_columns <= on.sum() <= 2.05 * rows_or_columns


def test_hysteresis_agrees_with_skimage() -> None:
    ridge = np.random.default_rng(0).random((80, 90)).astype(np.float32)
    ridge[ridge < 0.5] = 0.0
    ridge = np.repeat(np.repeat(ridge, 2, axis=0), 2, axis=1)
    # skimage joins pixels through their sides only: fill the corners through which ours joins more
    weak = ridge > 0.8
    weak[:-1, :-1] |= weak[1:, :-1] & weak[:-1, 1:]
    weak[:-1, :-1] |= weak[1:, 1:] & weak[1:, :-1]
    filled = np.where(weak, np.maximum(ridge, 0.81), 0.0).astype(np.float32)
    theirs = apply_hysteresis_threshold(filled, 0.8, 0.98)  # type: ignore[no-untyped-call]
    ours = kept_pixels(filled, 0.8, 0.98)
    assert np.all(ours[theirs])
    assert 0 < theirs.sum() <= ours.sum() <= weak.sum()


def test_hysteresis_follows_diagonals_and_drops_weak_pieces() -> None:
    ridge = np.zeros((10, 12), np.float32)
    for k in range(5):
        ridge[k, k] = 3.0
    ridge[4, 4] = 9.0
    ridge[8, 8:11] = 3.0
    kept = kept_pixels(ridge, 2.0, 5.0)
    assert kept.sum() == 5
    assert not kept[8].any()
    assert not kept_pixels(np.zeros((5, 5), np.float32), 1.0, 2.0).any()


@pytest.mark.parametrize("columns", [1, 2, 40])
def test_hysteresis_keeps_the_connected_components_that_hold_something_strong(columns: int) -> None:
    random = np.random.default_rng(columns)
    for share in (0.2, 0.4, 0.7):
        ridge = np.where(random.random((50, columns)) < share, random.random((50, columns)), 0.0)
        ridge = ridge.astype(np.float32)
        labels = np.asarray(cv2.connectedComponents((ridge > 0.3).astype(np.uint8), connectivity=8)[1])
        expected = (ridge > 0.3) & np.isin(labels, labels[ridge > 0.9])
        np.testing.assert_array_equal(kept_pixels(ridge, 0.3, 0.9), expected)


def test_thresholds_may_differ_from_pixel_to_pixel() -> None:
    ridge = np.full((4, 6), 3.0, np.float32)
    low = np.full((4, 6), 2.0, np.float32)
    high = np.full((4, 6), 9.0, np.float32)
    high[0, 0] = 2.5
    low[:, 3] = 4.0
    assert kept_pixels(ridge, low, high).sum() == 12
