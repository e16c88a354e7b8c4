"""What settings are said to add, where the answer is plain."""

from dataclasses import replace

import numpy as np
import pytest

from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Floats, Ints
from tests.vision_server.prediction.lit_scenes import POSITIONS, lit
from tests.vision_server.synthetic import CAMERA, POSE
from vision_server.prediction.belief import Belief
from vision_server.prediction.information import (
    Candidates,
    Forecast,
    Known,
    Sensor,
    View,
    blur_inputs,
    spread_samples,
)

SENSOR = Sensor(full_scale_e=10000.0, read_noise_e=4.0, gamma=1.0)


def candidates(rows: list[tuple[float, float, float]]) -> Candidates:
    """Rows of exposure and two lights' outputs, all of the same shutter and aperture."""
    table = np.array(rows)
    shutter, aperture = np.full(len(rows), 1 / 60), np.full(len(rows), 4.0)
    return Candidates(table[:, 0], table[:, 1:], blur_inputs(shutter, aperture, 4.0, 1 / 60))


def before(model: Model, support: Floats | None = None, images: int = 1, scatter_px2: float = np.nan) -> View:
    """The model before the camera, all of it seen if nothing is said, how its edges stray not measured."""
    lines = len(model.lines)
    scatter = np.full((images, lines), scatter_px2)
    return View(model, CAMERA, POSE, np.ones(lines) if support is None else support, scatter)


def gains(
    model: Model,
    taken: list[tuple[float, float, float]],
    asked: list[tuple[float, float, float]],
    support: Floats | None = None,
) -> tuple[Floats, Ints]:
    images = [lit(model, row[1:], row[0]) for row in taken]
    view = before(model, support, len(taken))
    return Forecast(view, images, candidates(taken), POSITIONS, SENSOR).gains(candidates(asked))


def test_darkness_adds_nothing_and_light_that_was_missing_much(model: Model) -> None:
    bits, _ = gains(model, [(0.02, 1.0, 0.0)], [(0.001, 0.0, 0.0), (1.0, 0.0, 1.0)])
    assert bits[0] < 0.3
    assert bits[1] > 3.0


def test_glare_adds_less_than_a_proper_exposure(model: Model) -> None:
    bits, _ = gains(model, [(0.05, 1.0, 1.0)], [(30.0, 1.0, 1.0), (0.8, 1.0, 1.0)])
    assert bits[0] < 0.5 * bits[1]


def test_more_of_the_same_adds_less_each_time(model: Model) -> None:
    row = (1.0, 1.0, 1.0)
    once, _ = gains(model, [row], [row])
    twice, _ = gains(model, [row, row], [row])
    assert 0.0 < twice[0] < once[0]


def test_a_sharp_image_adds_more_to_a_blurred_one_than_a_brighter_blurred_one_does(model: Model) -> None:
    shutter, aperture = np.array([1 / 60, 1 / 60, 1 / 1200]), np.full(3, 4.0)
    light = np.ones((3, 2))
    rows = Candidates(np.array([1.0, 1.0, 0.05]), light, blur_inputs(shutter, aperture, 4.0, 1 / 60))
    blurred = replace(lit(model, (1.0, 1.0)), blur_px=4.0)
    view = before(model)
    known = Forecast(view, [blurred], Candidates(*(part[:1] for part in rows)), POSITIONS, SENSOR)
    bits, _ = known.gains(rows)
    assert bits[2] > 2.0 * bits[1]


def test_light_that_may_show_unseen_lines_is_preferred_to_light_that_did_not(
    model: Model,
) -> None:
    support = np.ones(len(model.lines))
    support[::2] = 0.0
    bits, line = gains(model, [(1.0, 1.0, 0.0)], [(1.0, 1.0, 0.0), (1.0, 0.0, 1.0)], support)
    assert bits[1] > 2.0 * bits[0]
    assert support[line[1]] == 0.0


def test_lines_that_it_was_too_dark_for_are_expected_from_more_of_the_same_light(model: Model) -> None:
    half = np.ones(len(model.lines))
    half[::2] = 0.0
    asked = [(1.0, 1.0, 1.0)]
    unseen_adds = []
    for before in (0.002, 0.8):
        with_unseen, _ = gains(model, [(before, 1.0, 1.0)], asked, half)
        all_seen, _ = gains(model, [(before, 1.0, 1.0)], asked)
        unseen_adds.append(with_unseen[0] - all_seen[0])
    assert unseen_adds[0] > 2.0
    assert unseen_adds[1] < 0.5


def test_an_image_more_takes_nothing_away_and_only_noise_averages_out() -> None:
    rng = np.random.default_rng(1)
    precision, shared = rng.uniform(0.1, 100.0, (5, 40)), rng.uniform(0.01, 1.0, 5)
    for number in range(1, 5):
        known = Known(precision[:number], shared[:number])
        more = known.with_one_more(precision[number][None], shared[number : number + 1])[0]
        assert (more >= known.weight - 1e-12).all()
        np.testing.assert_allclose(more, Known(precision[: number + 1], shared[: number + 1]).weight)
    noisy, clean = np.full((1, 1), 0.01), np.full((1, 1), 1e6)
    alike = np.array([0.5])
    assert Known(noisy, alike).with_one_more(noisy, alike)[0, 0] > 1.9 * Known(noisy, alike).weight[0]
    assert Known(clean, alike).with_one_more(clean, alike)[0, 0] < 1.001 * Known(clean, alike).weight[0]


def test_lines_that_are_shown_for_the_first_time_speak_for_the_pose(model: Model) -> None:
    samples = spread_samples(model, CAMERA, POSE)
    lines = np.unique(samples.line)
    half = np.isin(samples.line, lines[: len(lines) // 2]).astype(np.float64)
    everything = np.ones((1, len(samples.line)))
    assert Belief(samples, half).gains(everything)[0] > 1.0
    assert Belief(samples, half).gains(half[None])[0] < 0.3
    assert Belief(samples, everything[0]).gains(everything).tolist() == [0.0]


def test_a_line_is_placed_worse_in_the_dark_and_better_the_more_light_there_is(model: Model) -> None:
    rows = [(1.0, 1.0, 1.0)]
    view = before(model)
    known = Forecast(view, [lit(model, rows[0][1:])], candidates(rows), POSITIONS, SENSOR)
    dark, dim, bright = known.line_sd(candidates([(1e-5, 1.0, 1.0), (0.02, 1.0, 1.0), (0.5, 1.0, 1.0)]))
    visible = np.unique(known.samples.line)
    hidden = np.setdiff1d(np.arange(len(model.lines)), visible)
    assert np.isinf(bright[hidden]).all()
    assert np.isinf(dark[visible]).mean() > 0.5
    assert np.isfinite(bright[visible]).all()
    assert (bright[visible] <= dim[visible]).all()


def test_lines_are_said_to_be_placed_as_edges_were_seen_to_stray(model: Model) -> None:
    rows = [(1.0, 1.0, 1.0)]
    images, asked = [lit(model, rows[0][1:])], candidates(rows)
    said = []
    for scatter_px in (0.1, 0.5):
        view = before(model, scatter_px2=scatter_px**2)
        sd = Forecast(view, images, asked, POSITIONS, SENSOR).line_sd(asked)[0]
        said.append(float(np.median(sd[np.isfinite(sd)])))
    assert said == pytest.approx([0.1, 0.5], rel=0.2)


def test_a_target_out_of_sight_gains_nothing(model: Model) -> None:
    behind = Pose(np.zeros(3), np.array([0.0, 0.0, -1.0]))
    view = before(model)._replace(pose=behind)
    images = [lit(model, (1.0, 1.0))]
    asked = candidates([(1.0, 1.0, 1.0)])
    bits, line = Forecast(view, images, asked, POSITIONS, SENSOR).gains(asked)
    assert bits.tolist() == [0.0]
    assert line.tolist() == [-1]
