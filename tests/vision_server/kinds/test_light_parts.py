"""Each light's own part of the intensities, from the levels of the lights."""

from __future__ import annotations

import numpy as np
import pytest

from tests.vision_server.level_samples import edgels_of
from vision_server.kinds.background import Background
from vision_server.kinds.each_light import less_crease
from vision_server.kinds.light_parts import known_lights, parts_of
from vision_server.kinds.likelihoods import CREASE, FIXED, HIGHLIGHT, PRINT, SHADOW, likelihoods
from vision_server.kinds.sides import Sides

LEVELS = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.6, 0.6, 0.6]])
LEFT = np.array([50.0, 70.0, 40.0, 30.0])  # of three lamps and the sun


def shown(left: np.ndarray, right: np.ndarray, levels: np.ndarray = LEVELS) -> Sides:
    lights = np.hstack([levels, np.ones((len(levels), 1))])
    return edgels_of(np.stack([lights @ left, lights @ right], axis=1)[:, :, None], 1.0)


def test_the_parts_are_those_that_were_summed() -> None:
    right = np.array([50.0, 0.0, 40.0, 30.0])
    parts = parts_of(shown(LEFT, right), known_lights(LEVELS))
    assert parts is not None
    np.testing.assert_allclose(parts.near[:, :, 0], np.stack([LEFT, right], axis=1), atol=1e-3)
    assert parts.noise.min() > 1.0


def test_a_lamp_that_is_never_on_has_no_part() -> None:
    idle = np.hstack([LEVELS, np.zeros((4, 1))])
    parts = parts_of(shown(LEFT, LEFT), known_lights(idle))
    assert parts is not None
    assert len(parts.near) == 4


@pytest.mark.parametrize(
    "levels", [LEVELS[:3], np.ones((4, 3)), np.full((4, 3), 0.5) + 1e-3 * LEVELS], ids=["few", "same", "near"]
)
def test_lights_that_are_not_told_apart_have_no_parts(levels: np.ndarray) -> None:
    assert parts_of(shown(LEFT, LEFT, levels), known_lights(levels)) is None


def kind_of(sides: Sides, levels: np.ndarray = LEVELS) -> int:
    return int(likelihoods(sides, Background(1.0), known_lights(levels))[:, 0].argmax())


@pytest.mark.parametrize("levels", [LEVELS, LEVELS[:3]], ids=["parts", "fewer images than lights"])
@pytest.mark.parametrize("blocked", range(4))
def test_one_light_that_is_blocked_is_a_shadow(blocked: int, levels: np.ndarray) -> None:
    right = LEFT.copy()
    right[blocked] = 0.0
    assert kind_of(shown(LEFT, right, levels), levels) == SHADOW
    assert kind_of(shown(right, LEFT, levels), levels) == SHADOW


def test_two_shadows_may_end_at_one_place() -> None:
    left, right = LEFT.copy(), LEFT.copy()
    left[0] = right[2] = 0.0
    assert kind_of(shown(left, right)) == SHADOW
    left[0], left[2] = LEFT[0], 0.3 * LEFT[2]
    right[0] = 0.0
    right[2] = LEFT[2]
    assert kind_of(shown(left, right)) == SHADOW


def test_three_shadows_do_not_end_at_one_place() -> None:
    right = LEFT * [0.0, 0.0, 0.0, 1.0]
    assert kind_of(shown(LEFT, right)) in FIXED
    assert kind_of(shown(right, LEFT)) in FIXED


def test_behind_an_outline_the_light_that_is_left_may_be_the_same() -> None:
    found = []
    for change in (1.0, 0.5):
        parts = parts_of(shown(LEFT, LEFT * [0.0, 0.0, 1.0, change]), known_lights(LEVELS))
        assert parts is not None
        found.append(less_crease(parts).outline[0])
    assert found[0] > 6.0 > found[1] + 3.0


def test_a_light_of_which_half_is_left_is_not_blocked() -> None:
    half, none = LEFT * [1.0, 0.5, 1.0, 1.0], LEFT * [1.0, 0.0, 1.0, 1.0]
    lights = known_lights(LEVELS)
    of_half, of_none = (
        likelihoods(shown(3.0 * LEFT, 3.0 * right), Background(1.0), lights) for right in (half, none)
    )
    assert (of_none[SHADOW] - of_none[CREASE])[0] > (of_half[SHADOW] - of_half[CREASE])[0] + 4.0


def test_what_every_light_shows_otherwise_is_no_shadow() -> None:
    for kind, right in ((CREASE, LEFT * [0.3, 1.3, 0.6, 0.9]), (PRINT, 0.4 * LEFT)):
        assert kind_of(shown(LEFT, right)) == kind


def test_a_shadow_may_end_on_a_print() -> None:
    print_and_shadow = 0.7 * LEFT * [1.0, 0.0, 1.0, 1.0]
    assert kind_of(shown(LEFT, print_and_shadow)) == SHADOW
    assert kind_of(shown(LEFT * [1.0, 0.0, 1.0, 1.0], 0.7 * LEFT)) == SHADOW


def test_a_print_stays_one_where_a_light_is_mirrored() -> None:
    mirrored = np.array([0.0, 0.0, 60.0, 0.0])
    assert kind_of(shown(3.0 * LEFT + mirrored, LEFT + mirrored)) == PRINT


def test_one_light_that_is_mirrored_on_one_side_is_a_highlight_and_no_deep_shadow_is() -> None:
    assert kind_of(shown(LEFT, LEFT + np.array([0.0, 0.0, 90.0, 0.0]))) == HIGHLIGHT
    bright = 2.0 * LEFT
    for blocked in range(4):
        right = bright.copy()
        right[blocked] = 0.0
        assert kind_of(shown(bright, right)) == SHADOW


def test_an_outline_before_another_surface_hides_lights_on_one_side_only() -> None:
    left, right = LEFT * [1.0, 1.0, 2.0, 0.6], LEFT * [0.0, 0.0, 1.0, 1.0]
    swapped = LEFT * [1.0, 0.0, 2.0, 0.6], LEFT * [0.0, 1.0, 1.0, 1.0]
    one_sided, both = (parts_of(shown(*pair), known_lights(LEVELS)) for pair in ((left, right), swapped))
    assert one_sided is not None and both is not None
    assert less_crease(one_sided).outline[0] > less_crease(both).outline[0] + 2.0


def test_beside_a_clipped_channel_shadows_are_told_by_the_others() -> None:
    right = LEFT.copy()
    right[1] = 0.0
    sides = shown(LEFT, right)
    sides.near[0] = 255.0
    sides.known[0] = False
    assert kind_of(sides) == SHADOW


@pytest.mark.parametrize("more", [[], [[0.5, 0.5, 0.0, 0.2]]])
def test_what_each_light_gives_is_found_from_as_many_channels_and_from_more(more: list[list[float]]) -> None:
    levels = np.array([*LEVELS, *(image[:3] for image in more)])
    given = np.array([[10.0, 40.0], [20.0, 20.0], [30.0, 0.0], [5.0, 6.0]], np.float32)  # of lamps and sun
    near = (np.hstack([levels, np.ones((len(levels), 1))]) @ given)[..., None]
    lights = known_lights(levels)
    parts = parts_of(edgels_of(near, 2.0), lights)
    assert parts is not None and lights.share is not None
    np.testing.assert_allclose(parts.near[..., 0], given, atol=1e-4)
    np.testing.assert_allclose(parts.noise[:, 0], 2.0 * np.linalg.norm(lights.share, axis=1), rtol=1e-5)
    assert parts.known.all()


def test_lights_that_are_on_alike_in_all_channels_are_not_told_apart() -> None:
    assert known_lights(np.array([[1.0, 0.5], [0.0, 0.0], [0.5, 0.25]])).share is None
