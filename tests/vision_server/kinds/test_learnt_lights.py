"""Levels of lights that nobody told, from the ends of their shadows."""

from __future__ import annotations

import numpy as np

from tests.vision_server.level_samples import edgels_of
from vision_server.kinds.learnt_lights import learnt_lights
from vision_server.kinds.light_parts import parts_of
from vision_server.kinds.sides import Sides

LEVELS = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.9, 0.3, 0.6]])
NOISE = 1.0


def ends(blocked: list[tuple[int, ...]], each: int, seed: int = 0, levels: np.ndarray = LEVELS) -> Sides:
    """Edgels on surfaces of any colour, at each of which the same lights reach one side only."""
    lights = np.hstack([levels, np.ones((len(levels), 1))])
    random = np.random.default_rng(seed)
    pairs = []
    for missing in blocked:
        for _ in range(each):
            left = np.asarray(random.uniform(40.0, 90.0, (lights.shape[1],)))
            right = left.copy()
            right[list(missing)] = 0.0
            pairs.append((left, right) if random.random() < 0.5 else (right, left))
    near = np.einsum("cl,nsl->csn", lights, np.array(pairs))
    near += NOISE * random.normal(size=near.shape)
    return edgels_of(near, NOISE)


def sorted_levels(on: np.ndarray) -> np.ndarray:
    lamps = on[:, :-1]
    return lamps[:, np.argsort(lamps.argmax(axis=0))]


def test_the_levels_are_learnt_where_each_lamp_casts_shadows() -> None:
    sides = ends([(0,), (1,), (2,)], 40)
    found = learnt_lights(sides)
    assert found is not None and found.are_all
    np.testing.assert_allclose(sorted_levels(found.on), LEVELS, atol=0.05)
    parts = parts_of(sides, found)
    assert parts is not None and parts.near.min() > -12.0


def test_where_two_lights_end_together_is_no_light() -> None:
    found = learnt_lights(ends([(0,), (1,), (2,), (0, 1)], 40))
    assert found is not None and found.are_all
    np.testing.assert_allclose(sorted_levels(found.on), LEVELS, atol=0.05)


def test_a_lamp_without_shadows_is_missing() -> None:
    found = learnt_lights(ends([(0,), (2,)], 40))
    assert found is not None and not found.are_all
    np.testing.assert_allclose(sorted_levels(found.on), LEVELS[:, [0, 2]], atol=0.05)


def test_levels_by_which_a_light_gives_less_than_nothing_are_not_all() -> None:
    sides = ends([(0,), (1,), (2,)], 40)
    # as if the third lamp had been on in the last image by less: what looks so is no shadow
    some = slice(80, 120)
    changed = sides.near.copy()
    step = changed[2, 1, some] - changed[2, 0, some]
    middle = changed[3, :, some].mean(axis=0)
    changed[3, 0, some], changed[3, 1, some] = middle - 0.1 * step, middle + 0.1 * step
    found = learnt_lights(sides._replace(near=changed))
    assert found is not None and not found.are_all


def test_prints_and_shadows_of_the_sun_teach_no_lamp() -> None:
    assert learnt_lights(ends([(3,)], 100)) is None
    prints = ends([()], 100)
    prints.near[:, 1] *= 0.4
    assert learnt_lights(prints) is None


ALONE = np.eye(3)
NO_LAMP_BY_ITSELF = [(0, 1), (1, 2), (0, 2), (3,)]
PAIRS = np.array([[1.0, 0.0, 0.6], [0.4, 1.0, 0.0], [0.0, 0.3, 1.0]])


def of_three(blocked: list[tuple[int, ...]], levels: np.ndarray) -> Sides:
    """Forty ends of each, in three images of three lamps and the sun."""
    return ends(blocked, 40, levels=levels)


def test_lamps_that_are_on_in_one_image_each_are_learnt_with_the_sun_in_all() -> None:
    for blocked in ([(0,), (1,), (2,)], [(0,), (1,), (2,), (0, 1)], [(0,), (2,)]):
        found = learnt_lights(of_three(blocked, ALONE))
        assert found is not None and found.are_all and found.share is None
        np.testing.assert_array_equal(sorted_levels(found.on), ALONE)
    assert learnt_lights(of_three([(0,)], ALONE)) is None


def test_four_lamps_that_are_alone_beside_the_sun_are_learnt_but_before_a_wall() -> None:
    sides = ends([(0,), (1,), (2, 3)], 40, levels=np.eye(4))
    found = learnt_lights(sides)
    assert found is not None and found.are_all and found.share is None and found.are_alone_in_the_sun
    np.testing.assert_array_equal(found.on[:, :-1], np.eye(4))
    before_wall = learnt_lights(sides, before_wall=True)
    assert before_wall is not None and not before_wall.are_all


def test_as_many_lamps_as_images_are_learnt_where_each_is_on_in_several() -> None:
    found = learnt_lights(of_three([(0,), (1,), (2,)], PAIRS))
    assert found is not None and found.are_all and found.share is None
    np.testing.assert_allclose(sorted_levels(found.on), PAIRS, atol=0.05)
    assert learnt_lights(of_three([(0,), (2,)], PAIRS)) is None


def test_lamps_alone_and_all_together_are_learnt_without_shadows_of_one() -> None:
    levels = np.vstack([ALONE, [0.5, 0.5, 0.5]])
    found = learnt_lights(ends(NO_LAMP_BY_ITSELF, 60, levels=levels[[0, 3, 1, 2]]))
    assert found is not None and found.are_all
    np.testing.assert_allclose(found.on[[0, 2, 3, 1], :-1], levels, atol=0.05)
    assert learnt_lights(ends(NO_LAMP_BY_ITSELF, 60)) is None


def test_beside_the_sun_alone_images_of_several_lamps_are_told_from_those_of_one() -> None:
    levels = np.vstack([ALONE, [0.5, 0.5, 0.5], [0.0, 0.0, 0.0], [0.7, 0.0, 0.6]])
    found = learnt_lights(ends(NO_LAMP_BY_ITSELF, 200, levels=levels))
    assert found is not None and found.are_all
    np.testing.assert_allclose(found.on[:, :-1], levels, atol=0.05)
