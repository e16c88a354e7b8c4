"""Lines that fall together in the image tell once whether they are seen."""

import numpy as np
import pytest

from geometry.model import Model
from geometry.pose import Pose
from geometry.visibility import Samples
from numerics.arrays import Flags
from tests.vision_server.refined_poses import channels_of
from tests.vision_server.synthetic import CAMERA, SIZE_M, linear_picture, photographed
from vision_server.pose.observation import PoseProblem
from vision_server.trust.coincident import TOGETHER_PX, told_once
from vision_server.trust.support import PoseSupport, support_at

STEP_PX = 2.0
SEEN, UNSEEN = np.ones(20, dtype=bool), np.zeros(20, dtype=bool)


def level(*heights_px: float, shift_px: float = 0.0) -> Samples:
    """Level lines of 20 samples at such heights, each shifted against the one before."""
    along = STEP_PX * np.arange(20.0)
    image = [np.stack([along + shift_px * n, np.full(20, y)], axis=1) for n, y in enumerate(heights_px)]
    count = 20 * len(heights_px)
    empty, line = np.zeros((count, 3)), np.repeat(np.arange(len(heights_px)), 20)
    return Samples(
        empty, empty, line, np.concatenate(image), np.tile([1.0, 0.0], (count, 1)),
        np.full(count, STEP_PX), line,
    )  # fmt: skip


def told(samples: Samples, *supported: Flags) -> tuple[Flags, Flags]:
    return told_once(samples, np.concatenate(supported), TOGETHER_PX)[:2]


@pytest.mark.parametrize("shift_px", [0.0, 0.4 * STEP_PX])
def test_the_first_of_two_lines_stands_for_both(shift_px: float) -> None:
    evens = np.arange(20) % 2 == 0
    own, seen = told(level(0.0, 0.3, shift_px=shift_px), evens, ~evens)
    assert own.tolist() == [True] * 20 + [False] * 20
    assert seen[:20].all()


def test_lines_apart_stand_for_themselves() -> None:
    own, seen = told(level(0.0, TOGETHER_PX + 0.1), SEEN, UNSEEN)
    assert own.all()
    assert not seen[20:].any()


def test_of_three_lines_in_a_row_the_outer_two_stand_for_themselves() -> None:
    own, _ = told(level(0.0, 0.8, 1.6), SEEN, SEEN, SEEN)
    assert own.tolist() == [True] * 20 + [False] * 20 + [True] * 20


def test_lines_that_continue_each_other_stand_for_themselves() -> None:
    own, _ = told(level(0.0, 0.0, shift_px=20 * STEP_PX), SEEN, SEEN)
    assert own.all()


def test_lines_that_cross_stand_for_themselves() -> None:
    one = level(0.0, 0.0)
    image, way = one.image.copy(), one.image_direction.copy()
    image[20:] = np.stack([np.full(20, 19.0), STEP_PX * np.arange(20.0) - 19.0], axis=1)
    way[20:] = [0.0, 1.0]
    own, _ = told(one._replace(image=image, image_direction=way), SEEN, SEEN)
    assert own.all()


def test_lines_in_a_row_are_as_crowded_as_they_are_near() -> None:
    rows = told_once(level(0.0, 3.0, 7.0), np.tile(SEEN, 3), 10.0).gap.reshape(3, 20)
    assert rows[1] == pytest.approx(3.5)
    assert np.isinf(rows[[0, 2]]).all()  # nothing runs on their other side


def test_fins_two_pixels_apart_tell_less_than_as_many_lines_that_are_apart() -> None:
    """Wherever a row of fins is, an edge is near each of them."""

    def confirmed(apart_px: float) -> float:
        samples = level(*(apart_px * np.arange(9.0)))
        seen, ones = np.ones((1, 180), dtype=bool), np.ones((1, 9))
        none = np.zeros(180)
        return PoseSupport(0.1, 1.0, 1.0, 0.0, ["i1"], samples, none, seen, ones, none).confirmed

    assert confirmed(20.0) == pytest.approx(confirmed(12.0))
    assert confirmed(2.2) < 0.3 * confirmed(12.0)


def seen_in(model: Model, images: int) -> PoseSupport:
    """Support of a box seen along its top, whose near and far edges are 0.003 px apart."""
    pose = Pose(np.array([0.0, 0.3, 0.0]), np.array([-0.02, 0.5 * SIZE_M[1] + 0.00002, 0.45]))
    linear = linear_picture(model, CAMERA, pose)
    frames = [photographed(linear, seed=seed) for seed in range(images)]
    channels = [channel for frame in frames for channel in channels_of(frame)]
    support = support_at(PoseProblem.at_scale(channels, model, CAMERA), pose, STEP_PX)
    assert support is not None
    return support


def test_an_edge_is_evidence_of_one_line_however_many_images_show_it(model: Model) -> None:
    one, four = seen_in(model, 1), seen_in(model, 4)
    assert one.missing == four.missing == 0.0
    assert one.evidence == pytest.approx(four.evidence, abs=1.0)
