"""What is usual is told apart by light, kept where the light stays, and handed on where doubts were vain."""

import numpy as np

from geometry.model import Model
from numerics.arrays import Grey
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture, photographed
from tests.vision_server.tracking.films import GREYS
from vision_server.tracking.usual import LATEST_FRAME_SHARE, Usual

WHOLE = np.ones(12, dtype=np.bool_)
OTHER = tuple(1.1 - grey for grey in GREYS)  # brightness of the faces under another lamp


def frame(model: Model, number: int, greys: tuple[float, ...] = GREYS) -> Grey:
    return photographed(linear_picture(model, CAMERA, POSE, greys), 0.8, seed=number)


def met(usual: Usual, model: Model, number: int, greys: tuple[float, ...] = GREYS) -> Usual:
    usual.meets(frame(model, number, greys), POSE)
    return usual


def test_each_light_has_what_is_usual_in_it(model: Model) -> None:
    usual = Usual(model, CAMERA)
    assert usual.quality == 0.0
    assert usual.whole is None
    met(usual, model, 0).believed(1.0, WHOLE)
    met(usual, model, 1, OTHER).believed(0.2, None)
    for number in range(2, 10, 2):
        assert met(usual, model, number).quality > 0.9
        assert usual.whole is WHOLE
        usual.believed(1.0, WHOLE)
        assert met(usual, model, number + 1, OTHER).quality < 0.93
        assert usual.whole is None
        usual.believed(0.2, None)
    assert usual.quality < 0.6  # the first was judged by the only one before it


def test_while_the_light_stays_the_last_frame_is_what_is_usual(model: Model) -> None:
    usual = Usual(model, CAMERA)
    expected = 1.0
    for number, quality in enumerate((1.0, 0.6, 0.8, 0.4, 1.2)):
        met(usual, model, number).believed(quality, WHOLE)
        expected += (quality - expected) * LATEST_FRAME_SHARE
        assert np.isclose(usual.quality, expected if number else 1.0)


def test_a_frame_that_was_doubted_for_its_quality_is_usual_in_its_light_once_another_is_believed(
    model: Model,
) -> None:
    usual = Usual(model, CAMERA)
    met(usual, model, 0).believed(1.0, WHOLE)
    met(usual, model, 1, OTHER).doubted(0.2)
    assert met(usual, model, 2).is_other
    usual.believed(1.0, WHOLE)
    assert not met(usual, model, 3).is_other
    assert met(usual, model, 4, OTHER).quality == 0.2


def test_what_is_doubted_for_more_is_not_made_usual(model: Model) -> None:
    usual = Usual(model, CAMERA)
    met(usual, model, 0).believed(1.0, WHOLE)
    met(usual, model, 1, OTHER).doubted(0.2)
    usual.forget_doubts()
    assert not met(usual, model, 2).is_other
    usual.believed(1.0, WHOLE)
    assert met(usual, model, 3, OTHER).quality == 1.0


def test_a_frame_in_the_light_of_a_doubted_one_is_not_in_another(model: Model) -> None:
    usual = Usual(model, CAMERA)
    met(usual, model, 0).believed(1.0, WHOLE)
    met(usual, model, 1).doubted(0.2)
    assert not met(usual, model, 2).is_other
