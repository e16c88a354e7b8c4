"""Poses on whole lines: what rounded edges do to them, and what lines that are off do to the covariance."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.printed_boxes import sharp
from geometry.model import Model, load_model
from numerics.arrays import Floats
from tests.vision_server.synthetic import CAMERA, lines_alone
from tests.vision_server.tracking.boxes import TURNS, pictured, plain_box, seen_at
from tests.vision_server.tracking.plain_roundings import plain_shifts
from tests.vision_server.tracking.plain_solved import plainly_solved
from vision_server.pose.observation import observe
from vision_server.pose.roundings import outward_of
from vision_server.tracking import fitting
from vision_server.tracking.fitting import Habits, fitted, none_or_rounded, rounded_odds, solved
from vision_server.tracking.frame import Tone, Window, problem_of
from vision_server.tracking.lines import LineFits, line_fits, rounding_shifts

TONE = Tone.of(1.0, 0.01)
SPACING_PX = 2.0


def test_outlines_of_rounded_boxes_lie_where_the_shift_says() -> None:
    radius, offsets, shifts = 0.005, [], []
    box = plain_box(radius)
    for turn in TURNS:
        pose = seen_at(turn)
        problem = problem_of(Window(pictured(box, pose), CAMERA), sharp(box), TONE)
        seen = observe(problem, pose, 4.0, SPACING_PX)
        shift, slack = rounding_shifts(problem, pose, seen)
        held = np.isfinite(seen.offset[0]) & (slack == 0.0) & (seen.from_end > 6.0)
        offsets.append(seen.offset[0, held])
        shifts.append(radius * shift[held])
    offset, shift = np.concatenate(offsets), np.concatenate(shifts)
    assert np.abs(shift).max() > 1.5
    assert np.median(np.abs(offset - shift)) < 0.2
    assert np.median(np.abs(offset)) > 0.5


def test_of_lines_alone_none_is_rounded_and_none_an_outline(model: Model, tmp_path: Path) -> None:
    wire, pose = load_model(lines_alone(model, tmp_path)), seen_at(TURNS[0])
    problem = problem_of(Window(np.zeros((CAMERA.height, CAMERA.width), np.uint8), CAMERA), wire, TONE)
    seen = observe(problem, pose, 3.0, SPACING_PX)
    assert not np.any(rounding_shifts(problem, pose, seen))
    assert not outward_of(wire, CAMERA, pose, seen.samples).any()


@pytest.mark.parametrize("turn", TURNS)
def test_the_kernel_of_rounded_edges_does_as_numpy_does(model: Model, turn: list[float]) -> None:
    for one in (model, sharp(plain_box(0.001))):
        pose = seen_at(turn)
        problem = problem_of(Window(np.zeros((CAMERA.height, CAMERA.width), np.uint8), CAMERA), one, TONE)
        seen = observe(problem, pose, 3.0, SPACING_PX)
        shift, slack = rounding_shifts(problem, pose, seen)
        assert shift.any()
        assert slack.any()
        expected = plain_shifts(problem, pose, seen)
        np.testing.assert_allclose(shift, expected[0], rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(slack, expected[1], rtol=1e-9, atol=1e-9)


def test_a_line_that_is_off_and_turned_is_told_so() -> None:
    box = plain_box(0.0005)
    pose = seen_at(TURNS[0])
    problem = problem_of(Window(pictured(box, pose), CAMERA), sharp(box), TONE)
    seen = observe(problem, pose, 3.0, SPACING_PX)
    line = int(np.bincount(seen.samples.line).argmax())
    moved = np.where(seen.samples.line == line, 0.7 + 0.4 * seen.along, 0.0)
    zeros, base = np.zeros(len(moved)), np.isfinite(seen.offset).astype(float)
    before = line_fits(seen, base, zeros, zeros)
    after = line_fits(seen._replace(offset=np.ascontiguousarray(seen.offset + moved)), base, zeros, zeros)
    change = after.value - before.value
    assert np.abs(change[:, 0]).max() > 0.5
    changed = np.abs(change).max(axis=1) > 1e-3
    assert changed.sum() == 1
    row = int(np.flatnonzero(changed)[0])
    held = (seen.samples.line == line) & np.isfinite(seen.offset[0])
    np.testing.assert_allclose(change[row, 0], np.mean(moved[held]), atol=0.05)
    np.testing.assert_allclose(change[row, 1], 0.4, atol=0.05)


def test_the_covariance_covers_the_errors_of_rounded_boxes_and_tells_when_lines_are_off() -> None:
    squares, sharper = [], []
    for number, turn in enumerate(TURNS):
        pose = seen_at(turn)
        spread = []
        for radius in (0.0002, 0.002):
            box = plain_box(radius)
            problem = problem_of(Window(pictured(box, pose, number), CAMERA), sharp(box), TONE)
            fit = fitted(problem, pose, 3.0, SPACING_PX, Habits.of(sharp(box)))
            assert fit is not None
            step = pose.step_from(fit.pose)
            squares.append(step @ np.linalg.solve(fit.covariance, step))
            spread.append(fit.off_px2)
        sharper.append(spread[0] < spread[1])
    assert np.max(squares) < 16.81
    assert all(sharper)


def test_what_was_learnt_moves_slowly_to_what_frames_say() -> None:
    box = plain_box(0.003)
    pose = seen_at(TURNS[0])
    problem = problem_of(Window(pictured(box, pose), CAMERA), sharp(box), TONE)
    first = habits = Habits.of(sharp(box))
    for _ in range(150):
        fit = fitted(problem, pose, 3.0, SPACING_PX, habits)
        assert fit is not None
        habits = habits.after(fit)
    assert habits.radius_sd_m < first.radius_sd_m
    assert 0.0 <= habits.radius_m < 0.006
    assert habits.seen > first.seen


@pytest.mark.parametrize("radius", [None, 0.0, 0.002])
def test_the_kernel_solves_as_numpy_does(radius: float | None) -> None:
    rng = np.random.default_rng(0)
    habits = Habits.of(sharp(plain_box(0.001)), radius)
    for count in (4, 9):
        variance = rng.uniform(0.001, 0.1, (count, 2))
        variance[1, 1] = np.inf
        rows = rng.normal(size=(count, 2, 9)) * [500, 500, 500, 1e3, 1e3, 1e3, 0.1, 0.1, 300]
        value = 0.3 * rng.standard_t(3, (count, 2))
        lines = LineFits(value, variance, rows, rng.uniform(0, 300, count), np.arange(count))
        prior = np.r_[np.repeat([1.0, 4.0], 3), 100.0, 100.0, habits.radius_sd_m**-2.0]
        row = np.array([1, 0, -1, 1, 2, 2, 0, -2, 0])[:count]
        for one, other in zip(
            solved(lines, prior, habits, row), plainly_solved(lines, prior, habits, row), strict=True
        ):
            np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("mean", [-2.0, 0.1, 1.5])
def test_a_radius_is_none_or_more_than_none_and_the_pose_goes_with_it(mean: float) -> None:
    rng = np.random.default_rng(0)
    at_first, sd, before = 1.5, 0.8, 3.0
    covariance = np.array([[2.0, -1.1 * sd], [-1.1 * sd, sd**2]])
    drawn = rng.multivariate_normal([0.3, mean], covariance, 400_000)
    rounded = drawn[drawn[:, 1] > 0.0]
    density = np.exp(-0.5 * (mean / sd) ** 2) / sd / (len(rounded) / len(drawn))  # at 0, of the radius now
    odds = before * (2.0 / at_first) / density
    free = drawn - np.outer(drawn[:, 1], covariance[:, 1] / sd**2)  # with a radius of 0
    sharp_ones = rng.random(len(rounded)) > odds / (1.0 + odds)
    mixed = np.where(sharp_ones[:, None], free[: len(rounded)], rounded)
    unknowns, after = none_or_rounded(np.array([0.3, mean]), covariance, at_first, before)
    np.testing.assert_allclose(unknowns, mixed.mean(axis=0), atol=0.02)
    np.testing.assert_allclose(after, np.cov(mixed.T), atol=0.04)


def test_a_radius_that_is_far_below_none_is_none() -> None:
    unknowns, covariance = none_or_rounded(np.array([1.0, -500.0]), np.eye(2), 1.0, 1.0)
    assert 0.0 <= unknowns[1] < 0.05
    assert 0.0 < covariance[1, 1] < 0.01


def test_lines_that_are_true_tell_of_sharp_edges() -> None:
    assert rounded_odds(0.02**2, 11.0) < 0.3
    assert rounded_odds(0.25**2, 11.0) > 10.0
    assert rounded_odds(0.0, 0.0) == rounded_odds(0.2**2, 1.0) > 10.0


def test_lines_that_are_off_by_a_tenth_of_a_pixel_do_not_tell_of_sharp_edges() -> None:
    assert rounded_odds(0.05**2, 12.0) < 0.2
    assert rounded_odds(0.1**2, 12.0) > 1.0


def test_creases_count_less_where_the_radius_is_hardly_known(monkeypatch: pytest.MonkeyPatch) -> None:
    """Their edge may be anywhere on the rounding, also where a radius of nought is the likeliest."""

    def hardly_known(unknowns: Floats, covariance: Floats, *_: float) -> tuple[Floats, Floats]:
        unknowns, covariance = unknowns.copy(), covariance.copy()
        unknowns[-1], covariance[-1, -1] = 0.0, 0.002**2
        return unknowns, covariance

    box, pose = plain_box(0.0002), seen_at(TURNS[0])
    problem = problem_of(Window(pictured(box, pose), CAMERA), sharp(box), TONE)
    monkeypatch.setattr(fitting, "none_or_rounded", hardly_known)
    monkeypatch.setattr(fitting, "solved", plainly_solved)
    spread = []
    for share in (0.0, 1.0):

        def shifts(*seen: Any, share: float = share) -> tuple[Floats, Floats]:
            shift, slack = rounding_shifts(*seen)
            return shift, share * slack

        monkeypatch.setattr(fitting, "rounding_shifts", shifts)
        fit = fitted(problem, pose, 3.0, SPACING_PX, Habits.of(sharp(box)))
        assert fit is not None
        spread.append(np.linalg.det(fit.covariance))
    assert spread[1] > 2.0 * spread[0]


def test_the_range_of_rounded_boxes_is_not_too_far() -> None:
    apart = []
    for number, turn in enumerate(TURNS):
        box, pose = plain_box(0.0012), seen_at(turn)
        problem = problem_of(Window(pictured(box, pose, number), CAMERA), sharp(box), TONE)
        fit = fitted(problem, pose, 3.0, SPACING_PX, Habits.of(sharp(box)))
        assert fit is not None
        apart.append(np.linalg.norm(fit.pose.translation) / np.linalg.norm(pose.translation) - 1.0)
    assert abs(np.mean(apart)) < 0.0035


def test_frames_that_say_nothing_of_the_radius_leave_it_where_it_was() -> None:
    box, pose = plain_box(0.003), seen_at(TURNS[0])
    problem = problem_of(Window(pictured(box, pose), CAMERA), sharp(box), TONE)
    first = Habits.of(sharp(box))
    fit = fitted(problem, pose, 3.0, SPACING_PX, first)
    assert fit is not None
    silent = replace(fit, radius_information=(0.0, 0.0))
    after = first.after(silent)
    assert (after.radius_m, after.radius_sd_m) == (first.radius_m, pytest.approx(first.radius_sd_m))


@pytest.mark.slow
def test_a_radius_that_is_told_puts_rounded_boxes_where_they_are() -> None:
    radius, box = 0.005, plain_box(0.005)
    off = {}
    for told in (None, radius, 0.0):
        habits, errors = Habits.of(sharp(box), told), []
        for number, turn in enumerate(TURNS):
            pose = seen_at(turn)
            problem = problem_of(Window(pictured(box, pose, number), CAMERA), sharp(box), TONE)
            fit = fitted(problem, pose, 4.0, SPACING_PX, habits)
            assert fit is not None
            errors.append(fit.pose.error_to(pose).translation_m / pose.translation[2])
            if told is not None:
                assert abs(fit.radius_m - told) < 0.3 * radius
        off[told] = float(np.median(errors))
    assert off[radius] < 0.6 * off[None]
    assert off[radius] < 0.3 * off[0.0]
