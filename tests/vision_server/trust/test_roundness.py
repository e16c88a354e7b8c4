"""Poses of round parts whose models have few facets a turn are right, and as uncertain as they say."""

import numpy as np
import pytest

from benchmarks.synthetic_parts import error_of, estimated, part_of, random_view, rendered
from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose, disturbed
from geometry.symmetries import symmetry_of
from geometry.visibility import Samples
from numerics.arrays import Floats
from vision_server.pose.courses import ROUNDNESS
from vision_server.trust import settling
from vision_server.trust.judgement import Estimate
from vision_server.trust.roundness import has_facets

CAMERA = Camera(640, 480, 768.0, 768.0, 319.5, 239.5)
SHAPES = ("ring", "flange")


def model_of(shape: str, segments: int) -> Model:
    return Model.of_surface(shape, part_of(shape, segments, np.random.default_rng(0)))


def found(shape: str, seed: int, drawn: int, told: int) -> tuple[Estimate, Pose]:
    """What is estimated of a picture of so many facets a turn with a model of others, and the true pose."""
    random, part = np.random.default_rng(seed), model_of(shape, drawn)
    true = random_view(random, part, CAMERA)
    pixels = rendered(part, CAMERA, true, random)
    start = disturbed(true, random, 2.0, 3.0, CAMERA.fx)
    return estimated(pixels, model_of(shape, told), CAMERA, start), true


@pytest.mark.parametrize("shape", SHAPES)
def test_a_smooth_part_is_found_as_exactly_as_stated_by_a_model_of_few_facets(shape: str) -> None:
    """Of places alone, whose squared normalised error is 3 where the covariance is honest."""
    squares = []
    for seed in range(3):
        estimate, true = found(shape, seed, 128, 32)
        assert estimate.pose is not None
        assert estimate.covariance is not None
        assert error_of(estimate.pose, true, symmetry_of(model_of(shape, 32))).within(0.2, 0.001)
        off = estimate.pose.translation - true.translation
        squares.append(float(off @ np.linalg.solve(np.asarray(estimate.covariance)[3:, 3:], off)))
    assert np.mean(squares) < 9.0, squares


@pytest.mark.parametrize("told", [("ring", 14), ("ring", 16), ("cylinder", 16), ("cylinder", 17)])
def test_a_smooth_part_is_as_far_as_it_is_by_a_model_far_inside_of_it(told: tuple[str, int]) -> None:
    """By the mesh it is 1 to 2 % of the range nearer, and most of its lines are nevertheless seen."""
    shape, facets = told
    estimate, true = found(shape, 0, 128, facets)
    assert estimate.pose is not None
    assert error_of(estimate.pose, true, symmetry_of(model_of(shape, 128))).within(0.2, 0.004)
    assert estimate.supported_fraction > 0.85
    assert estimate.score > 0.95


@pytest.mark.parametrize("shape", SHAPES)
def test_a_part_that_has_its_models_facets_is_found_as_by_these(
    shape: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    estimate, _ = found(shape, 0, 64, 64)

    def none(model: Model, pose: Pose, samples: Samples, jacobian: Floats) -> Floats:
        return np.empty((len(samples.line), 0))

    monkeypatch.setattr(settling, "beyond_chords", none)
    without, _ = found(shape, 0, 64, 64)
    assert estimate.pose is not None
    assert without.pose is not None
    np.testing.assert_allclose(estimate.pose.translation, without.pose.translation, atol=1e-9)
    np.testing.assert_allclose(np.asarray(estimate.covariance), np.asarray(without.covariance), rtol=1e-6)


def test_facets_are_told_where_none_of_what_they_lack_is_seen_and_clearly_so() -> None:
    def told(roundness: float, sd: float) -> bool:
        step, covariance = np.zeros(ROUNDNESS + 1), np.eye(ROUNDNESS + 1)
        step[ROUNDNESS], covariance[ROUNDNESS, ROUNDNESS] = roundness, sd**2
        return has_facets(step, covariance)

    assert told(0.0, 0.1)
    assert told(-0.2, 0.2)
    assert not told(0.0, 0.9)  # hardly told at all
    assert not told(0.5, 0.1)
    assert not told(1.0, 0.1)
    assert not has_facets(np.zeros(ROUNDNESS), np.eye(ROUNDNESS))  # no round part
