"""Each light's own part of the intensities, from the levels of the lights."""

from __future__ import annotations

import numpy as np
import pytest

from vision_server.edges.light_parts import parts_of
from vision_server.edges.likelihoods import CREASE, PRINT, SHADOW, likelihoods
from vision_server.edges.sides import Sides

LEVELS = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.6, 0.6, 0.6]])
LEFT = np.array([50.0, 70.0, 40.0, 30.0])  # of three lamps and the sun


def shown(left: np.ndarray, right: np.ndarray, levels: np.ndarray = LEVELS) -> Sides:
    lights = np.hstack([levels, np.ones((len(levels), 1))])
    near = np.stack([lights @ left, lights @ right], axis=1)[:, :, None].astype(np.float32)
    return Sides(near, near, np.ones((len(levels), 1), np.float32), np.ones((len(levels), 1), bool))


def test_the_parts_are_those_that_were_summed() -> None:
    right = np.array([50.0, 0.0, 40.0, 30.0])
    parts = parts_of(shown(LEFT, right), LEVELS)
    assert parts is not None
    np.testing.assert_allclose(parts.near[:, :, 0], np.stack([LEFT, right], axis=1), atol=1e-3)
    assert parts.noise.min() > 1.0


def test_a_lamp_that_is_never_on_has_no_part() -> None:
    idle = np.hstack([LEVELS, np.zeros((4, 1))])
    parts = parts_of(shown(LEFT, LEFT), idle)
    assert parts is not None
    assert len(parts.near) == 4


@pytest.mark.parametrize(
    "levels", [LEVELS[:3], np.ones((4, 3)), np.full((4, 3), 0.5) + 1e-3 * LEVELS], ids=["few", "same", "near"]
)
def test_lights_that_are_not_told_apart_have_no_parts(levels: np.ndarray) -> None:
    assert parts_of(shown(LEFT, LEFT, levels), levels) is None


@pytest.mark.parametrize("blocked", [[1], [3], [0, 3], [0, 1, 2]], ids=str)
def test_any_lights_that_are_blocked_are_a_shadow(blocked: list[int]) -> None:
    right = LEFT.copy()
    right[blocked] = 0.0
    assert likelihoods(shown(LEFT, right), 1.0, LEVELS)[:, 0].argmax() == SHADOW


def test_what_every_light_shows_otherwise_is_no_shadow() -> None:
    for kind, right in ((CREASE, LEFT * [0.3, 1.3, 0.6, 0.9]), (PRINT, 0.4 * LEFT)):
        assert likelihoods(shown(LEFT, right), 1.0, LEVELS)[:, 0].argmax() == kind


def test_beside_a_clipped_channel_shadows_are_told_without_parts() -> None:
    right = LEFT.copy()
    right[1] = 0.0
    sides = shown(LEFT, right)
    sides.known[0] = False
    np.testing.assert_array_equal(likelihoods(sides, 1.0, LEVELS)[SHADOW], likelihoods(sides, 1.0)[SHADOW])
