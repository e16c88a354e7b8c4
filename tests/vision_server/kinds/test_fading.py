"""Contours that fade into a dark ground: of a ratio in the best light, where no image has a step."""

from __future__ import annotations

import numpy as np

from numerics.arrays import Flags, Grey
from vision_server.channels.channel import channel_statistics
from vision_server.channels.gaussian import contrast_kernels, gaussian_gradient
from vision_server.edges.edge_map import EdgeMap
from vision_server.edges.merging import merge_channels
from vision_server.edges.suppression import suppress_non_maxima
from vision_server.kinds.fading import LEAST_STEP, steps_into_the_dark, with_fading
from vision_server.kinds.kinds import EdgeKinds, edge_kinds
from vision_server.kinds.likelihoods import NOISE, OUTLINE

CONTOUR = 100.0  # column where the body ends


def images(noise: float, ends: float, enclosed: bool = False) -> list[Grey]:
    """A body in four images of unlike light, before black, shaded down to a grey at its contour."""
    random = np.random.default_rng(0)
    x = np.arange(160.0)
    out = []
    for bright in (200.0, 160.0, 140.0, 180.0):
        shading = ends + (bright - ends) * np.clip((CONTOUR - 3.0 - x) / 40.0, 0.0, 1.0)
        row = np.where(x < CONTOUR, shading, 1.0)
        image = np.tile(row, (120, 1))
        if enclosed:
            image[:8] = image[112:] = image[:, 130:] = 0.5 * bright
        image += random.normal(0.0, noise, image.shape)
        out.append(np.clip(np.round(image), 0, 255).astype(np.uint8))
    return out


def merged(some: list[Grey]) -> EdgeMap:
    return merge_channels([channel_statistics(image) for image in some])


def kinds(some: list[Grey]) -> EdgeKinds:
    return edge_kinds([channel_statistics(image) for image in some])


def at_contour(edges: EdgeMap) -> Flags:
    return np.asarray(abs(edges.points[:, 0] - (CONTOUR - 0.5)) < 2.0)


def rows_of(edges: EdgeMap, chosen: Flags) -> int:
    return len(np.unique(edges.places[chosen] // edges.shape[1]))


def test_where_shading_hardly_leaves_a_step_the_contour_has_edgels_all_the_same() -> None:
    some = images(1.5, 8.0)
    before, after = merged(some), kinds(some)
    assert rows_of(before, at_contour(before)) < 12
    found = at_contour(after.edges) & (after.probability[OUTLINE] > 0.9)
    assert rows_of(after.edges, found) > 85
    strength = after.of_kinds([OUTLINE]).strength[found]
    assert (strength > 3.0).mean() > 0.9
    beyond = after.edges.points[:, 0] > CONTOUR + 3.0
    assert not beyond.any()


def test_what_fades_and_does_not_meet_the_ground_is_noise() -> None:
    some = images(3.5, 9.0, enclosed=True)
    after = kinds(some)
    rim = at_contour(after.edges) & (after.edges.mass == 0.0)
    assert rim.sum() > 25
    assert (after.probability[NOISE][rim] == 1.0).all()


def test_the_steps_are_those_that_the_suppression_of_non_maxima_leaves() -> None:
    random = np.random.default_rng(2)
    logs = np.cumsum(random.normal(0.0, 0.3, (60, 80)), axis=1).astype(np.float32)
    along = gaussian_gradient(logs, contrast_kernels(1.0))
    places, offset = steps_into_the_dark(logs, *along, LEAST_STEP, np.float32(np.inf))
    ridge, defined = suppress_non_maxima(np.hypot(*along), np.mod(np.arctan2(along[1], along[0]), np.pi))
    np.testing.assert_array_equal(places, np.flatnonzero(ridge > LEAST_STEP))
    np.testing.assert_allclose(offset, defined.ravel()[places], atol=1e-4)
    dark = steps_into_the_dark(logs, *along, LEAST_STEP, np.float32(np.median(logs)))[0]
    assert 0 < len(dark) < len(places)
    assert set(dark.tolist()) < set(places.tolist())


def test_noise_in_the_dark_brings_none_and_the_others_stay() -> None:
    some = images(3.0, 60.0)
    before = merged(some)
    after = with_fading(before)
    assert (np.diff(after.places) > 0).all()
    new = np.isin(after.places, before.places, invert=True)
    assert new.sum() < 5
    np.testing.assert_array_equal(after.strength[~new], before.strength)
    np.testing.assert_array_equal(after.points[~new], before.points)


def test_what_is_added_lies_beside_no_edgel_and_each_in_a_row_of_its_own() -> None:
    before = merged(images(1.5, 8.0))
    after = with_fading(before)
    new = np.isin(after.places, before.places, invert=True)
    assert (after.mass == 0.0)[new].all()
    y, x = np.divmod(after.places[new], before.shape[1])
    for dy, dx in np.ndindex(3, 3):
        assert (before.index[y + dy - 1, x + dx - 1] < 0).all()
    at = at_contour(after)[new]
    assert at.sum() > 60
    assert len(np.unique(y[at])) == at.sum()


def test_images_of_odd_sizes_and_of_sixteen_bits_have_the_same() -> None:
    some = [image[:119, :159].astype(np.uint16) * 257 for image in images(1.5, 8.0)]
    after = with_fading(merge_channels([channel_statistics(image) for image in some]))
    assert rows_of(after, at_contour(after) & (after.mass == 0.0)) > 60
