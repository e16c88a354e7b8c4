"""What has happened before an image, in pictures of which the lights are known."""

import cv2
import numpy as np
import pytest

from geometry.model import Model
from tests.vision_server.prediction.lit_scenes import ASKED, POSITIONS, found, taken
from tests.vision_server.synthetic import CAMERA, POSE
from vision_server.prediction.causes import DOUBT_NATS, Cause, likely_causes, verdict
from vision_server.prediction.hidden import shown_again
from vision_server.prediction.lit_target import LitTarget
from vision_server.prediction.places import MOST_PLACES, OTHER_LIGHTS, Places, Readings, read
from vision_server.prediction.response import LitImage


@pytest.mark.slow
def test_nothing_is_named_where_nothing_has_happened(model: Model) -> None:
    images = [taken(model, asked, asked) for asked in ASKED]
    for count in range(2, len(images) + 1):
        causes = found(model, images[:count])
        assert verdict(causes) == (None, None)
        assert causes[0].nats < DOUBT_NATS


@pytest.mark.slow
def test_a_dead_light_two_swapped_and_another_sun_are_told_apart(model: Model) -> None:
    before = [taken(model, asked, asked) for asked in ASKED]
    dead = [*before, taken(model, (1.0, 0.8), (0.0, 0.8)), taken(model, (1.0, 1.0), (0.0, 1.0))]
    swapped = [*before, taken(model, (1.0, 0.1), (0.1, 1.0)), taken(model, (0.0, 0.8), (0.8, 0.0))]
    sun = [*before, *(taken(model, asked, asked, sun=0.2) for asked in ((0.5, 0.5), (1.0, 0.0)))]
    told = [verdict(found(model, images))[0] for images in (dead, swapped, sun)]
    assert [cause and (cause.name, cause.lights) for cause in told] == [
        ("light_dead", (0,)),
        ("lights_swapped", (0, 1)),
        ("sun_changed", ()),
    ]
    assert all(cause is not None and cause.since == len(before) for cause in told)


def test_in_a_dark_room_a_light_that_is_dead_is_no_sun_that_has_set(model: Model) -> None:
    asked = (1.0, 1.0), (1.0, 1.0), (0.0, 1.0), (1.0, 0.0)
    given = (1.0, 1.0), (0.0, 1.0), (0.0, 1.0), (0.0, 0.0)
    images = [taken(model, one, other, sun=0.0) for one, other in zip(asked, given, strict=True)]
    places, readings = read(LitTarget(model, CAMERA, POSE, POSITIONS), images)
    sure, _ = verdict(likely_causes(places, readings, np.array(asked), doubted=1))
    assert sure is not None
    assert sure[:3] == ("light_dead", (0,), 1)


def test_lights_that_are_turned_down_in_a_dark_room_are_no_sun_that_has_set(model: Model) -> None:
    images = [taken(model, asked, asked, sun=0.0) for asked in ((1.0, 1.0), (0.0, 0.3))]
    assert verdict(found(model, images)) == (None, None)


def test_beside_a_sun_on_most_places_a_weak_light_that_shows_in_its_shadow_is_not_dead() -> None:
    in_sun = np.arange(16) >= 6
    shape = np.stack([np.ones(16), np.where(in_sun, 1.6, 0.3), np.where(in_sun, 0.3, 1.9)], axis=1)
    lights = 0.0625 * np.array([[1, 1], [0, 0], [0, 0], [0, 1], [1, 1], [1, 0]])
    exposure = np.array([0.5, 2.0, 32.0, 32.0, 0.5, 0.5])[:, None]
    given = 1.8 * in_sun + 0.1 * lights @ shape[:, 1:].T
    sd = np.hypot(0.015 * given, 0.002 / exposure)
    most = 0.93 / exposure
    value = np.minimum(given + sd * np.random.default_rng(1).normal(size=sd.shape), most)
    least = np.where(value < most, 0.0, value)
    readings = Readings(value, sd, value < most, least, np.zeros_like(sd), np.eye(len(lights)), most[:, 0])
    places = Places(np.zeros((16, 2), np.int64), np.zeros((16, 3)), shape, np.ones(2, np.bool_))
    causes = likely_causes(places, readings, lights, doubted=4)
    assert all(cause.nats < 0.0 for cause in causes if cause.name == "light_dead")


def test_an_image_without_any_light_is_no_endless_evidence(model: Model) -> None:
    images = [taken(model, (1.0, 1.0), (1.0, 1.0), sun=0.0)] * 2
    causes = found(model, [*images, taken(model, (0.0, 1.0), (0.0, 0.0), sun=0.0)])
    assert np.isfinite([cause.nats for cause in causes]).all()
    assert causes[0].name != "in_the_way"


def test_where_lights_are_not_known_to_be_nothing_is_named_either(model: Model) -> None:
    images = [taken(model, asked, asked) for asked in ASKED]
    assert verdict(found(model, images, [None, None])) == (None, None)


@pytest.mark.slow
def test_few_images_look_back_to_where_something_was_doubted(model: Model) -> None:
    images = [taken(model, asked, asked) for asked in ASKED]
    images += [taken(model, asked, (0.0, asked[1])) for asked in ((1.0, 0.8), (0.6, 0.2), (0.8, 0.3))]
    places, readings = read(LitTarget(model, CAMERA, POSE, POSITIONS), images)
    lights = np.array([image.lights for image in images])
    assert min(cause.since for cause in likely_causes(places, readings, lights)) == 5
    causes = likely_causes(places, readings, lights, doubted=4)
    assert causes[0][:3] == ("light_dead", (0,), 4)


def test_a_sun_that_saturated_and_does_no_more_is_another() -> None:
    in_sun = np.arange(16) < 6
    shape = np.stack([np.ones(16), *np.random.default_rng(2).uniform(0.3, 1.7, (2, 16))], axis=1)
    lights = np.array([[1.0, 0.7], [1.0, 1.0], [1.0, 0.7]])
    exposure = np.array([1.0, 0.25, 1.0])[:, None]
    given = np.array([[4.0], [0.3], [0.3]]) * in_sun + 0.1 * lights @ shape[:, 1:].T
    sd = np.hypot(0.015 * given, 0.002 / exposure)
    most = 0.93 / exposure
    value = np.minimum(given + sd * np.random.default_rng(1).normal(size=sd.shape), most)
    least, alike = np.where(value < most, 0.0, value), 1.0 * np.equal.outer(exposure[:, 0], exposure[:, 0])
    readings = Readings(value, sd, value < most, least, np.full_like(sd, 0.9), alike, most[:, 0])
    normal = np.where(in_sun[:, None], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0])
    places = Places(np.zeros((16, 2), np.int64), normal, shape, np.ones(2, np.bool_))
    causes = likely_causes(places, readings, lights)
    assert causes[0].name == "sun_changed"
    assert causes[0].nats >= DOUBT_NATS
    unclipped = readings._replace(least=np.zeros_like(least))
    assert likely_causes(places, unclipped, lights)[0].nats < DOUBT_NATS


@pytest.mark.parametrize("after", [0.93, 0.3])
def test_what_is_hidden_and_was_saturated_has_to_be_so_no_more(after: float) -> None:
    value = np.array([[0.93, 0.93, 0.1], [2.0, 2.0, 0.1], [after, after, 0.1]])
    known = value != 0.93
    same = np.array([[1.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 1.0]])
    least, sd = np.where(known, 0.0, value), np.full_like(value, 0.01)
    readings = Readings(value, sd, known, least, np.full_like(sd, 0.5), same, np.full(3, 0.93))
    hidden = known & (np.arange(3) < 2) & (np.arange(3) >= 1)[:, None]
    assert shown_again(readings, hidden, 1) == (after < 0.93)


def test_images_that_are_saturated_say_nothing(model: Model) -> None:
    images = [taken(model, (1.0, 1.0), (9.0, 9.0), sun=9.0) for _ in range(2)]
    places, readings = read(LitTarget(model, CAMERA, POSE, POSITIONS), images)
    assert not readings.known.any()
    assert likely_causes(places, readings, np.ones((2, 2))) == []


@pytest.mark.parametrize("blurs", [(0.7, 3.0), (3.0, 0.7)])
def test_light_adds_up_at_every_place_of_images_that_are_not_equally_sharp(
    model: Model, blurs: tuple[float, float]
) -> None:
    images = []
    for blur, lights in zip(blurs, ((1.0, 1.0), (0.5, 0.5)), strict=True):
        image = taken(model, lights, lights, sun=0.0)
        sharp = np.asarray(cv2.GaussianBlur(image.linear, (0, 0), blur), dtype=np.float32)
        images.append(LitImage(sharp, image.exposure, image.lights, blur))
    places, readings = read(LitTarget(model, CAMERA, POSE, POSITIONS), images)
    assert places.at.shape == (MOST_PLACES, 2)
    np.testing.assert_allclose(readings.value[1], 0.5 * readings.value[0], rtol=0.05, atol=0.01)


def test_a_cause_is_sure_only_where_others_are_far_behind_and_sooner_where_it_was_tested() -> None:
    def causes(*nats: float, tested: bool) -> list[Cause]:
        return [Cause("light_dead", (light,), 3, each, tested) for light, each in enumerate(nats)]

    assert verdict(causes(50.0, 5.0, tested=False))[0] is not None
    assert verdict(causes(30.0, 5.0, tested=True))[0] is not None
    rival = [Cause("sun_changed", (), 3, 50.0, True), Cause("light_dead", (0,), 3, 38.0, False)]
    assert verdict(rival) == (None, rival[1])  # what no image has tested yet is doubted
    untested = [Cause("sun_changed", (), 3, 80.0, False)]
    assert verdict(untested) == (None, untested[0])
    assert verdict([rival[0], rival[1]._replace(tested=True)])[0] == rival[0]  # 12 apart
    for unsure in (
        causes(50.0, 45.0, tested=False),
        causes(30.0, 5.0, tested=False),
        causes(30.0, 25.0, tested=True),
    ):
        assert verdict(unsure) == (None, unsure[0])
    assert verdict(causes(3.0, tested=True)) == (None, None)
    assert verdict([]) == (None, None)
    same = [Cause("light_dead", (1,), since, nats, True) for since, nats in ((2, 30.0), (3, 29.0))]
    assert verdict(same)[0] == same[0]  # since when does not matter


def test_an_image_that_is_clipped_and_was_to_be_dark_is_doubted(model: Model) -> None:
    dark = [taken(model, asked, asked) for asked in ASKED]
    clipped = taken(model, (1.0, 1.0), (40.0, 40.0), sun=40.0)
    assert [cause.name for cause in found(model, [*dark, clipped])] == ["sun_changed"]
    assert verdict(found(model, [*dark, clipped]))[0] is None
    assert found(model, [clipped, clipped]) == []


def test_errors_of_one_exposure_go_together_place_by_place(model: Model) -> None:
    images = [taken(model, asked, asked) for asked in ((1.0, 1.0), (1.0, 1.0), (0.3, 1.0))]
    images.append(LitImage(images[0].linear, 0.25, images[0].lights, 0.7))
    _, readings = read(LitTarget(model, CAMERA, POSE, POSITIONS), images)
    assert readings.alike[0].tolist() == [1.0, 1.0, OTHER_LIGHTS, 0.0]
    use = np.flatnonzero(readings.known)
    correlation = readings.correlation(use)
    np.testing.assert_allclose(np.diag(correlation), 1.0)
    assert np.linalg.eigvalsh(correlation).min() > 0.0
    image, place = np.unravel_index(use, readings.known.shape)
    other = correlation[np.ix_(image == 0, image == 1)]
    same_place = place[image == 0][:, None] == place[image == 1][None]
    assert (other[same_place] > 0.5).all()
    assert (other[~same_place] == 0.0).all()
