"""Poses at different places in the image may all be right: of equal parts each is found and believed."""

import numpy as np
import pytest

from benchmarks.cad_parts import CAD
from benchmarks.machined_parts import surface_of
from benchmarks.synthetic_parts import rendered
from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from geometry.rotation import matrix_of
from tests.vision_server.synthetic import one_image
from vision_server.matching import Anywhere
from vision_server.pipeline import estimate_pose
from vision_server.trust.equal_parts import A_PART_NATS, apart, as_rival

CAMERA = Camera(640, 480, 768.0, 768.0, 319.5, 239.5)
TURNS = np.array([0.5, 2.4, 0.3]), np.array([2.2, 0.4, 0.5])


@pytest.fixture(scope="module")
def bracket() -> Model:
    return Model.of_surface("bracket", surface_of(CAD["bracket"](np.random.default_rng(3), 48)))


def at(model: Model, turn: np.ndarray, middle_px: float, size_px: float = 230.0) -> Pose:
    """The model's middle in the middle row of the image, at this column."""
    rotation, range_m = matrix_of(turn), CAMERA.fx * model.diameter / size_px
    place = np.array([(middle_px - CAMERA.cx) / CAMERA.fx * range_m, 0.0, range_m])
    return Pose.from_matrix(rotation, place - rotation @ model.middle)


def test_two_equal_parts_are_both_found_and_believed(bracket: Model) -> None:
    true = [at(bracket, turn, place) for turn, place in zip(TURNS, (160.0, 480.0), strict=True)]
    left, right = (rendered(bracket, CAMERA, pose, np.random.default_rng(1)) for pose in true)
    images = one_image(np.concatenate([left[:, :320], right[:, 320:]], axis=1))
    found = estimate_pose(images, ["i1"], bracket, CAMERA, Anywhere())
    assert found.score > 0.95
    assert found.ambiguity < 0.01
    first, second = found.poses
    assert min(first.probability, second.probability) > 0.95
    for pose in true:
        assert any(one.pose.error_to(pose).within(0.5, 0.005) for one in found.poses)


@pytest.mark.parametrize(("beside_px", "expected"), [(0.0, False), (100.0, False), (320.0, True)])
def test_outlines_that_share_little_are_apart(bracket: Model, beside_px: float, expected: bool) -> None:
    one, other = at(bracket, TURNS[0], 160.0), at(bracket, TURNS[0], 160.0 + beside_px)
    assert apart(bracket, CAMERA, [one, other]).tolist() == [[False, expected], [expected, False]]


def test_what_is_partly_behind_the_camera_is_nowhere_apart(bracket: Model) -> None:
    behind = Pose(TURNS[0], np.zeros(3))
    assert not apart(bracket, CAMERA, [at(bracket, TURNS[0], 160.0), behind]).any()


def test_a_pose_elsewhere_counts_until_it_is_convincing() -> None:
    """A pose in clutter is no reason to believe another one there, or here, that is no better."""
    weak, strong = 0.5 * A_PART_NATS, 3.0 * A_PART_NATS
    assert [as_rival(nats, elsewhere=True) for nats in (weak, strong)] == [weak, A_PART_NATS]
    assert as_rival(strong, elsewhere=False) == strong
