"""The mixture over channels."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt, gaussian_filter

from bridge.errors import BadInput
from numerics.arrays import Flags, Floats
from tests.vision_server.edge_scenes import polygon_with_shadows, square_outline, step
from vision_server.channels.channel import ChannelStatistics, channel_statistics
from vision_server.channels.lighting import WEIGHT_EXPONENT
from vision_server.edges.edge_map import EdgeMap
from vision_server.edges.merging import ImageSetStatistics, merge_channels, merged_at
from vision_server.edges.mixture import axial_difference
from vision_server.edges.suppression import suppress_non_maxima


def clutter(count: int) -> list[ChannelStatistics]:
    channels = []
    for seed in range(count):
        values = gaussian_filter(np.random.default_rng(seed).normal(0, 1, (80, 100)), 1.5)
        channels.append(channel_statistics(np.clip(110 + 250 * values, 0, 255).astype(np.uint8)))
    return channels


def same(a: EdgeMap, b: EdgeMap) -> bool:
    fields = ("places", "strength", "mass", "axis", "offset", "floor")
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in fields)


@pytest.mark.parametrize("scene", ["shadows", "clutter"])
def test_the_merge_is_its_definition(scene: str) -> None:
    if scene == "shadows":
        channels = [channel_statistics(image) for image in polygon_with_shadows(4, noise=3.0)]
    else:
        channels = clutter(4)
    edges = merge_channels(channels)
    shares, turns = [], []
    for at in range(0, len(edges), 3):
        y, x = divmod(int(edges.places[at]), edges.shape[1])
        strength, mass, axis = merged_at(channels, y, x)
        assert edges.mass[at] == pytest.approx(mass, rel=1e-4)
        shares.append((strength - edges.strength[at]) / mass)
        turns.append(float(axial_difference(axis, float(edges.axis[at]))))
    assert len(shares) > 30
    assert np.quantile(np.abs(shares), 0.95) < 0.03
    assert np.quantile(turns, 0.95) < np.deg2rad(2.5)


def test_ridges_of_one_channel_are_those_of_suppression() -> None:
    channel = clutter(1)[0]
    edges = merge_channels([channel])
    image = EdgeMap.from_fields(edges.ridge, edges.field(edges.axis), edges.field(edges.offset), 0.0)
    ridge, offset = suppress_non_maxima(channel.contrast, channel.orientation)
    theirs = np.flatnonzero(ridge)
    strong = image.places[image.strength > 0.5 * image.strength.max()]
    assert len(strong) > 100
    assert np.mean(np.isin(strong, theirs)) > 0.9
    both = np.intersect1d(strong, theirs)
    turned = axial_difference(edges.field(edges.axis).ravel()[both], channel.orientation.ravel()[both])
    alike = both[turned < 0.1]
    difference = edges.field(edges.offset).ravel()[alike] - offset.ravel()[alike]
    assert np.median(np.abs(difference)) < 0.06


def strongest_shadow(weight_exponent: float) -> float:
    """Strongest shadow edge over the weakest tenth of the true outline."""
    images = polygon_with_shadows(4)
    ridge = merge_channels([channel_statistics(i, weight_exponent=weight_exponent) for i in images]).ridge
    distance = distance_transform_edt(~square_outline())
    true, shadow = ridge[(ridge > 0) & (distance <= 1)], ridge[(ridge > 0) & (distance > 3)]
    return float(shadow.max(initial=0.0) / np.quantile(true, 0.1))


def test_shadow_edges_rank_far_below_true_edges() -> None:
    assert strongest_shadow(WEIGHT_EXPONENT) < 0.1


def test_it_is_the_weight_that_puts_them_there() -> None:
    assert strongest_shadow(0.0) > 0.2


def inner_edgels(edges: EdgeMap, share: float) -> Flags:
    """Edgels well inside the image that are stronger than a share of the strongest."""
    x, y = edges.points.T
    inner = (y > 10) & (y < 85) & (x > 10) & (x < 117)
    return np.asarray(inner & (edges.strength > share * edges.strength.max()))


def across(edges: EdgeMap, chosen: Flags, angle: float) -> Floats:
    """Distance of edgels from the line through the middle of the image with this normal, px."""
    return np.asarray((edges.points[chosen] - [63.5, 47.5]) @ [np.cos(angle), np.sin(angle)])


def test_a_clean_edge_belongs_to_the_main_component() -> None:
    for angle in (0.0, 0.5, 1.2, 2.0, 2.9):
        images = [step(angle, 0.2, 50, high) for high in (150, 200)]
        edges = merge_channels([channel_statistics(image) for image in images])
        strong = inner_edgels(edges, 0.9)
        assert strong.sum() > 30
        assert np.median(edges.strength[strong] / edges.mass[strong]) > 0.95
        assert np.median(axial_difference(edges.axis[strong].astype(np.float64), angle)) < np.deg2rad(1.5)
        assert np.median(across(edges, strong, angle)) == pytest.approx(0.2, abs=0.08)


def test_reversed_contrast_is_the_same_edge() -> None:
    images = [step(0.7, 0.0, 60, 160), step(0.7, 0.0, 160, 60)]
    edges = merge_channels([channel_statistics(image) for image in images])
    alone = merge_channels([channel_statistics(images[0])])
    assert edges.ridge.max() == pytest.approx(alone.ridge.max(), rel=0.05)


def test_light_from_two_sides_does_not_move_an_edge() -> None:
    """A crease: either side is the bright one in some channel."""
    for angle in (0.0, 0.5, 1.3, 2.2):
        images = [step(angle, 0.2, low, high, noise=0.5) for low, high in ((20, 190), (130, 110), (160, 30))]
        edges = merge_channels([channel_statistics(image) for image in images])
        strong = inner_edgels(edges, 0.5)
        assert strong.sum() > 60
        assert np.median(across(edges, strong, angle)) == pytest.approx(0.2, abs=0.08)


def test_removing_a_channel_is_exact() -> None:
    channels = [channel_statistics(image) for image in polygon_with_shadows(4)]
    image_set = ImageSetStatistics()
    for number in (0, 3, 1):
        image_set.add(f"i{number}", channels[number])
    image_set.remove("i3")
    assert same(image_set.merge(), merge_channels([channels[0], channels[1]]))
    image_set.add("i2", channels[2])
    assert same(image_set.merge(), merge_channels([channels[0], channels[1], channels[2]]))


def test_the_same_image_twice_changes_nothing_but_rounding() -> None:
    channel = channel_statistics(polygon_with_shadows(1)[0])
    once, twice = merge_channels([channel]), merge_channels([channel, channel])
    np.testing.assert_allclose(twice.ridge, once.ridge, rtol=1e-4, atol=1e-3)


def test_an_overexposed_channel_does_not_spoil_the_set() -> None:
    scene = step(0.4, 0.0, 60, 120).astype(float)
    good = channel_statistics(scene.astype(np.uint8), 1.0)
    blown = channel_statistics(np.minimum(scene * 8, 255).astype(np.uint8), 8.0)
    edges, alone = merge_channels([good, blown]), merge_channels([good])
    strong = alone.ridge > 0.9 * alone.ridge.max()
    np.testing.assert_allclose(edges.ridge[strong], alone.ridge[strong], rtol=0.1)


def test_a_black_channel_changes_little() -> None:
    images = [channel_statistics(image) for image in polygon_with_shadows(3)]
    black = channel_statistics(np.zeros((120, 160), np.uint8))
    with_black, without = merge_channels([*images, black]), merge_channels(images)
    strong = without.ridge > 0.5 * without.ridge.max()
    np.testing.assert_allclose(with_black.ridge[strong], without.ridge[strong], rtol=0.02)


def test_an_image_of_one_grey_has_no_edges() -> None:
    edges = merge_channels([channel_statistics(np.full((20, 30), 99, np.uint8))])
    assert not edges.ridge.any()
    assert edges.ridge.dtype == np.float32


def test_bad_sets_are_refused() -> None:
    channel = channel_statistics(step(0.0, 0.0, 50, 150))
    image_set = ImageSetStatistics()
    with pytest.raises(BadInput, match="empty"):
        image_set.merge()
    image_set.add("i1", channel)
    with pytest.raises(BadInput, match="already"):
        image_set.add("i1", channel)
    with pytest.raises(BadInput, match="128x96"):
        image_set.add("i2", channel_statistics(np.zeros((50, 50), np.uint8)))
    with pytest.raises(BadInput, match="No image i7"):
        image_set.remove("i7")
