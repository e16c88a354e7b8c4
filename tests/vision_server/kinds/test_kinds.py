"""Kinds of edges: each answers to the lights in its own way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bridge.errors import BadInput
from bridge.messages import Settings
from image_server.simulator.simulator import Simulator
from numerics.arrays import Floats
from tests.vision_server.edge_scenes import polygon_with_shadows, step
from tests.vision_server.level_samples import edgels_of
from vision_server.channels.channel import ChannelStatistics, channel_statistics
from vision_server.channels.depth import PER_GREY
from vision_server.edges.edge_map import EdgeMap
from vision_server.edges.merging import merge_channels
from vision_server.kinds.background import Background, background_of
from vision_server.kinds.densities import sum_of_logs
from vision_server.kinds.kinds import LEARNT, edge_kinds, fit_kinds, less_sure_shadows
from vision_server.kinds.kinds_table import kinds_picture, kinds_table
from vision_server.kinds.light_parts import known_lights
from vision_server.kinds.likelihoods import (
    CREASE,
    FIXED,
    HIGHLIGHT,
    KINDS,
    NOISE,
    OUTLINE,
    PRINT,
    SHADOW,
    likelihoods,
)
from vision_server.kinds.sides import REACH_PX, Sides, furthest_reach, sides_of

# Intensities on both sides in four lights, of which the last is dim.
LEFT = np.array([120.0, 90.0, 150.0, 60.0])
OF_KIND = {
    OUTLINE: (LEFT, [2.0, 1.0, 2.0, 2.0]),
    CREASE: (LEFT, [60.0, 110.0, 130.0, 30.0]),
    PRINT: (LEFT, 0.4 * LEFT),
    SHADOW: (LEFT, [120.0, 20.0, 150.0, 60.0]),
    HIGHLIGHT: (LEFT, [120.0, 90.0, 400.0, 60.0]),
    NOISE: (LEFT, LEFT + 1.0),
}


def sides(pairs: list[tuple[Floats, Floats]]) -> Sides:
    return edgels_of(np.array(pairs).transpose(2, 1, 0), 1.0)


def kinds_of(found: Sides) -> list[int]:
    return [int(kind) for kind in likelihoods(found, Background(1.0)).argmax(axis=0)]


@pytest.mark.parametrize("swapped", [False, True])
@pytest.mark.parametrize("kind", OF_KIND)
def test_each_kind_is_told_from_how_it_answers_to_the_lights(kind: int, swapped: bool) -> None:
    left, right = (np.asarray(side) for side in OF_KIND[kind])
    assert kinds_of(sides([(right, left) if swapped else (left, right)])) == [kind]


def test_what_a_steady_light_leaves_out_is_its_shadow() -> None:
    assert kinds_of(sides([(LEFT + 66.0, LEFT)])) == [SHADOW]


def test_a_dark_groove_is_no_background() -> None:
    outline = sides([(LEFT, np.full(4, 2.0))])
    groove = outline._replace(brightest=np.array([[LEFT, LEFT]], np.float32).transpose(2, 1, 0))
    assert kinds_of(outline) == [OUTLINE]
    assert kinds_of(groove) != [OUTLINE]


def test_a_clipped_or_black_channel_says_nothing() -> None:
    for kind, (left, right) in OF_KIND.items():
        good = sides([(np.asarray(left), np.asarray(right))])
        for grey, known in ((255.0, False), (0.0, True)):
            bad = sides([(np.r_[left, grey], np.r_[right, grey])])
            bad.known[-1] = known
            assert kinds_of(bad) == kinds_of(good) == [kind]


def test_the_logarithm_of_a_product_holds_any_number_of_channels() -> None:
    values = np.geomspace(1e-38, 1e38, 101, dtype=np.float32)[:, None] * np.ones(2, np.float32)
    for some in (values, values[:40], values[60:]):
        np.testing.assert_allclose(sum_of_logs(some), np.log(some.astype(np.float64)).sum(axis=0), atol=1e-4)


def test_the_sides_are_read_beside_the_edge_and_further_away() -> None:
    ramp = np.tile(np.arange(40, 200, 2, dtype=np.uint8), (60, 1))
    ridge, axis, offset = np.zeros((3, *ramp.shape), np.float32)
    ridge[30, [1, 40]] = 1.0  # across x; the first one's far sides are beyond the border
    offset[30, 40] = 0.25
    channel = channel_statistics(ramp, 2.0)
    found = sides_of(replace(EdgeMap.from_fields(ridge, axis, offset, 1.0), channels=(channel,), blur_px=0.0))
    near, far = REACH_PX[[0, -1]]
    at = np.array([1.0, 40.25])
    grey = [40.0 + 2.0 * np.clip(at + reach, 0.0, 79.0) for reach in (-near, near, far)]
    np.testing.assert_allclose(found.near[0], np.stack(grey[:2]) / 2.0, atol=1e-3)
    np.testing.assert_allclose(found.brightest[0], np.stack([grey[0], grey[2]]) / 2.0, atol=1e-3)
    assert found.known.all()


def test_of_blurred_images_the_sides_are_read_beside_the_blur() -> None:
    sharp = merge_channels(channels())
    reaches = [float(furthest_reach(replace(sharp, blur_px=blur))) for blur in (0.5, 1.25, 1.75, 2.5)]
    np.testing.assert_allclose(reaches, REACH_PX[-1] * np.array([1.0, 1.0, 1.4, 2.0]), rtol=1e-6)


def test_em_finds_how_frequent_the_kinds_are() -> None:
    random = np.random.default_rng(1)
    truth = random.choice(len(KINDS), 4000, p=[0.4, 0.3, 0.2, 0.1, 0.0, 0.0])
    likelihood = random.normal(0.0, 1.0, (len(KINDS), 4000))
    likelihood[truth, np.arange(4000)] += 4.0
    probability, share = fit_kinds(likelihood)
    np.testing.assert_allclose(probability.sum(axis=0), 1.0)
    np.testing.assert_allclose(share[:4], [0.4, 0.3, 0.2, 0.1], atol=0.03)
    assert share[4:].max() < 0.03


def channels(exposures: tuple[float, ...] = (1.0, 1.0, 1.0)) -> list[ChannelStatistics]:
    images = polygon_with_shadows(3)
    return [channel_statistics(image, exposure) for image, exposure in zip(images, exposures, strict=True)]


def test_shadows_are_not_among_the_fixed_edges() -> None:
    found = edge_kinds(channels())
    fixed, shadow = found.of_kinds(FIXED), found.of_kinds([SHADOW])
    likeliest = found.probability.argmax(axis=0)
    of_light = likeliest == SHADOW
    assert of_light.any()
    assert np.median(fixed.strength[of_light]) < 0.05 * np.median(shadow.strength[of_light])


def test_the_tables_columns_agree() -> None:
    found = edge_kinds(channels())
    table = kinds_table(found)
    count = len(found.edges)
    assert table["points"].shape == (count, 2)
    assert table["probability"].shape == (count, len(KINDS))
    assert table["step"].shape == table["significance"].shape == table["speaks"].shape == (count, 3)
    np.testing.assert_allclose(table["probability"].sum(axis=1), 1.0, atol=1e-3)
    assert np.all(table["place_sd_px"] > 0)
    picture = kinds_picture(found)
    assert picture.shape == (*found.edges.shape, 3)
    assert picture.any()


def test_the_place_is_as_sure_as_is_said() -> None:
    random = np.random.default_rng(2)
    clean = step(0.3, 0.25, 60, 140).astype(float)
    errors, said = [], []
    for _ in range(12):
        pair = [
            np.clip(clean * gain + random.normal(0.0, 4.0, clean.shape), 0, 255).round()
            for gain in (0.9, 1.2)
        ]
        found = edge_kinds([channel_statistics(image.astype(np.uint8)) for image in pair])
        strong = found.edges.mass > 0.5 * found.edges.mass.max()
        points = found.edges.points[strong] - 0.5 * (np.array(clean.shape[::-1]) - 1)
        errors.append(points @ np.array([np.cos(0.3), np.sin(0.3)]) - 0.25)
        said.append(kinds_table(found)["place_sd_px"][strong])
    assert 0.4 < np.std(np.concatenate(errors)) / np.mean(np.concatenate(said)) < 1.6


def test_one_light_tells_no_kinds() -> None:
    with pytest.raises(BadInput, match="kinds"):
        edge_kinds(channels()[:1])
    with pytest.raises(BadInput, match="kinds"):
        edge_kinds([*channels()[:1], *channels()[:1]])


def test_an_image_that_is_given_twice_counts_once() -> None:
    good = channels()
    found = edge_kinds([good[0], *good])
    assert found.used == (0, 2, 3)
    np.testing.assert_array_equal(found.probability, edge_kinds(good).probability)


def test_where_an_image_was_clipped_before_it_was_scaled_nothing_is_known() -> None:
    random = np.random.default_rng(0)
    bright = np.full((96, 128), 100.0)
    bright[:, 64:] = 330.0
    images = [np.clip(gain * bright + random.normal(0.0, 1.5, bright.shape), 0, 255) for gain in (0.5, 1.0)]
    scaled = [channel_statistics(np.round(0.9 * image).astype(np.uint8)) for image in images]
    edges = merge_channels(scaled)
    known = sides_of(edges).known[:, edges.mass > 0.5 * edges.mass.max()]
    assert known[0].all()
    assert not known[1].any()


def test_images_without_edges_have_none() -> None:
    even = channel_statistics(np.full((40, 50), 90, np.uint8))
    found = edge_kinds([even, replace(even)])
    assert len(found.edges) == found.probability.shape[1] == 0
    assert kinds_table(found)["points"].shape == (0, 2)


@pytest.mark.parametrize("grey", [0, 255], ids=["black", "white"])
def test_a_blank_image_among_good_ones_changes_nothing(grey: int) -> None:
    good = channels()
    blank = channel_statistics(np.full((120, 160), grey, np.uint8))
    with_it, without = edge_kinds([good[0], blank, *good[1:]]), edge_kinds(good)
    assert with_it.used == (0, 2, 3)
    np.testing.assert_array_equal(with_it.probability, without.probability)
    np.testing.assert_array_equal(with_it.of_kinds(FIXED).ridge, without.of_kinds(FIXED).ridge)
    np.testing.assert_array_equal(merge_channels([*good, blank]).ridge, merge_channels(good).ridge)
    assert len(merge_channels([blank])) == 0


def test_a_saturated_image_among_good_ones_tells_no_kinds() -> None:
    images = polygon_with_shadows(3)
    good = [channel_statistics(image) for image in images]
    bright = channel_statistics(np.clip(images[0].astype(int) * 6, 0, 255).astype(np.uint8))
    np.testing.assert_array_equal(edge_kinds([*good, bright]).probability, edge_kinds(good).probability)


def test_an_image_clipped_more_than_the_others_tells_no_kinds() -> None:
    good = channels()
    clipped = [_clipped_below(one, 0.7) for one in good]
    assert edge_kinds([*good, clipped[0]]).used == (0, 1, 2)
    assert edge_kinds(clipped).used == (0, 1, 2)


def _clipped_below(channel: ChannelStatistics, clear: float) -> ChannelStatistics:
    """As if a channel were clipped in the lower rows, where all but this share of its edges are."""
    level = channel.light.level.copy()
    row = np.quantile(channel.gradient.places // channel.shape[1], clear)
    level[int(row) // 2 :] = 255
    return replace(channel, light=channel.light._replace(level=level))


def test_edgels_are_judged_each_by_itself_however_many_there_are(monkeypatch: pytest.MonkeyPatch) -> None:
    some = sides([(np.asarray(left), np.asarray(right)) for left, right in OF_KIND.values()] * 3)
    for known in (None, known_lights(np.eye(4)[:, :3])):
        whole = likelihoods(some, Background(1.0), known)
        with monkeypatch.context() as patch:
            patch.setattr("vision_server.kinds.likelihoods.BLOCK", 4)
            np.testing.assert_allclose(likelihoods(some, Background(1.0), known), whole, rtol=1e-5, atol=1e-5)


def test_what_is_no_steeper_than_the_slope_between_its_sides_is_hardly_a_crease_or_a_print() -> None:
    some = sides([(np.asarray(left), np.asarray(right)) for left, right in OF_KIND.values()])
    sharp, even = (
        likelihoods(some._replace(sharpness=np.full(len(OF_KIND), value, np.float32)), Background(1.0))
        for value in (2.0, 1.0)
    )
    np.testing.assert_array_equal(sharp, likelihoods(some, Background(1.0)))
    changed = np.isin(np.arange(len(KINDS)), (CREASE, PRINT))
    assert (even[changed] < sharp[changed] - 1.0).all()
    np.testing.assert_array_equal(even[~changed], sharp[~changed])


def test_what_is_no_outline_is_told_less_surely_where_levels_are_unknown(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("vision_server.kinds.kinds.learnt_lights", lambda sides, before_wall: None)
    found = edge_kinds(channels())
    monkeypatch.setattr("vision_server.kinds.kinds.LESS_SURE", 1.0)
    surer = edge_kinds(channels())
    assert found.levels == surer.levels == "unknown"
    kinds = surer.probability.argmax(axis=0)
    same = (kinds != OUTLINE) & (found.probability.argmax(axis=0) == kinds)
    best, surest = (one.probability[:, same].max(axis=0) for one in (found, surer))
    assert same.sum() > 100
    assert np.median((1.0 - best) / (1.0 - surest)) > 1.5


def test_an_image_of_more_bits_is_read_as_one_of_eight_where_it_is_the_same() -> None:
    channels = [channel_statistics(image, gamma=2.2) for image in polygon_with_shadows(3)]
    eight = merge_channels(channels)
    for kind, per_grey in ((np.uint16, PER_GREY), (np.float32, 1)):
        alike = (replace(channel, pixels=kind(per_grey) * channel.image) for channel in channels)
        deep = replace(eight, channels=tuple(alike))
        for one, other in zip(sides_of(eight), sides_of(deep), strict=True):
            np.testing.assert_allclose(one, other, rtol=1e-5)
        dark = [background_of(edges, sides_of(edges)).dark for edges in (eight, deep)]
        assert dark[0] == pytest.approx(dark[1])


@pytest.mark.parametrize(("grey", "noise"), [(0.0, 0.0), (0.0, 1.0), (5.0, 2.0)])
def test_a_black_image_among_good_ones_changes_nothing(grey: float, noise: float) -> None:
    images = polygon_with_shadows(3)
    good = [channel_statistics(image) for image in images]
    black = np.random.default_rng(0).normal(grey, noise, images[0].shape)
    found = edge_kinds([*good, channel_statistics(np.abs(black).round().astype(np.uint8))])
    assert found.used == (0, 1, 2)
    np.testing.assert_array_equal(found.probability, edge_kinds(good).probability)


def test_an_outline_that_one_of_twelve_noisy_images_shows_is_found() -> None:
    """As in the dark of a tone curve: the mean of the contrasts is small, the mean's noise is smaller yet."""
    random, images = np.random.default_rng(0), []
    for number in range(12):
        image = np.full((80, 120), 25.0)
        image[20:60, 30:90] = 85.0 if number == 0 else 27.0
        image[35:45, 50:70] = 120.0 if number % 2 else 60.0  # so that every image tells something
        images.append(np.clip(image + random.normal(0.0, 4.0, image.shape), 0, 255).astype(np.uint8))
    edges = edge_kinds([channel_statistics(image) for image in images]).edges
    x, y = edges.points.T
    left, right = ((abs(x - at) < 1.5) & (y > 22) & (y < 58) for at in (29.5, 89.5))
    assert len(np.unique(np.rint(y[left]))) > 33
    assert len(np.unique(np.rint(y[right]))) > 33


def test_shadows_that_are_likely_have_the_root_of_their_odds_and_nothing_else_changes() -> None:
    probability = np.full((len(KINDS), 3), 0.01)
    probability[OUTLINE], probability[CREASE] = 0.1, [0.06, 0.6, 0.81]
    probability[SHADOW] = 1.0 - probability.sum(axis=0) + 0.01
    before = probability.copy()
    less_sure_shadows(probability)
    rest = 1.0 - before[OUTLINE] - before[SHADOW]
    odds = np.sqrt(before[SHADOW] / rest)
    np.testing.assert_allclose(probability.sum(axis=0), 1.0)
    np.testing.assert_allclose(probability[OUTLINE], before[OUTLINE])
    np.testing.assert_allclose(probability[SHADOW, 0], 0.9 * odds[0] / (1.0 + odds[0]))
    np.testing.assert_allclose(probability[CREASE, 0] / probability[PRINT, 0], 6.0)
    np.testing.assert_array_equal(probability[:, 1:], before[:, 1:])
    assert (probability.argmax(axis=0) == before.argmax(axis=0)).all()


def test_an_outline_stays_one_in_many_images_of_light_that_hardly_changes() -> None:
    """A print, and the end of a shadow of a light that is on in all of them, would show the same there."""
    light = 1.0 + 0.05 * np.cos(2.0 * np.pi * np.arange(30) / 10.0)
    found = sides([(120.0 * light, 1.0 * light)])
    assert kinds_of(found._replace(noise=0.5 * found.noise)) == [OUTLINE]


def test_colours_of_one_image_are_of_one_light() -> None:
    """A lamp in each image in the dark is learnt from three images, not from nine."""
    device, rng = Simulator("satellite", "eclipse", 4), np.random.default_rng(5)
    greys = [device.capture(Settings(lamp, 1 / 60, 4.0)).pixels for lamp in np.diag([7, 7, 7]).tolist()]
    colours = [
        np.clip(share * grey + rng.normal(0.0, 1.0, grey.shape), 0, 255).astype(np.uint8)
        for grey in greys
        for share in (0.7, 1.0, 0.9)
    ]
    of_grey = edge_kinds([channel_statistics(grey) for grey in greys])
    of_each = edge_kinds([channel_statistics(one) for one in colours], images=[0, 0, 0, 1, 1, 1, 2, 2, 2])
    assert of_grey.levels == of_each.levels == LEARNT
    for kind in (CREASE, SHADOW, HIGHLIGHT):
        as_grey, as_each = (int((one.probability.argmax(axis=0) == kind).sum()) for one in (of_grey, of_each))
        assert abs(as_each - as_grey) <= 0.25 * as_grey


def test_some_edgels_have_the_same_sides_by_their_numbers_and_by_a_slice() -> None:
    every = sides([(np.asarray(left), np.asarray(right)) for left, right in OF_KIND.values()])
    for one, other in zip(every.of(slice(1, None, 2)), every.of(np.arange(1, len(OF_KIND), 2)), strict=True):
        np.testing.assert_array_equal(one, other)
