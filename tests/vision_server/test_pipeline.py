"""From an image set to an estimate, and what is said when there is nothing to see."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from bridge.errors import BadInput
from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose, disturbed
from numerics.arrays import Floats, Grey
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture, one_image, photographed
from vision_server import pipeline
from vision_server.image_set import ImageSet
from vision_server.matchers import MATCHERS
from vision_server.matching import Hypothesis, match_search
from vision_server.pipeline import SURE_SCORE, PipelineSettings, estimate_pose
from vision_server.serve.results import estimate_result
from vision_server.trust.judgement import Estimate
from vision_server.trust.probability import confidence, quality
from vision_server.trust.support import CAP_PX


def estimated(pixels: Grey, model: Model, seed_pose: Pose = POSE, **settings: object) -> Estimate:
    return estimate_pose(
        one_image(pixels),
        ["i1"],
        model,
        CAMERA,
        seed_pose,
        PipelineSettings(**settings),  # type: ignore[arg-type]
    )


@pytest.fixture(scope="module")
def picture(model: Model) -> Floats:
    return linear_picture(model, CAMERA, POSE, (0.3, 0.7, 0.2, 0.9, 0.5, 0.8))


@pytest.mark.parametrize("seed", range(4))
def test_the_pose_is_found_from_anywhere_in_the_search_range(
    model: Model, picture: Floats, seed: int
) -> None:
    start = disturbed(POSE, np.random.default_rng(seed), 20.0, 20.0, CAMERA.fx)
    estimate = estimated(photographed(picture), model, start, seed=seed)
    assert estimate.pose is not None
    assert estimate.pose.error_to(POSE).within(0.3, 0.003)
    assert estimate.rms_px is not None
    assert estimate.rms_px < 1.0
    assert estimate.score > 0.5
    assert set(estimate.seconds) == {"edges", "linking", "matching", "refinement"}


@pytest.mark.parametrize("share", [(0.0, 0.0, 0.0), (0.5, 0.5, 0.0), (0.5, 0.5, 0.5), (-0.01, 0.0, 0.0)])
def test_where_the_file_has_its_origin_changes_no_search(
    model: Model,
    picture: Floats,
    share: tuple[float, float, float],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """At a corner of the box, on a face, in the middle, outside: 25 degrees and 40 px are the part's."""
    low, high = model.vertices.min(axis=0), model.vertices.max(axis=0)
    origin = low + np.array(share) * (high - low)
    moved, to_origin = replace(model, vertices=model.vertices - origin), Pose(np.zeros(3), origin)
    start = disturbed(POSE, np.random.default_rng(1), 25.0, 40.0, CAMERA.fx, model.middle)
    about: list[Pose] = []

    def match(ends: Floats, model: Model, camera: Camera, seed_pose: Pose, *more: Any) -> list[Hypothesis]:
        about.append(seed_pose.compose(Pose(np.zeros(3), model.middle)))
        assert seed_pose.error_to(about[0]).translation_m < 1e-9
        return match_search(ends, model, camera, seed_pose, *more)

    monkeypatch.setitem(MATCHERS, "search", match)
    estimate = estimated(photographed(picture), moved, start.compose(to_origin))
    assert about[0].error_to(start.compose(Pose(np.zeros(3), model.middle))).translation_m < 1e-9
    assert estimate.pose is not None
    assert estimate.pose.error_to(POSE.compose(to_origin)).within(0.3, 0.003)


def test_a_picture_that_comes_again_is_one_image(picture: Floats) -> None:
    images, once = ImageSet(CAMERA.width, CAMERA.height), photographed(picture)
    other = once.copy()
    other[0, 0] ^= 1
    black = np.zeros_like(once)
    for number, (pixels, exposure) in enumerate(
        [(once, 1.0), (other, 1.0), (once, 2.0), (black, 1.0), (black, 1.0)]
    ):
        images.add(f"i{number}", pixels, exposure, 1.0)
    assert [one.repeats for one in images.images.values()] == [None, None, "i0", None, None]
    assert images.distinct(["i2", "i1", "i0", "i4", "i3"]) == ("i2", "i1", "i4", "i3")


def test_the_same_inputs_give_the_same_numbers(model: Model, picture: Floats) -> None:
    start = disturbed(POSE, np.random.default_rng(5), 10.0, 10.0, CAMERA.fx)
    first, second = (estimate_result(estimated(photographed(picture), model, start)) for _ in range(2))
    first.pop("seconds")
    second.pop("seconds")
    assert first == second


@pytest.mark.parametrize("value", [0, 77, 255])
def test_an_image_of_one_grey_has_no_pose(model: Model, value: int) -> None:
    estimate = estimated(np.full((240, 320), value, np.uint8), model)
    assert estimate.pose is None
    assert estimate.rms_px is None
    assert estimate.score == 0.0
    assert estimate_result(estimate)["pose"] is None


def test_noise_alone_is_never_a_pose_with_a_good_score(model: Model) -> None:
    rng = np.random.default_rng(0)
    for _ in range(5):
        noise = np.clip(rng.normal(100, 20, (240, 320)), 0, 255).astype(np.uint8)
        estimate = estimated(noise, model)
        assert estimate.pose is None or estimate.score < 0.05


def test_another_scene_is_never_a_pose_with_a_good_score(model: Model, picture: Floats) -> None:
    away = Pose(POSE.rotation_vector, POSE.translation + np.array([0.0, 0.0, 0.35]))
    estimate = estimated(photographed(picture), model, away)
    right = estimate.pose is not None and estimate.pose.error_to(POSE).within(1.0, 0.01)
    assert right or estimate.score < 0.5


def test_lines_that_are_lost_do_not_lower_the_error(model: Model, picture: Floats) -> None:
    whole = estimated(photographed(picture), model)
    half = picture.copy()
    half[:, :165] = 0.08
    covered = estimated(photographed(half), model)
    assert whole.rms_px is not None
    assert covered.rms_px is None or covered.rms_px > 1.5 * whole.rms_px
    assert covered.score < whole.score


def test_every_visible_line_is_reported(model: Model, picture: Floats) -> None:
    estimate = estimated(photographed(picture), model)
    assert len(estimate.lines) == 9  # of a cuboid seen from a corner
    for line in estimate.lines:
        assert line.visible_px > 4
        assert 0 <= line.support <= 1
        assert 0 <= line.rms_px <= CAP_PX
        assert line.image == "i1" or line.support == 0


def test_a_second_light_adds_what_the_first_left_dark(model: Model) -> None:
    left = linear_picture(model, CAMERA, POSE, (0.6, 0.04, 0.03, 0.03, 0.7, 0.04), background=0.02)
    right = linear_picture(model, CAMERA, POSE, (0.04, 0.7, 0.6, 0.6, 0.03, 0.5), background=0.02)
    images = ImageSet(CAMERA.width, CAMERA.height)
    for name, frame in (("i1", left), ("i2", right)):
        images.add(name, photographed(frame, seed=len(name)), 1.0, 1.0)
    alone = estimate_pose(images, ["i1"], model, CAMERA, POSE)
    both = estimate_pose(images, ["i1", "i2"], model, CAMERA, POSE)
    assert both.rms_px is not None
    assert alone.rms_px is None or both.rms_px < alone.rms_px
    assert {line.image for line in both.lines} >= {"i1", "i2"}


def test_bad_input_is_named(model: Model, picture: Floats) -> None:
    images = one_image(photographed(picture))
    with pytest.raises(BadInput, match="i9"):
        estimate_pose(images, ["i9"], model, CAMERA, POSE)
    with pytest.raises(BadInput, match="already"):
        images.add("i1", photographed(picture), 1.0, 1.0)
    with pytest.raises(BadInput, match="100x100"):
        images.add("i2", np.zeros((100, 100), np.uint8), 1.0, 1.0)
    with pytest.raises(BadInput, match="matcher"):
        estimate_pose(images, ["i1"], model, CAMERA, POSE, PipelineSettings(matcher="guess"))


def test_a_subset_is_merged_as_if_the_rest_had_never_been(model: Model, picture: Floats) -> None:
    images = ImageSet(CAMERA.width, CAMERA.height)
    for name, seed in (("i1", 1), ("i2", 2), ("i3", 3)):
        images.add(name, photographed(picture, seed=seed), 1.0, 1.0)
    images.edge_map(["i1", "i2", "i3"])
    again = images.edge_map(["i3", "i1"])
    fresh = ImageSet(CAMERA.width, CAMERA.height)
    for name, seed in (("i1", 1), ("i3", 3)):
        fresh.add(name, photographed(picture, seed=seed), 1.0, 1.0)
    assert again.ridge == pytest.approx(fresh.edge_map(["i1", "i3"]).ridge, rel=1e-4, abs=1e-3)


def test_confidence_falls_with_doubt(model: Model, picture: Floats) -> None:
    support = estimated(photographed(picture), model).support
    assert support is not None
    assert quality(support) > 0
    sure = confidence(support, 0.0, 0.0005)
    assert 0 <= confidence(support, 0.9, 0.0005) < sure <= 1
    assert confidence(support, 0.0, 0.05) < sure
    assert confidence(support, 1.0, 0.0005) <= 0.5  # one of two that are equally good


def test_what_noise_drowns_is_found_at_a_coarser_scale(model: Model) -> None:
    dim = linear_picture(model, CAMERA, POSE, (0.25, 0.45, 0.2, 0.5, 0.33, 0.38), 0.1, blur_px=2.0)
    start = disturbed(POSE, np.random.default_rng(1), 8.0, 8.0, CAMERA.fx)
    for seed in range(3):
        pixels = photographed(dim, noise_sd_grey=16.0, seed=seed)
        assert estimated(pixels, model, start, coarse=False).pose is None
        found = estimated(pixels, model, start)
        assert found.pose is not None
        assert found.pose.error_to(POSE).within(1.0, 0.01)
        assert found.score > 0.8


def test_what_little_effort_misses_is_searched_with_more(
    model: Model, picture: Floats, monkeypatch: pytest.MonkeyPatch
) -> None:
    start = disturbed(POSE, np.random.default_rng(3), 20.0, 20.0, CAMERA.fx)
    monkeypatch.setitem(MATCHERS, "search", lambda *_: [])
    assert estimated(photographed(picture), model, start, coarse=False).pose is None
    found = estimated(photographed(picture), model, start)
    assert found.pose is not None
    assert found.pose.error_to(POSE).within(0.3, 0.003)
    assert found.score >= SURE_SCORE


def test_a_clean_image_is_not_looked_at_coarsely(
    model: Model, picture: Floats, monkeypatch: pytest.MonkeyPatch
) -> None:
    """There a wrong model would look less wrong: it is a tenth too wide."""
    wide = replace(model, vertices=model.vertices * [1.1, 1.0, 1.0])
    seen: list[float] = []
    estimate_of = pipeline._refined

    def counted(asked: Any, *given: Any) -> Estimate:
        seen.append(asked.settings.refinement_scale_px)
        return estimate_of(asked, *given)

    monkeypatch.setattr(pipeline, "_refined", counted)
    assert estimated(photographed(picture), wide).score < SURE_SCORE
    assert set(seen) == {1.0}
