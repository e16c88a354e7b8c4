"""What is dark and no background: shadows that are surrounded by what is lit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vision_server.channels.channel import channel_statistics
from vision_server.edges.background import background_grey, is_enclosed
from vision_server.edges.edge_map import EdgeMap
from vision_server.edges.likelihoods import OUTLINE, RARER_ENCLOSED, likelihoods
from vision_server.edges.merging import merge_channels
from vision_server.edges.sides import sides_of


def images(hole: int, around: int) -> list[NDArray[np.uint8]]:
    """A square of two brightnesses on a background; in it a dark one, in both images."""
    random = np.random.default_rng(0)
    out = []
    for bright in (150, 110):
        image = np.full((160, 200), around, np.float64)
        image[30:130, 40:160] = bright
        image[60:100, 80:120] = hole
        out.append(np.clip(image + random.normal(0.0, 1.0, image.shape), 0, 255).astype(np.uint8))
    return out


def merged(pair: list[NDArray[np.uint8]]) -> EdgeMap:
    return merge_channels([channel_statistics(image, 1.0) for image in pair])


def of_hole(edges: EdgeMap) -> NDArray[np.bool_]:
    x, y = edges.points.T
    return np.asarray((abs(x - 100) < 25) & (abs(y - 80) < 25))


def test_the_rim_of_a_dark_place_within_is_enclosed_and_the_outline_is_not() -> None:
    edges = merged(images(3, 3))
    found = is_enclosed(edges, sides_of(edges), background_grey(edges.channels))
    inner = of_hole(edges)
    assert inner.sum() > 100
    assert found[inner].all()
    x, y = edges.points.T
    outer = (x < 42) | (x > 158) | (y < 32) | (y > 128)
    assert outer.sum() > 300
    assert not found[outer].any()


def test_before_a_bright_background_nothing_is_enclosed() -> None:
    edges = merged(images(3, 220))
    assert not is_enclosed(edges, sides_of(edges), background_grey(edges.channels)).any()


def test_what_is_enclosed_is_less_likely_an_outline() -> None:
    edges = merged(images(9, 3))
    sides, inner = sides_of(edges), of_hole(edges)
    within, anywhere = (likelihoods(sides, 3.0, enclosed=enclosed) for enclosed in (inner, None))
    np.testing.assert_allclose((anywhere - within)[OUTLINE], RARER_ENCLOSED * inner, atol=1e-4)
    np.testing.assert_array_equal(np.delete(within, OUTLINE, 0), np.delete(anywhere, OUTLINE, 0))
