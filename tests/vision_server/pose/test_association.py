import numpy as np
import pytest

from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Floats
from tests.vision_server.level_samples import level_samples, sampled
from tests.vision_server.refined_poses import channels_of, scaled
from tests.vision_server.synthetic import CAMERA, linear_picture, photographed
from vision_server.pose.along_lines import _near_pairs
from vision_server.pose.association import PAST_PX, associate
from vision_server.pose.observation import PoseProblem
from vision_server.trust.ranking import refined

EDGE_ON = Pose(np.array([0.3, 0.03, 0.0]), np.array([-0.05, -0.004, 0.45]))
"""One face is seen at a grazing angle: two of its edges are some 2 px apart."""
BLACK_SIDE = (0.5, 0.5, 0.5, 0.08, 0.5, 0.5)
"""Greys of the cuboid's faces; the grazing one as dark as the background."""


def level_lines(gap_px: float, offset: Floats) -> Floats:
    """Edge points left on two level lines."""
    associate(level_samples(gap_px), offset[None])
    return offset


def test_an_edge_between_two_lines_belongs_to_the_nearer() -> None:
    offset = np.full((40, 1), np.nan)
    offset[:20], offset[20:] = 3.0, -1.0  # one edge 3 px below the first, 1 px above the second
    left = level_lines(4.0, offset)
    assert np.isnan(left[:20]).all()
    assert (left[20:] == -1.0).all()


def test_an_edge_midway_counts_once() -> None:
    offset = np.full((40, 1), 2.0)
    offset[20:] = -2.0
    left = level_lines(4.0, offset)
    assert np.isfinite(left[:20]).all()
    assert np.isnan(left[20:]).all()


def test_lines_that_fall_together_share_nothing() -> None:
    left = level_lines(0.0, np.full((40, 1), 0.1))
    assert np.isfinite(left[:20]).all()
    assert np.isnan(left[20:]).all()


def test_lines_that_cross_do_not_compete() -> None:
    along = np.arange(-10.0, 10.0)
    level, upright = np.stack([along, 0 * along], axis=1), np.stack([0 * along + 2.0, along], axis=1)
    direction = np.repeat([[1.0, 0.0], [0.0, 1.0]], 20, axis=0)
    offset = np.full((40, 1), 3.0)
    associate(sampled(np.repeat([0, 1], 20), np.concatenate([level, upright]), direction), offset[None])
    assert (offset == 3.0).all()


def test_a_line_has_no_claim_beyond_its_ends() -> None:
    along = np.arange(20.0)
    image = np.concatenate(
        [np.stack([along, 0 * along], axis=1), np.stack([along + 20 + PAST_PX, 0 * along + 4.0], axis=1)]
    )
    offset = np.full((40, 1), 3.0)
    associate(sampled(np.repeat([0, 1], 20), image, np.tile([1.0, 0.0], (40, 1))), offset[None])
    assert np.isfinite(offset[:20]).all()


@pytest.mark.parametrize("turn", [-0.02, 0.0, 0.02])
def test_a_dark_face_seen_edge_on_is_not_closed(model: Model, turn: float) -> None:
    channels = channels_of(photographed(linear_picture(model, CAMERA, EDGE_ON, BLACK_SIDE)))
    start = EDGE_ON.stepped(np.array([0.0, turn, 0.0, 0.0, 0.0, 0.0]))
    problem = scaled(PoseProblem.at_scale(channels, model, CAMERA), start)
    found = refined(problem, start, (6.0, 4.0, 3.0), 2.0)
    assert found is not None
    error = found.pose.error_to(EDGE_ON)
    assert error.rotation_deg < 0.5, error


def test_lines_that_come_near_to_each_other_are_all_found() -> None:
    rng = np.random.default_rng(0)
    low = rng.uniform(0.0, 300.0, (200, 2))
    box = np.hstack([low, low + rng.uniform(0.0, 40.0, (200, 2)) * rng.choice([1.0, 0.0], (200, 2))])
    apart = np.maximum(box[None, :, :2] - box[:, None, 2:], box[:, None, :2] - box[None, :, 2:]).max(axis=2)
    near = rng.uniform(0.0, 12.0, 200)
    expected = [(i, j) for i in range(200) for j in range(200) if i != j and apart[i, j] <= near[i]]
    assert sorted(tuple(pair) for pair in _near_pairs(box, near).tolist()) == expected
    assert len(_near_pairs(box[:0], near[:0])) == 0
