"""The last step of a pose: lines that are off as wholes, and parts whose axes are not the model's."""

from dataclasses import replace

import numpy as np
import pytest

from experiments.kinds.estimate import normalised_error_squared
from geometry.model import Model
from geometry.pose import Pose
from tests.vision_server.refined_poses import GREYS, channels_of, drawn_courses, found
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture, one_image, photographed
from vision_server import pipeline
from vision_server.pose import profiles
from vision_server.pose.courses import BLUR, COURSE_PRIOR_SHARE, ROUNDNESS, courses_of
from vision_server.pose.observation import observe
from vision_server.pose.sampling import spacing_for
from vision_server.pose.steps import moved
from vision_server.pose.weights import base_weights
from vision_server.trust.settling import (
    BLUR_PRECISION,
    LEAST_COVARIANCE_FACTOR,
    STRETCH,
    T_FREEDOM,
    agreed,
    as_seen,
    of_true_axes,
    of_true_range,
    scatter_of,
    settled,
)
from vision_server.trust.stretch import stretched

PRIOR = np.r_[np.r_[np.full(3, 0.3), np.full(3, 0.05), 0.01, 0.8] ** -2.0, BLUR_PRECISION]


@pytest.mark.parametrize("seed", range(4))
def test_lines_that_lie_on_shadows_do_not_outvote_those_that_agree(seed: int) -> None:
    courses, true = drawn_courses(12, seed)
    step, covariance = agreed(courses, PRIOR)
    courses.place[:3] += (2.5, 0.0)
    moved_step, moved_covariance = agreed(courses, PRIOR)
    off = np.sqrt(np.mean((courses.motion[3:] @ (moved_step - true)) ** 2))
    plainly = np.linalg.lstsq(courses.motion[:, :, :6].reshape(-1, 6), courses.place.ravel(), rcond=None)[0]
    assert off < 0.1  # px
    assert np.sqrt(np.mean((courses.motion[3:, :, :6] @ (plainly - true[:6])) ** 2)) > 0.2
    assert np.trace(moved_covariance[:6, :6]) > np.trace(covariance[:6, :6])
    np.testing.assert_allclose(courses.motion @ step, courses.motion @ true, atol=0.15)


@pytest.mark.parametrize("seed", range(4))
def test_outlines_that_blur_moves_alike_do_not_move_the_pose(seed: int) -> None:
    courses, true = drawn_courses(12, seed)
    courses.motion[:, 0, BLUR] = np.random.default_rng(seed).choice([-0.3, 0.3], 12)
    courses.place[:] += courses.motion[:, :, BLUR]
    step, _ = agreed(courses, PRIOR)
    unaware, _ = agreed(courses, np.r_[PRIOR[:-1], 1e9])
    off, before = (
        np.sqrt(np.mean((courses.motion[:, :, :6] @ (one - true)[:6]) ** 2)) for one in (step, unaware)
    )
    assert off < 0.5 * before
    assert step[BLUR] == pytest.approx(1.0, abs=0.3)


def test_the_course_of_a_line_is_the_weighted_straight_line_through_its_edge_points(
    model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And the motion of its unknowns is theirs under the same weights."""
    monkeypatch.setattr(profiles, "MOST_MOVED_PX", 0.0)
    best = found(model, model, 1)
    spacing = spacing_for(model, CAMERA, best.pose)
    seen = observe(best.problem, best.pose, 3.0, spacing)
    more = np.random.default_rng(0).normal(size=(len(seen.along), 2))
    base = base_weights(seen, True)
    courses = courses_of(best.problem, seen, more)
    line, number = seen.samples.line, 0
    for own in np.unique(line):
        (at,) = np.nonzero((line == own) & (base[0] > 0))
        if len(at) < 2:
            continue
        t = np.stack([np.ones(len(at)), seen.along[at]])
        residual, weight = np.zeros(len(at)), base[0, at]
        for round_ in range(4):
            cut = 1.5 if round_ == 0 else max(0.55, 4.685 * 1.4826 * np.median(np.abs(residual[weight > 0])))
            weight = base[0, at] * np.maximum(0.0, 1.0 - (residual / cut) ** 2) ** 2
            normal = (t * weight) @ t.T + COURSE_PRIOR_SHARE * weight.sum() * np.eye(2)
            course = np.linalg.solve(normal, (t * weight) @ seen.offset[0, at])
            residual = seen.offset[0, at] - course @ t
        rows = np.hstack([seen.jacobian, seen.nuisance[0], np.zeros((len(more), 1)), more])[at]
        np.testing.assert_allclose(courses.place[number], course, atol=1e-9)
        np.testing.assert_allclose(
            courses.motion[number], np.linalg.solve(normal, (t * weight) @ rows), rtol=1e-6, atol=1e-6
        )
        number += 1
    assert number == len(courses.share) == 9


def test_a_part_whose_axes_are_half_a_percent_off_is_where_it_is_seen(model: Model) -> None:
    part = stretched(model, np.array([0.008, -0.007, 0.0]))
    errors, squares = [], []
    for seed in range(4):
        best = found(part, model, seed)
        last = settled(best)
        assert last is not None
        errors.append([one.pose.error_to(POSE).rotation_deg for one in (best, last.best)])
        squares.append(normalised_error_squared(last.best.pose, last.covariance, POSE))
    before, after = np.mean(errors, axis=0)
    assert after < 0.5 * before, errors
    assert np.mean(squares) < 12.0


@pytest.mark.parametrize("axis", range(3))
def test_a_part_one_axis_of_which_is_too_long_is_where_the_other_two_have_it(model: Model, axis: int) -> None:
    """Shared by all axes, two percent would move it by two thirds of a percent of the range."""
    errors = []
    for by, seed in ((0.02, 0), (-0.02, 1)):
        last = settled(found(stretched(model, by * np.eye(3)[axis]), model, seed))
        assert last is not None
        error = last.best.pose.error_to(POSE)
        errors.append((error.rotation_deg, error.translation_fraction_of_range))
    assert np.max(errors, axis=0)[0] < 0.2, errors
    assert np.max(errors, axis=0)[1] < 0.002, errors


def test_the_range_of_a_stretched_part_is_as_uncertain_as_the_axis_that_tells_it(model: Model) -> None:
    """As drawn unknowns make it, each with the pose that they lead to."""
    random = np.random.default_rng(5)
    root = random.normal(0.0, 1e-5, (ROUNDNESS + 1, ROUNDNESS + 1))
    root[STRETCH] *= 10.0
    step = np.zeros(len(root))
    step[STRETCH] = 0.004, -0.005
    ends = [
        of_true_axes(moved(POSE, one[:6], POSE.translation), model, one).translation
        for one in step + random.normal(0.0, 1.0, (4000, len(root))) @ root.T
    ]
    told = of_true_range(POSE, model, step, root @ root.T)[3:, 3:]
    spread = np.sqrt(np.diag(told))
    np.testing.assert_allclose(
        np.cov(np.array(ends).T) / np.outer(spread, spread), told / np.outer(spread, spread), atol=0.1
    )


def test_the_lines_of_another_part_do_not_agree(model: Model) -> None:
    """They lie where it has them; those of a longer part lie beside them, or the pose beside its place."""
    shares = []
    for scales in ((0.0, 0.0, 0.0), (0.12, 0.0, 0.0), (0.0, 0.0, -0.12)):
        last = settled(found(stretched(model, np.array(scales)), model, 2))
        assert last is not None
        assert last.agreement is not None
        shares.append(last.agreement.share)
    assert shares[0] > 0.9
    assert max(shares[1:]) < 0.9, shares
    assert min(shares[1:]) < 0.5, shares


def test_a_part_that_is_as_its_model_stays_where_it_was_found(model: Model) -> None:
    squares = []
    for seed in range(6):
        best = found(model, model, seed)
        last = settled(best)
        assert last is not None
        assert last.best.pose.error_to(best.pose).rotation_deg < 0.1
        squares.append(normalised_error_squared(last.best.pose, last.covariance, POSE))
    assert np.mean(squares) < 10.0


def test_the_last_step_is_no_advantage_over_rivals_that_have_not_taken_it(
    model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = found(model, model, 0)
    less = replace(
        first.support, supports=first.support.supports & (np.arange(len(first.support.distance)) % 2 == 0)
    )
    refined = replace(first, support=less)
    last = settled(refined)
    assert last is not None
    assert last.best.support.evidence > less.evidence + 5.0
    beside = Pose(POSE.rotation_vector, 1.05 * POSE.translation)
    rival = replace(refined, solution=replace(refined.solution, pose=beside))
    monkeypatch.setattr(pipeline, "best_first", lambda *_, **__: [refined, rival])
    pixels = photographed(linear_picture(model, CAMERA, POSE, GREYS), seed=0)
    assert pipeline.estimate_pose(one_image(pixels), ["i1"], model, CAMERA, POSE).ambiguity == 1.0


def test_nothing_to_hold_on_to_settles_nothing(model: Model) -> None:
    best = found(model, model, 0)
    dark = replace(best.problem, channels=channels_of(np.zeros((240, 320), dtype=np.uint8)))
    assert settled(replace(best, problem=dark)) is None


def test_lines_that_scatter_more_or_are_softer_make_a_pose_less_certain() -> None:
    courses, _ = drawn_courses(12, 0)
    soft = courses._replace(spread=10.0 * courses.spread)
    assert as_seen(1.0, soft) > as_seen(1.0, courses) > as_seen(0.5, courses)
    assert as_seen(0.0, courses) == LEAST_COVARIANCE_FACTOR


@pytest.mark.parametrize("factor", [0.25, 1.0, 4.0])
def test_the_scatter_of_lines_is_what_it_was(factor: float) -> None:
    random = np.random.default_rng(0)
    squares = factor * random.chisquare(2, 4000) / (random.chisquare(T_FREEDOM, 4000) / T_FREEDOM)
    assert scatter_of(squares, np.ones(4000)) == pytest.approx(factor, rel=0.1)
