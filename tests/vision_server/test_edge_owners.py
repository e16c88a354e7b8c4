import numpy as np
import pytest
from numpy.typing import NDArray

from geometry.model import Model
from geometry.pose import Pose
from tests.vision_server.synthetic import CAMERA, linear_picture, photographed
from tests.vision_server.test_refinement import channels_of
from vision_server.candidates import Refiner
from vision_server.edge_owners import BEYOND_PX, leave_to_owners
from vision_server.line_scales import line_scales

SHARP = np.ones((1, 40), np.bool_)
EDGE_ON = Pose(np.array([0.3, 0.03, 0.0]), np.array([-0.05, -0.004, 0.45]))
"""One face is seen at a grazing angle: two of its edges are some 2 px apart."""
BLACK_SIDE = (0.5, 0.5, 0.5, 0.08, 0.5, 0.5)
"""Greys of the cuboid's faces; the grazing one as dark as the background."""


def level_lines(gap_px: float, offset: NDArray[np.float64]) -> NDArray[np.float64]:
    """Edge points left on two level lines of 20 samples, the second one ``gap_px`` below the first."""
    along = np.arange(20.0)
    image = np.concatenate([np.stack([along, np.full(20, y)], axis=1) for y in (0.0, gap_px)])
    direction, normal = np.tile([1.0, 0.0], (40, 1)), np.tile([0.0, 1.0], (40, 1))
    leave_to_owners(np.repeat([0, 1], 20), image, direction, normal, 2, SHARP, offset[None])
    return offset


def test_an_edge_between_two_lines_belongs_to_the_nearer() -> None:
    offset = np.full((40, 1), np.nan)
    offset[:20], offset[20:] = 3.0, -1.0  # one edge 3 px below the first, 1 px above the second
    left = level_lines(4.0, offset)
    assert np.isnan(left[:20]).all()
    assert (left[20:] == -1.0).all()


def test_blurred_lines_keep_what_they_see() -> None:
    offset, blurred = np.full((40, 1), 3.0), np.zeros(40, np.bool_)
    along = np.arange(20.0)
    image = np.concatenate([np.stack([along, np.full(20, y)], axis=1) for y in (0.0, 4.0)])
    direction, normal = np.tile([1.0, 0.0], (40, 1)), np.tile([0.0, 1.0], (40, 1))
    leave_to_owners(np.repeat([0, 1], 20), image, direction, normal, 2, blurred[None], offset[None])
    assert (offset == 3.0).all()


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
    normal = np.repeat([[0.0, 1.0], [-1.0, 0.0]], 20, axis=0)
    offset = np.full((40, 1), 3.0)
    leave_to_owners(
        np.repeat([0, 1], 20), np.concatenate([level, upright]), direction, normal, 2, SHARP, offset[None]
    )
    assert (offset == 3.0).all()


def test_a_line_has_no_claim_beyond_its_ends() -> None:
    along = np.arange(20.0)
    image = np.concatenate(
        [np.stack([along, 0 * along], axis=1), np.stack([along + 20.0 + BEYOND_PX, 0 * along + 4.0], axis=1)]
    )
    offset = np.full((40, 1), 3.0)
    leave_to_owners(
        np.repeat([0, 1], 20),
        image,
        np.tile([1.0, 0.0], (40, 1)),
        np.tile([0.0, 1.0], (40, 1)),
        2,
        SHARP,
        offset[None],
    )
    assert np.isfinite(offset[:20]).all()


@pytest.mark.parametrize("turn", [-0.02, 0.0, 0.02])
def test_a_dark_face_seen_edge_on_is_not_closed(model: Model, turn: float) -> None:
    channels = channels_of(photographed(linear_picture(model, CAMERA, EDGE_ON, BLACK_SIDE)))
    start = EDGE_ON.stepped(np.array([0.0, turn, 0.0, 0.0, 0.0, 0.0]))
    scale = line_scales(channels, model, CAMERA, start, 4.0)
    refiner = Refiner(channels, model, CAMERA, 0, 0.01)
    found = refiner.refined(start, scale, (6.0, 4.0, 3.0), 1.0)
    assert found is not None
    error = found.solution.pose.error_to(EDGE_ON)
    assert error.rotation_deg < 0.5, error
