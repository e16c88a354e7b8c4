"""What is behind and which edges adjoin it; what is dark and enclosed by what is lit is none."""

from __future__ import annotations

import numpy as np

from numerics.arrays import Flags, Grey
from vision_server.channels.channel import channel_statistics
from vision_server.edges.edge_map import EdgeMap
from vision_server.edges.merging import merge_channels
from vision_server.kinds.background import Background, background_of, brightest_cells
from vision_server.kinds.ground import BOTH, NEITHER, ONE
from vision_server.kinds.kinds import edge_kinds
from vision_server.kinds.likelihoods import CREASE, OUTLINE, RARER_ENCLOSED, SHADOW, likelihoods
from vision_server.kinds.sides import sides_of


def images(hole: int, around: int) -> list[Grey]:
    """A square of two brightnesses on a background; in it a dark one, in both images."""
    random = np.random.default_rng(0)
    out = []
    for bright in (150, 110):
        image = np.full((160, 200), around, np.float64)
        image[30:130, 40:160] = bright
        image[60:100, 80:120] = hole
        out.append(np.clip(image + random.normal(0.0, 1.0, image.shape), 0, 255).astype(np.uint8))
    return out


def merged(pair: list[Grey]) -> EdgeMap:
    return merge_channels([channel_statistics(image, 1.0) for image in pair])


def of_hole(edges: EdgeMap) -> Flags:
    x, y = edges.points.T
    return np.asarray((abs(x - 100) < 25) & (abs(y - 80) < 25))


def met_in(edges: EdgeMap) -> Grey:
    found = background_of(edges, sides_of(edges)).met
    assert found is not None
    return found


def of_outline(edges: EdgeMap) -> Flags:
    x, y = edges.points.T
    return np.asarray((x < 42) | (x > 158) | (y < 32) | (y > 128))


def test_the_best_light_of_a_cell_is_the_largest_mean_of_its_two_pixels_on_the_diagonal() -> None:
    one, other = (image[:159] for image in images(3, 90))
    sixteen_bits = (other.astype(np.uint16) * 257).astype(np.uint16)
    channels = [channel_statistics(one, 2.0, 2.2), channel_statistics(sixteen_bits, 1.5)]
    means = [
        (channel.linear[:158:2, ::2] + channel.linear[1:158:2, 1::2]) * np.float32(0.5 / channel.exposure)
        for channel in channels
    ]
    np.testing.assert_array_equal(brightest_cells(channels), np.maximum(*means))


def test_the_rim_of_a_dark_place_within_meets_no_ground_and_one_side_of_the_outline_does() -> None:
    edges = merged(images(3, 3))
    found, inner, outer = met_in(edges), of_hole(edges), of_outline(edges)
    assert inner.sum() > 100
    assert outer.sum() > 300
    assert (found[inner] == NEITHER).all()
    assert (found[outer] == ONE).mean() > 0.97  # at corners both may


def test_before_a_wall_with_a_dark_place_within_it_is_the_same() -> None:
    edges = merged(images(3, 220))
    found, inner, outer = met_in(edges), of_hole(edges), of_outline(edges)
    assert (found[inner] == NEITHER).all()
    assert (found[outer] == ONE).mean() > 0.97


def test_where_most_of_what_is_dark_is_enclosed_nothing_is_said() -> None:
    """What is behind is printed, and no wall."""
    printed = np.kron(np.random.default_rng(1).integers(60, 230, (20, 25)), np.ones((8, 8))).astype(np.uint8)
    pair = images(3, 220)
    for image in pair:
        around = np.ones(image.shape, np.bool_)
        around[30:130, 40:160] = False
        image[around] = printed[around]
    edges = merged(pair)
    assert background_of(edges, sides_of(edges)).wall is None
    assert (met_in(edges) == BOTH).all()


def test_the_table_is_ground_that_is_too_dim_for_a_wall() -> None:
    """The table is lit and none of the dark background, but it goes on to the border as that does."""
    pair = images(3, 3)
    for number, image in enumerate(pair):
        image[90:][image[90:] < 8] += np.uint8(10 + 3 * number)
    edges = merged(pair)
    found, y = met_in(edges), edges.points[:, 1]
    before_table = of_outline(edges) & (y > 95)
    assert before_table.sum() > 100
    assert (found[before_table] == ONE).mean() > 0.95
    assert (found[of_hole(edges) & (y < 85)] == NEITHER).all()


def test_the_ground_is_met_in_a_gap_that_is_narrower_than_sides_are_looked_at() -> None:
    pair = images(150, 3)
    for image in pair:
        image[20:140, 97:103] = 3
    edges = merged(pair)
    x, y = edges.points.T
    beside_gap = (abs(x - 99.5) < 4) & (abs(y - 80) < 40)
    assert beside_gap.sum() > 100
    assert (met_in(edges)[beside_gap] == ONE).mean() > 0.97


def test_an_edge_behind_another_one_does_not_meet_the_ground() -> None:
    pair = images(150, 3)
    for image in pair:
        image[30:130, 40:46] = 70
    edges = merged(pair)
    found, (x, y) = met_in(edges), edges.points.T
    outer, behind = ((abs(x - at) < 1.5) & (abs(y - 80) < 40) for at in (39.5, 45.5))
    assert behind.sum() > 50
    assert (found[behind] == NEITHER).all()
    assert (found[outer] == ONE).mean() > 0.97


def test_each_pair_of_images_makes_an_outline_of_what_meets_no_ground_less_likely() -> None:
    edges = merged([*images(9, 3), images(8, 3)[0]])
    sides, inner = sides_of(edges), of_hole(edges)
    met = np.where(inner, NEITHER, BOTH).astype(np.uint8)
    within, anywhere = (likelihoods(sides, Background(3.0, seen)) for seen in (met, None))
    np.testing.assert_allclose((anywhere - within)[OUTLINE], 3 * RARER_ENCLOSED * inner, atol=1e-4)
    np.testing.assert_array_equal(np.delete(within, OUTLINE, 0), np.delete(anywhere, OUTLINE, 0))


def test_what_stands_on_a_dim_table_has_an_outline_though_it_answers_lights_as_a_crease_does() -> None:
    random, images = np.random.default_rng(0), []
    for statue, table in ((60, 24), (150, 16), (35, 26), (110, 14)):
        image = np.full((160, 200), 2.0)
        image[60:] = table
        image[30:130, 70:150] = statue
        images.append(np.clip(image + random.normal(0.0, 1.0, image.shape), 0, 255).astype(np.uint8))
    found = edge_kinds([channel_statistics(image) for image in images])
    kind, (x, y) = found.probability.argmax(axis=0), found.edges.points.T
    before_table = (abs(y - 95) < 25) & (np.minimum(abs(x - 69.5), abs(x - 149.5)) < 1.5)
    assert before_table.sum() > 50
    assert (kind[before_table] == OUTLINE).mean() > 0.9


def before_a_wall() -> list[Grey]:
    """A square in four lights, now darker and now brighter than the wall, on which its shadow falls."""
    random, images = np.random.default_rng(0), []
    y, x = np.mgrid[:160, :200]
    for number, grey in enumerate((30, 150, 60, 110)):
        image = 80.0 + 0.1 * x * (number - 1.5) + 0.0005 * (y - 80.0) ** 2  # of a lamp that is near
        shift = 24 * (number % 2) - 12
        image[50:110, 70 + shift : 150 + shift] = 15.0
        image[50:110, 70:150] = grey
        noisy = image + random.normal(0.0, 1.0, image.shape)
        images.append(np.clip(noisy, 0, 255).astype(np.uint8))
    return images


def test_a_lit_wall_is_told_from_the_border_of_the_images() -> None:
    edges = merged(before_a_wall())
    wall = background_of(edges, sides_of(edges)).wall
    assert wall is not None
    x, y = edges.points.T
    np.testing.assert_allclose(wall[3], 80.0 + 0.15 * x + 0.0005 * (y - 80.0) ** 2, rtol=0.03)
    dark = merged(images(9, 3))
    assert background_of(dark, sides_of(dark)).wall is None


def test_a_wall_is_found_where_a_shadow_covers_much_of_the_dim_end_of_the_border() -> None:
    y, x = np.mgrid[:160, :200]
    lit = 200.0 * np.exp(-x / 85.0)  # of a lamp that is near
    image = np.where((x > 116) & (y > 20), 0.03 * lit, lit)
    image += np.random.default_rng(0).normal(0.0, 1.0, image.shape)
    edges = merged([np.clip(image, 0, 255).astype(np.uint8)] * 2)
    wall = background_of(edges, sides_of(edges)).wall
    assert wall is not None
    x, y = edges.points.astype(np.int64).T
    assert np.median(np.abs(wall[0] / lit[y, x] - 1.0)) < 0.1


def test_what_is_before_a_lit_wall_has_an_outline_and_what_is_on_it_has_none() -> None:
    found = edge_kinds([channel_statistics(image) for image in before_a_wall()])
    kind, (x, y) = found.probability.argmax(axis=0), found.edges.points.T
    beside = (abs(y - 80) < 20) & (np.minimum(abs(x - 69.5), abs(x - 149.5)) < 1.5)
    assert beside.sum() > 50
    assert (kind[beside] == OUTLINE).mean() > 0.9
    on_wall = (abs(y - 80) < 20) & (np.minimum(abs(x - 57.5), abs(x - 161.5)) < 1.5)
    assert on_wall.sum() > 50
    assert not np.isin(kind[on_wall], (OUTLINE, CREASE)).any()
    assert (kind[on_wall] == SHADOW).mean() > 0.9


def test_a_dark_thing_on_an_overexposed_wall_has_an_outline() -> None:
    random, images = np.random.default_rng(0), []
    for number in range(8):
        image = np.full((160, 200), 300.0 if number % 4 else 150.0)  # clipped in three lights of four
        image[50:110, 70:150] *= 0.5
        images.append(np.clip(image + random.normal(0.0, 1.0, image.shape), 0, 255).astype(np.uint8))
    found = edge_kinds([channel_statistics(image) for image in images])
    assert (found.probability.argmax(axis=0) == OUTLINE).mean() > 0.9
