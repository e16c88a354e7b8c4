"""Something that comes between target and camera is told from light that changes."""

import numpy as np

from geometry.model import Model
from tests.vision_server.prediction.lit_scenes import ASKED, POSITIONS, behind_arm, found, taken
from tests.vision_server.synthetic import CAMERA, POSE
from vision_server.prediction.causes import SUNS, verdict
from vision_server.prediction.hidden import MOST_HIDDEN, hidden_places, log_of_hidden
from vision_server.prediction.lit_target import LitTarget
from vision_server.prediction.places import read
from vision_server.prediction.prior import Prior


def test_an_arm_is_named_when_an_image_is_taken_again(model: Model) -> None:
    images = [taken(model, asked, asked) for asked in ASKED[:3]]
    images.append(behind_arm(taken(model, ASKED[3], ASKED[3])))
    assert verdict(found(model, images))[0] is None
    causes = found(model, [*images, behind_arm(images[0])])
    sure = verdict(causes)[0]
    assert sure is not None
    assert (sure.name, sure.lights, sure.since) == ("in_the_way", (), 3)


def test_another_sun_is_nothing_in_the_way(model: Model) -> None:
    images = [taken(model, asked, asked) for asked in ASKED[:3]]
    images += [taken(model, asked, asked, sun=0.4) for asked in (ASKED[3], ASKED[0])]
    sure = verdict(found(model, images))[0]
    assert sure is not None
    assert sure.name == "sun_changed"


def test_the_places_behind_it_are_found_and_no_others(model: Model) -> None:
    images = [taken(model, asked, asked) for asked in (*ASKED, ASKED[0])]
    images[-1] = behind_arm(images[-1])
    places, readings = read(LitTarget(model, CAMERA, POSE, POSITIONS), images)
    inputs = np.array([[1.0, *image.lights] for image in images])
    hidden = hidden_places([Prior(places, sun) for sun in SUNS], readings, inputs, len(images) - 1)
    change = np.abs(readings.value[-1] / readings.value[0] - 1.0)
    assert not hidden[:-1].any()
    assert 0 < hidden[-1].sum() <= MOST_HIDDEN * hidden.shape[1] + 1
    assert set(np.flatnonzero(change > 0.2)) <= set(np.flatnonzero(hidden[-1]))
    assert (change[hidden[-1]] > 0.02).all()


def test_each_hidden_place_costs(model: Model) -> None:
    images = [taken(model, asked, asked) for asked in ASKED]
    _, readings = read(LitTarget(model, CAMERA, POSE, POSITIONS), images)
    one, two = np.zeros((2, *readings.known.shape), dtype=bool)
    one[-1, 0] = two[-1, :2] = True
    assert log_of_hidden(readings, two) < log_of_hidden(readings, one) < 0.0
