"""Lamps that are on alone in one image each beside the sun, and their shadows."""

from __future__ import annotations

import numpy as np
import pytest

from tests.vision_server.level_samples import edgels_of
from vision_server.kinds.alone import lamps_are_alone, shadow_of_some
from vision_server.kinds.sides import Sides

NOISE, SUN = 1.0, 40.0
LAMPS = 4


def sides_of_parts(pairs: np.ndarray, levels: np.ndarray, seed: int = 0) -> Sides:
    """Edgels at which lights give so much behind and ahead (N, 2, L), the sun last."""
    near = np.einsum("cl,nsl->csn", np.hstack([levels, np.ones((len(levels), 1))]), pairs)
    near = near + NOISE * np.random.default_rng(seed).normal(size=near.shape)
    return edgels_of(near, NOISE)


def ends(blocked: tuple[int, ...], count: int, seed: int = 0) -> np.ndarray:
    """What lights give where some end and nothing else changes, (count, 2, LAMPS + 1)."""
    random = np.random.default_rng(seed)
    ahead = np.hstack([random.uniform(50.0, 100.0, (count, LAMPS)), np.full((count, 1), SUN)])
    behind = ahead.copy()
    behind[:, list(blocked)] = 0.0
    return np.stack([behind, ahead], axis=1)


def creases(count: int, seed: int = 1) -> np.ndarray:
    random = np.random.default_rng(seed)
    return np.asarray(random.uniform(20.0, 100.0, (count, 2, LAMPS + 1)))


def log_likelihood(pairs: np.ndarray) -> np.ndarray:
    sides = sides_of_parts(pairs, np.eye(LAMPS))
    return shadow_of_some(sides, np.ones(sides.noise.shape, np.float32))


def test_shadows_of_one_and_of_several_lamps_are_likelier_than_creases() -> None:
    crease = np.median(log_likelihood(creases(200)))
    for blocked in ((0,), (2,), (0, 1), (1, 3), (0, 1, 2)):
        assert np.quantile(log_likelihood(ends(blocked, 50)), 0.1) > crease + 8.0


def test_lamps_that_end_together_must_leave_the_same() -> None:
    pairs = ends((0, 1), 50)
    clear = np.median(log_likelihood(pairs))
    pairs[:, 0, 1] = 15.0  # something of the second lamp is left
    assert np.quantile(log_likelihood(pairs), 0.9) < clear - 3.0


def test_nothing_that_another_image_outdoes_in_darkness_is_the_end_of_a_lamp() -> None:
    """The sun is in all images: where one shows less, what is left in another is not the sun alone."""
    pairs = ends((0,), 50)
    clear = np.median(log_likelihood(pairs))
    pairs[:, 0, 0], pairs[:, :, 1] = 20.0, 0.0
    assert np.median(log_likelihood(pairs)) < clear - 3.0


def test_the_side_to_which_shadows_fall_counts() -> None:
    sides = sides_of_parts(ends((0,), 30), np.eye(LAMPS))
    toward = np.ones(sides.noise.shape, np.float32)
    away = toward.copy()
    away[0] = 0.1
    change = shadow_of_some(sides, toward) - shadow_of_some(sides, away)
    np.testing.assert_allclose(change, np.log(10.0), atol=0.05)


def test_a_clipped_image_says_nothing() -> None:
    sides = sides_of_parts(np.vstack([ends((0,), 30), creases(30)]), np.eye(LAMPS))
    known = sides.known.copy()
    known[1:] = False
    found = shadow_of_some(sides._replace(known=known), np.ones(sides.noise.shape, np.float32))
    assert np.isfinite(found).all()
    assert np.ptp(found) < 20.0


@pytest.mark.parametrize("levels", [np.eye(LAMPS), 0.3 * np.eye(LAMPS)[::-1]])
def test_lamps_are_alone_where_most_have_shadows_that_leave_the_sun(levels: np.ndarray) -> None:
    pairs = np.vstack([ends(blocked, 15) for blocked in ((0,), (1,), (2, 3))])
    assert lamps_are_alone(sides_of_parts(pairs, levels))
    assert not lamps_are_alone(sides_of_parts(pairs[:30], levels))  # two of four
    none = sides_of_parts(pairs, levels)
    assert not lamps_are_alone(none._replace(known=np.zeros_like(none.known)))


def test_lamps_that_are_on_in_two_images_each_are_not_alone() -> None:
    chain = np.eye(LAMPS) + np.roll(np.eye(LAMPS), 1, axis=1)
    pairs = np.vstack([ends((lamp,), 15) for lamp in range(LAMPS)])
    assert lamps_are_alone(sides_of_parts(pairs, np.eye(LAMPS)))
    pairs *= [1.0, 0.4, 1.0, 0.8, 1.0]
    assert not lamps_are_alone(sides_of_parts(pairs, chain))


def test_what_mostly_leaves_different_light_is_no_shadow_of_lamps_that_are_alone() -> None:
    """As shading of curved surfaces does."""
    pairs = np.vstack([ends((0, 1), 15), ends((2, 3), 15)])
    shading = np.vstack([ends((0, 1), 20), ends((2, 3), 20)])
    shading[:20, 0, 0], shading[20:, 0, 2] = 25.0, 25.0
    assert lamps_are_alone(sides_of_parts(pairs, np.eye(LAMPS)))
    assert not lamps_are_alone(sides_of_parts(np.vstack([pairs, shading]), np.eye(LAMPS)))
