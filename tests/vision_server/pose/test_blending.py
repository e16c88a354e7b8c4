import numpy as np
import pytest

from tests.vision_server.level_samples import level_samples, sampled
from vision_server.pose.blending import BLUR_RATIO, LEFT_SHARE, UNSEEN_HEIGHT, Edges, blended

SOFT = np.full((1, 40), 2.0)


def step_beside(gap_px: float, blur_px: float, height: float) -> float:
    """Where the derivative of a blurred step at 0 is largest when another one of some height is beside it."""
    x = np.linspace(-3.0 * blur_px, 3.0 * blur_px, 60001)
    slope = np.exp(-0.5 * (x / blur_px) ** 2) + height * np.exp(-0.5 * ((x - gap_px) / blur_px) ** 2)
    maxima = 1 + np.flatnonzero((slope[1:-1] > slope[:-2]) & (slope[1:-1] >= slope[2:]))
    return float(x[maxima[np.abs(x[maxima]).argmin()]])


def unseen(samples: int) -> Edges:
    """No edge point."""
    return Edges(np.full((1, samples), np.nan), np.full((1, samples), np.inf), np.zeros((1, samples)))


def two_steps(gap_px: float, blur_px: float, height: float, farther_px: float = 0.0) -> Edges:
    """Edge points of two level lines, the second one's step so many times as high, seen farther away."""
    first = step_beside(gap_px, blur_px, height)
    second = -step_beside(gap_px, blur_px, 1.0 / height) + farther_px
    x = np.array([first, gap_px + second])
    slope = np.exp(-0.5 * (x / blur_px) ** 2) + height * np.exp(-0.5 * ((x - gap_px) / blur_px) ** 2)
    offset, strength = np.repeat([first, second], 20)[None], np.repeat(slope, 20)[None]
    return Edges(offset, np.full((1, 40), 0.05), strength)


@pytest.mark.parametrize("gap_px", [0.5, 1.0, 6.0, 8.0])
def test_beside_an_unseen_edge_it_may_be_off_by_what_a_step_of_half_its_height_does(gap_px: float) -> None:
    moved, unsure = blended(level_samples(gap_px), SOFT, 1.12 * SOFT, unseen(40))
    assert not moved.any()
    np.testing.assert_allclose(unsure[0, :20], -unsure[0, 20:])
    seen = step_beside(gap_px, BLUR_RATIO * 2.0, UNSEEN_HEIGHT)
    assert 0.5 * seen < unsure[0, 0] < 2.0 * seen


@pytest.mark.parametrize(  # two equal steps that are nearer than two blurs are seen as one
    ("gap_in_blurs", "height"), [(1.4, -1.0), (1.4, -0.6), (2.2, -1.0), (2.2, -0.6), (3.0, -1.0), (3.0, 1.0)]
)
def test_two_edges_that_are_seen_are_moved_back(gap_in_blurs: float, height: float) -> None:
    blur_px = 2.24
    edges = two_steps(gap_in_blurs * blur_px, blur_px, height)
    moved, unsure = blended(level_samples(gap_in_blurs * blur_px), SOFT, np.full((1, 40), blur_px), edges)
    np.testing.assert_allclose(moved, edges.offset, atol=0.25 * np.abs(edges.offset).max())
    np.testing.assert_allclose(unsure, LEFT_SHARE * moved)


def test_how_far_they_are_apart_tells_more_than_the_blur_does() -> None:
    gap_px = 4.0
    edges = two_steps(gap_px, 3.0, -1.0)
    moved, _ = blended(level_samples(gap_px), SOFT, np.full((1, 40), 2.5), edges)
    np.testing.assert_allclose(moved, edges.offset, atol=0.1)


def test_what_is_far_from_where_two_edges_would_be_is_another_edge() -> None:
    edges = two_steps(4.0, 2.24, -1.0, farther_px=4.0)
    moved, unsure = blended(level_samples(4.0), SOFT, np.full((1, 40), 2.24), edges)
    assert not moved.any()
    np.testing.assert_array_equal(unsure, blended(level_samples(4.0), SOFT, 1.12 * SOFT, unseen(40))[1])


def test_sharp_edges_are_left_to_their_profiles() -> None:
    edges = two_steps(3.0, 1.41, -1.0)
    assert not blended(level_samples(3.0), np.ones((1, 40)), np.full((1, 40), 1.41), edges)[0].any()


def test_lines_that_cross_or_are_far_move_nothing() -> None:
    along = np.arange(-10.0, 10.0)
    level, upright = np.stack([along, 0 * along], axis=1), np.stack([0 * along + 2.0, along], axis=1)
    ways = np.array([[1.0, 0.0], [0.0, 1.0]])
    crossing = np.concatenate([level, upright]), np.repeat(ways, 20, axis=0)
    far = np.concatenate([level, level + np.array([0.0, 16.0])]), np.tile(ways[0], (40, 1))
    for image, direction in (crossing, far):
        samples = sampled(np.repeat([0, 1], 20), image, direction)
        for edges in (unseen(40), two_steps(4.0, 2.24, -1.0)):
            for told in blended(samples, SOFT, 1.12 * SOFT, edges):
                np.testing.assert_allclose(told, 0.0, atol=1e-6)
