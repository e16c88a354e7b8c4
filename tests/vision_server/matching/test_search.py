"""The search finds the pose from a poor seed, says nothing when there is nothing, and repeats itself."""

import numpy as np
import pytest

from geometry.errors import GeometryError
from geometry.model import find_target, load_model
from geometry.pose import Pose, disturbed, search_translation_px
from tests.vision_server.matching_scenes import CAMERA, segments_of
from vision_server.matchers import MATCHERS
from vision_server.matching import SearchRange, match_search
from vision_server.matching.search import match_near

POSE = Pose(np.array([0.5, 0.4, 0.2]), np.array([0.02, -0.01, 0.9]))


@pytest.mark.parametrize("name", ["cube", "fixture", "satellite"])
@pytest.mark.parametrize("seed", range(4))
def test_finds_the_pose_in_clutter(name: str, seed: int) -> None:
    model = load_model(find_target(name))
    segments = segments_of(model, POSE, clutter=60, seed=seed)
    start = disturbed(POSE, np.random.default_rng(seed), 25.0, 40.0, CAMERA.fx)
    match = match_search(segments, model, CAMERA, start, seed)
    assert match[0].pose.error_to(POSE).within(1.0, 0.01)
    assert match[0].supported > 0.8
    scores = [one.score for one in match]
    assert scores == sorted(scores, reverse=True)


@pytest.mark.parametrize("seed", range(4))
def test_finds_the_pose_before_a_wall_of_lines(seed: int) -> None:
    """Its lines are longer than any of the model's; taken for these they are most of what is seen."""
    model = load_model(find_target("cube"))
    rng = np.random.default_rng(seed)
    spaced = np.arange(-500.0, 1100.0, 12.0) + rng.uniform(0.0, 12.0)
    wall = np.stack([spaced, np.zeros_like(spaced), spaced + 200.0, np.full_like(spaced, 480.0)], axis=1)
    hidden = segments_of(model, POSE, seed=seed)[::2]  # the other lines are not seen
    start = disturbed(POSE, rng, 25.0, 40.0, CAMERA.fx)
    match = match_search(np.vstack([wall, hidden]), model, CAMERA, start, seed)
    assert match[0].pose.error_to(POSE).within(1.0, 0.01)


@pytest.mark.parametrize("seed", range(4))
def test_the_range_grows_with_the_frame(seed: int) -> None:
    camera = CAMERA.scaled(6.0)
    model, reach = load_model(find_target("satellite")), search_translation_px(camera.width)
    assert reach == 6.0 * SearchRange.translation_px
    segments = segments_of(model, POSE, camera, noise_px=0.8, clutter=60, seed=seed)
    start = disturbed(POSE, np.random.default_rng(seed), 25.0, reach, camera.fx)
    match = match_search(segments, model, camera, start, seed, SearchRange(25.0, reach))
    assert match[0].pose.error_to(POSE).within(1.0, 0.01)


def test_a_cube_seen_from_between_two_of_its_poses_has_both() -> None:
    """A cube looks the same after a quarter turn; a seed pose halfway between cannot tell which it was."""
    model = load_model(find_target("cube"))
    between = POSE.compose(Pose(np.array([0.0, np.pi / 4, 0.0]), np.zeros(3)))
    other = POSE.compose(Pose(np.array([0.0, np.pi / 2, 0.0]), np.zeros(3)))
    segments = segments_of(model, POSE, clutter=30)
    found = match_search(segments, model, CAMERA, between, 0, SearchRange(50.0, 20.0))
    for pose in (POSE, other):
        assert any(one.pose.error_to(pose).within(0.5, 0.005) for one in found[:2])
    assert found[1].score > 0.95 * found[0].score
    poses = [one.pose for one in found]
    for i, pose in enumerate(poses):
        assert not any(pose.error_to(known).within(2.0, 0.01) for known in poses[:i])


def test_a_narrow_range_keeps_to_the_seed() -> None:
    model = load_model(find_target("cube"))
    rival = POSE.compose(Pose(np.array([0.0, np.pi / 2, 0.0]), np.zeros(3)))  # looks just the same
    segments = segments_of(model, POSE)
    narrow = SearchRange(3.0, 5.0)
    for pose in (POSE, rival):
        found = match_search(segments, model, CAMERA, pose, 0, narrow)[0].pose
        assert found.error_to(pose).within(0.5, 0.005)


@pytest.mark.parametrize("matcher", sorted(MATCHERS))
def test_the_same_seed_gives_the_same_poses(matcher: str) -> None:
    model = load_model(find_target("fixture"))
    segments = segments_of(model, POSE, clutter=50)
    first, again, other = (MATCHERS[matcher](segments, model, CAMERA, POSE, seed) for seed in (3, 3, 4))
    assert [c.pose.to_dict() for c in first] == [c.pose.to_dict() for c in again]
    assert [c.score for c in first] == [c.score for c in again]
    assert [c.pose.to_dict() for c in first] != [c.pose.to_dict() for c in other]


@pytest.mark.parametrize("matcher", sorted(MATCHERS))
@pytest.mark.parametrize(
    "segments",
    [
        np.empty((0, 4)),
        np.empty(0),
        np.array([[10.0, 10.0, 12.0, 10.0]]),  # too short to say anything
    ],
)
def test_no_segments_no_pose(matcher: str, segments: np.ndarray) -> None:
    model = load_model(find_target("cube"))
    assert MATCHERS[matcher](segments, model, CAMERA, POSE, 0) == []


@pytest.mark.parametrize("matcher", sorted(MATCHERS))
def test_one_segment_is_no_reason_to_fail(matcher: str) -> None:
    model = load_model(find_target("cube"))
    match = MATCHERS[matcher](np.array([[300.0, 200.0, 380.0, 210.0]]), model, CAMERA, POSE, 0)
    assert all(np.isfinite(one.score) for one in match)
    assert all(one.supported < 0.5 for one in match)


@pytest.mark.parametrize("matcher", sorted(MATCHERS))
@pytest.mark.parametrize("translation", [[50.0, 0.0, 1.0], [0.0, 0.0, 1000.0], [0.0, 0.0, 0.01]])
def test_a_seed_from_which_nothing_is_seen_gives_no_pose(matcher: str, translation: list[float]) -> None:
    model = load_model(find_target("cube"))
    far = Pose(np.zeros(3), np.array(translation))
    assert MATCHERS[matcher](segments_of(model, POSE), model, CAMERA, far, 0) == []


@pytest.mark.parametrize("matcher", sorted(MATCHERS))
def test_bad_input_is_refused(matcher: str) -> None:
    model, match = load_model(find_target("cube")), MATCHERS[matcher]
    good = segments_of(model, POSE)
    with pytest.raises(GeometryError, match="behind the camera"):
        match(good, model, CAMERA, Pose(np.zeros(3), np.array([0.0, 0.0, -1.0])), 0)
    with pytest.raises(GeometryError, match="finite"):
        match(np.where(good > 300, np.nan, good), model, CAMERA, POSE, 0)
    with pytest.raises(GeometryError, match="shape"):
        match(good[:, :3], model, CAMERA, POSE, 0)


@pytest.mark.parametrize(
    ("rotation_deg", "translation_px"), [(-1.0, 40.0), (181.0, 40.0), (25.0, float("nan"))]
)
def test_a_search_range_must_make_sense(rotation_deg: float, translation_px: float) -> None:
    with pytest.raises(GeometryError, match="search range"):
        SearchRange(rotation_deg, translation_px)


def test_of_models_near_a_pose_the_one_that_is_seen_scores_most() -> None:
    model, smaller = load_model(find_target("satellite")), load_model(find_target("fixture"))
    segments = segments_of(model, POSE, clutter=60, seed=1)
    near = disturbed(POSE, np.random.default_rng(1), 1.5, 20.0, CAMERA.fx)
    own, other = match_near(segments, CAMERA, 1, (model, smaller), near)
    assert own[0][1].error_to(POSE).within(1.0, 0.01)
    assert own[0][0] > max((score for score, _ in other), default=0.0)
    assert match_near(np.zeros((0, 4)), CAMERA, 1, (model, smaller), near) == [[], []]
    behind = Pose(POSE.rotation_vector, -POSE.translation)
    assert match_near(segments, CAMERA, 1, (model, smaller), behind) == [[], []]
