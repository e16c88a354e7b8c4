"""Brightness learnt beside model lines, against pictures that were lit by the same sum."""

from pathlib import Path

import numpy as np
import pytest

from geometry.model import Model, load_model
from geometry.visibility import visible_samples
from numerics.arrays import Floats
from tests.vision_server.prediction.lit_scenes import POSITIONS, lit
from tests.vision_server.synthetic import CAMERA, POSE, lines_alone
from vision_server.prediction.response import LitImage, learn_response


def contrasts(model: Model, image: LitImage) -> Floats:
    """Seen difference of the two sides of each sample, far from corners."""
    samples = visible_samples(model, CAMERA, POSE, 4.0)
    places = np.round(samples.image + np.array([[[-3.0]], [[3.0]]]) * samples.normal).astype(int)
    return np.asarray(np.diff(image.linear[places[..., 1], places[..., 0]], axis=0)[0])


def foreseen(model: Model, image: LitImage, known: list[LitImage], positions: list[object]) -> Floats:
    samples = visible_samples(model, CAMERA, POSE, 4.0)
    response = learn_response(samples, model, POSE, known, positions)  # type: ignore[arg-type]
    mean, _ = response.brightness(np.array([image.exposure]), image.lights[None])
    return np.asarray(np.diff(mean[0], axis=0)[0])


def test_light_that_was_seen_alone_is_foreseen_in_any_mixture(model: Model) -> None:
    known = [lit(model, (0.0, 0.0), 8.0), lit(model, (1.0, 0.0)), lit(model, (0.0, 1.0))]
    asked = lit(model, (0.6, 0.3), 1.4)
    error = foreseen(model, asked, known, [None, None]) - contrasts(model, asked)
    assert np.median(np.abs(error)) < 0.04


def test_a_light_never_seen_is_foreseen_by_lambert_where_its_place_is_known(model: Model) -> None:
    known = [lit(model, (0.0, 0.0), 8.0), lit(model, (1.0, 0.0))]
    asked = lit(model, (0.0, 1.0))
    seen = contrasts(model, asked)
    with_place = np.corrcoef(foreseen(model, asked, known, list(POSITIONS)), seen)[0, 1]
    without = np.corrcoef(foreseen(model, asked, known, [None, None]), seen)[0, 1]
    assert with_place > 0.9
    assert with_place > without


def test_of_lines_alone_the_place_of_a_light_tells_nothing(model: Model, tmp_path: Path) -> None:
    known, asked = [lit(model, (0.0, 0.0), 8.0), lit(model, (1.0, 0.0))], lit(model, (0.0, 1.0))
    wire = load_model(lines_alone(model, tmp_path))
    there, anywhere = (foreseen(wire, asked, known, list(places)) for places in (POSITIONS, (None, None)))
    assert there == pytest.approx(anywhere)


def test_what_is_less_known_varies_more(model: Model) -> None:
    samples = visible_samples(model, CAMERA, POSE, 4.0)
    few = learn_response(samples, model, POSE, [lit(model, (1.0, 0.0))], POSITIONS)
    more = learn_response(samples, model, POSE, [lit(model, (1.0, 0.0)), lit(model, (0.0, 1.0))], POSITIONS)
    asked = np.array([1.0]), np.array([[0.0, 1.0]])
    assert np.median(more.brightness(*asked)[1]) < 0.5 * np.median(few.brightness(*asked)[1])


@pytest.mark.parametrize("exposure", [4.0, 40.0])
def test_a_clipped_reading_decides_little(model: Model, exposure: float) -> None:
    glare = lit(model, (1.0, 1.0), exposure)
    good = lit(model, (1.0, 1.0))
    asked = lit(model, (1.0, 1.0), 0.5)
    error = foreseen(model, asked, [glare, good], list(POSITIONS)) - contrasts(model, asked)
    assert np.median(np.abs(error)) < 0.05


def test_a_light_that_no_image_had_alone_leaves_the_brightness_uncertain(model: Model) -> None:
    samples = visible_samples(model, CAMERA, POSE, 4.0)
    response = learn_response(samples, model, POSE, [lit(model, (1.0, 1.0))], POSITIONS)
    both, one, none = response.uncertainty(np.array([[1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]))
    assert both < 0.1 < one < none
