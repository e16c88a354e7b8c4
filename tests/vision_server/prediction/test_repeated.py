"""Between two pictures of the same settings: something in the way, and what is none."""

import cv2
import numpy as np
import pytest

from numerics.arrays import Floats, Grey
from vision_server.prediction.repeated import difference, flicker

SIZE = (120, 160)  # rows, columns
TARGET = np.zeros(SIZE, bool)
TARGET[30:90, 40:120] = True
FACES = np.where(np.indices(SIZE)[1] < 80, 40.0, 90.0) * TARGET


def picture(brightness: Floats, seed: int) -> Grey:
    """As a camera shows a brightness (H, W)."""
    noise = np.random.default_rng(seed).normal(0.0, 1.0, SIZE)
    return np.clip(np.rint(cv2.GaussianBlur(brightness, (0, 0), 1.0) + noise), 0, 255).astype(np.uint8)


def with_bar(brightness: Floats, grey: float) -> Floats:
    """With a bar across it."""
    behind = brightness.copy()
    behind[:, 72:90] = grey
    return behind


@pytest.mark.parametrize("times", [1.0, 4.0])
def test_a_bar_in_front_is_told_also_where_much_is_saturated(times: float) -> None:
    faces = np.minimum(times * FACES, 300.0)
    assert difference(picture(faces, 1), picture(with_bar(faces, times * 55.0), 2), TARGET) == "replaced"


@pytest.mark.parametrize("grey", [10.0, 20.0])
def test_a_bar_darker_than_all_that_it_hides_is_told_from_a_shadow(grey: float) -> None:
    stripes = np.where(np.indices(SIZE)[0] // 6 % 2 == 0, FACES, 0.6 * FACES)
    shadow = np.where(with_bar(np.ones(SIZE), 0.4) < 1.0, 0.4 * stripes, stripes)
    assert difference(picture(stripes, 1), picture(with_bar(stripes, grey), 2), TARGET) == "replaced"
    assert difference(picture(stripes, 1), picture(shadow, 2), TARGET) == "relit"


@pytest.mark.parametrize(
    "after",
    [2.0 * FACES, np.where(FACES > 50.0, 50.0, 1.6 * FACES)],
    ids=["twice", "one face brighter and one darker"],
)
def test_a_target_in_other_light_keeps_its_edges(after: Floats) -> None:
    assert difference(picture(FACES, 1), picture(after, 2), TARGET) == "relit"


def test_a_wall_that_is_brighter_than_the_target_and_then_darker_is_in_other_light() -> None:
    before, after = np.where(TARGET, 40.0, 100.0), np.where(TARGET, 90.0, 30.0)
    assert difference(picture(before, 1), picture(after, 2), TARGET) == "relit"


@pytest.mark.parametrize(
    "after",
    [FACES, 1.02 * FACES, np.roll(FACES, 4, axis=1), with_bar(FACES, 0.0)],
    ids=["nothing", "a hundredth or two", "moved", "as dark as a shadow"],
)
def test_what_is_the_same_has_moved_or_may_be_a_shadow_is_neither(after: Floats) -> None:
    assert difference(picture(FACES, 1), picture(after, 2), TARGET) is None


@pytest.mark.parametrize("share", [0.86, 0.95, 1.05, 1.14])
@pytest.mark.parametrize("bright", [1.0, 2.6], ids=["nothing saturated", "a face nearly saturated"])
def test_light_that_flickers_is_no_other_light(share: float, bright: float) -> None:
    before, after = bright * FACES, share * bright * FACES
    assert difference(picture(before, 1), picture(after, 2), TARGET) is None
    assert flicker(picture(before, 1), picture(after, 2), TARGET) == pytest.approx(share, abs=0.01)


def test_what_is_as_bright_or_twice_as_bright_is_no_flicker() -> None:
    assert flicker(picture(FACES, 1), picture(FACES, 2), TARGET) == 1.0
    assert flicker(picture(FACES, 1), picture(2.0 * FACES, 2), TARGET) == 1.0


def test_a_face_that_gets_brighter_by_more_than_another_is_in_other_light() -> None:
    after = FACES * np.where(FACES > 50.0, 1.12, 1.0)
    assert difference(picture(FACES, 1), picture(after, 2), TARGET) == "relit"


def test_a_bar_in_front_is_told_under_light_that_flickers() -> None:
    after = 0.88 * with_bar(FACES, 55.0)
    assert difference(picture(FACES, 1), picture(after, 2), TARGET) == "replaced"


def test_a_target_that_is_brighter_all_over_after_no_light_is_in_other_light() -> None:
    assert difference(picture(0.02 * FACES, 1), picture(FACES, 2), TARGET) == "relit"


def test_a_face_that_is_saturated_no_more_is_nothing_in_the_way() -> None:
    mottled = np.random.default_rng(3).uniform(0.9, 1.1, SIZE)
    before, after = (np.where(FACES > 50.0, grey * mottled, FACES) for grey in (400.0, 120.0))
    assert difference(picture(before, 1), picture(after, 2), TARGET) != "replaced"


def test_what_is_saturated_in_both_tells_nothing() -> None:
    white = np.full(SIZE, 255, np.uint8)
    assert difference(white, white, TARGET) is None
