"""To which side each light's shadows fall."""

from __future__ import annotations

import numpy as np

from numerics.arrays import Floats
from tests.vision_server.level_samples import edgels_of
from vision_server.kinds.each_light import less_crease
from vision_server.kinds.falling import DIRECTIONS, Falling, learn_falling
from vision_server.kinds.sides import Sides

LIT = np.array([60.0, 80.0, 50.0])
TOWARDS_DEG = np.array([0.0, 120.0, 240.0])  # to each of three lights, as the image shows them


def edgels(pairs: list[tuple[Floats, Floats]], ahead_deg: list[float]) -> Sides:
    return edgels_of(np.array(pairs).transpose(2, 1, 0), 1.0, axis=np.deg2rad(ahead_deg))


def without(light: int) -> Floats:
    return np.where(np.arange(3) == light, 0.0, LIT)


def shadows(scatter_deg: float, away: int = 0) -> tuple[list[tuple[Floats, Floats]], list[float]]:
    """Of each light 100 ends that face it, and so many edgels that face away from it."""
    random = np.random.default_rng(0)
    pairs, ahead = [], []
    for light, towards in enumerate(TOWARDS_DEG):
        for number in range(100 + away):
            pairs.append((LIT, without(light)))
            ahead.append(towards + scatter_deg * random.normal() + 180.0 * (number >= 100))
    return pairs, ahead


def likeliest_deg(found: Falling) -> Floats:
    return found.shadow.argmax(axis=1) * 360.0 / DIRECTIONS


def off_deg(found: Falling) -> Floats:
    return np.abs((likeliest_deg(found) - TOWARDS_DEG + 180.0) % 360.0 - 180.0)


def test_the_ends_of_shadows_say_where_their_lights_are() -> None:
    pairs, ahead = shadows(40.0)
    some = edgels(pairs, ahead)
    every = np.ones(len(pairs), bool)
    assert off_deg(learn_falling(some, ~every, every)).max() <= 20.0


def test_shading_says_it_where_most_that_looks_like_a_shadow_is_behind_outlines() -> None:
    pairs, ahead = shadows(20.0, away=110)
    shaded = np.arange(0.0, 360.0, 10.0)
    outlines = []
    for outwards in shaded:
        facing = 1.0 + np.cos(np.deg2rad(outwards - TOWARDS_DEG))
        outlines.append((LIT * facing, np.ones(3)))
    some = edgels(pairs + outlines, [*ahead, *shaded])
    is_outline = np.arange(len(pairs) + len(outlines)) >= len(pairs)
    assert off_deg(learn_falling(some, is_outline, ~is_outline)).max() <= 20.0
    assert off_deg(learn_falling(some, np.zeros_like(is_outline), ~is_outline)).max() > 150.0


def test_nothing_seen_says_nothing() -> None:
    none = np.zeros(1, bool)
    found = learn_falling(edgels([(LIT, without(0))], [0.0]), none, none)
    np.testing.assert_allclose(found.shadow, 1.0, rtol=1e-6)
    np.testing.assert_allclose(found.outline, 1.0, rtol=1e-6)


def test_a_dark_side_away_from_the_light_is_rather_behind_an_outline() -> None:
    pairs, ahead = shadows(30.0)
    every = np.ones(len(pairs), bool)
    found = learn_falling(edgels(pairs, ahead), ~every, every)
    # the same edge read both ways, then one that faces away
    asked = edgels([(LIT, without(1)), (without(1), LIT), (without(1), LIT)], [120.0, 300.0, 120.0])
    less = less_crease(asked, found.of(asked.near, asked.axis))
    np.testing.assert_allclose(less.shadow[0], less.shadow[1], atol=1e-4)
    assert less.shadow[0] - less.outline[0] > less.shadow[2] - less.outline[2] + 3.0


def test_what_all_lights_show_together_has_the_dark_side_of_each() -> None:
    pairs, ahead = shadows(30.0)
    every = np.ones(len(pairs), bool)
    found = learn_falling(edgels(pairs, ahead), ~every, every)
    asked = edgels([(LIT, 0.5 * LIT)], [120.0])
    each, together = (
        found.of(near, asked.axis)[0] for near in (asked.near, asked.near.sum(0, keepdims=True))
    )
    np.testing.assert_allclose(each, together)
    assert each[1, 0] > 2.0 * max(each[0, 0], each[2, 0])


def test_a_dark_side_away_from_the_light_that_changes_most_speaks_against_its_shadow() -> None:
    pairs, ahead = shadows(30.0)
    every = np.ones(len(pairs), bool)
    found = learn_falling(edgels(pairs, ahead), ~every, every)
    towards, away = found.of_most_changed(edgels([(LIT, without(1)), (without(1), LIT)], [120.0, 120.0]))
    assert towards == 1.0
    assert away < 0.4
