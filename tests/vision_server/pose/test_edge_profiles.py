"""Lines placed by their profiles: nearer to the truth where a target is plain, untouched where it is not."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from geometry.model import Model
from geometry.pose import disturbed
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture, one_image, photographed
from vision_server.channels.gradients import GradientChannel
from vision_server.pose.edge_profiles import GUARD, STEP_PX, free_sides, placed_by_profiles
from vision_server.pose.line_scales import line_scales
from vision_server.pose.observation import Measurement, measure
from vision_server.pose.refinement import NOMINAL_TONE_SD_PX, Solution, refine, sharpened

Floats = NDArray[np.float64]


def channels_of(pixels: NDArray[np.uint8]) -> list[GradientChannel]:
    channels = one_image(pixels, 1.0).gradients(["i1"])
    channels[0].prepare(2)
    return channels


def measured(channels: list[GradientChannel], model: Model) -> Measurement:
    return measure(channels, model, CAMERA, POSE, 3.0, np.zeros((1, len(model.lines)), np.int64), 2.0)


def solved(channels: list[GradientChannel], model: Model, seed: int) -> Solution:
    start = disturbed(POSE, np.random.default_rng(seed), 0.5, 1.0, CAMERA.fx)
    scale = line_scales(channels, model, CAMERA, start, 4.0)
    solution = refine(channels, model, CAMERA, start, scale)
    assert solution is not None
    return solution


def test_placed_lines_are_nearer_to_the_truth_than_maxima(model: Model) -> None:
    """Over seeds of noise, measured at the true pose, where every offset is an error."""
    maxima, placed = [], []
    for seed in range(6):
        channels = channels_of(
            photographed(linear_picture(model, CAMERA, POSE), noise_sd_grey=4.0, seed=seed)
        )
        before = measured(channels, model)
        after = placed_by_profiles(before, channels, len(model.lines))
        assert after is not None
        by_profile = ~np.isnan(after.common) & np.isfinite(before.offset)
        for line in np.unique(before.samples.line).tolist():
            of_line = by_profile[0] & (before.samples.line == line)
            if of_line.any():
                maxima.append(float(before.offset[0, of_line].mean()))
                placed.append(float(after.offset[0, of_line].mean()))
    assert len(placed) >= 40
    assert np.std(placed) < 0.8 * np.std(maxima)
    assert abs(np.mean(placed)) < 0.02


def test_stated_noise_of_placed_edge_points_is_their_scatter(model: Model) -> None:
    channels = channels_of(photographed(linear_picture(model, CAMERA, POSE), noise_sd_grey=4.0, seed=3))
    after = placed_by_profiles(measured(channels, model), channels, len(model.lines))
    assert after is not None
    by_profile = ~np.isnan(after.common[0])
    assert np.std(after.offset[0, by_profile] / after.sd[0, by_profile]) == pytest.approx(1.0, abs=0.2)


def test_texture_beside_the_lines_leaves_all_as_it_is(model: Model) -> None:
    picture = linear_picture(model, CAMERA, POSE)
    blobs = np.random.default_rng(1).normal(0.0, 1.0, (60, 80)).repeat(4, axis=0).repeat(4, axis=1)
    channels = channels_of(photographed(picture + 0.05 * blobs, noise_sd_grey=1.0, seed=0))
    solution = solved(channels, model, 0)
    assert sharpened(channels, solution, len(model.lines)) is solution


def test_a_nominal_tone_curve_leaves_all_as_it_is(model: Model) -> None:
    channels = channels_of(photographed(linear_picture(model, CAMERA, POSE), noise_sd_grey=4.0, seed=0))
    solution = solved(channels, model, 0)
    assert sharpened(channels, solution, len(model.lines)) is not solution
    nominal = replace(solution, tone_sd_px=NOMINAL_TONE_SD_PX)
    assert sharpened(channels, nominal, len(model.lines)) is nominal


def test_saturated_sides_are_not_placed(model: Model) -> None:
    channels = channels_of(photographed(np.minimum(1.0, 3.0 * linear_picture(model, CAMERA, POSE)), seed=0))
    after = placed_by_profiles(measured(channels, model), channels, len(model.lines))
    assert after is None


def test_free_sides_keep_clear_of_other_lines_and_ends(model: Model) -> None:
    channels = channels_of(photographed(linear_picture(model, CAMERA, POSE), seed=0))
    found = measured(channels, model)
    line, image, lines = found.samples.line, found.samples.image, len(model.lines)
    reach = 12.0
    free = free_sides(line, image, found.normal, found.from_end, np.full(lines, reach), np.full(lines, GUARD))
    ends = {k: image[line == k][[0, -1]] for k in np.unique(line).tolist()}
    for i in range(0, len(line), 3):
        for side, sign in ((0, -1.0), (1, 1.0)):
            away = np.arange(0.0, reach + 1e-9, STEP_PX)
            places = image[i] + sign * away[:, None] * found.normal[i]
            near = np.full(len(away), np.inf)
            for k, (a, b) in ends.items():
                if k != line[i]:
                    share = np.clip((places - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
                    near = np.minimum(near, np.linalg.norm(places - a - share[:, None] * (b - a), axis=1))
            met = np.flatnonzero(near < GUARD)
            expected = reach if len(met) == 0 else away[met[0]] - STEP_PX
            assert free[i, side] == (0.0 if found.from_end[i] < GUARD else expected)
