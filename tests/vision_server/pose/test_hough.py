import numpy as np

from numerics.arrays import Floats
from vision_server.pose.hough import choose, vote


def voted(offset: Floats, reach: float = 6.0) -> Floats:
    """Shift (2,) of one line with evenly spaced samples; offset (C, N, K)."""
    count = offset.shape[1]
    line, along = np.zeros(count, dtype=np.int64), np.linspace(-1, 1, count)
    quality = np.where(np.isfinite(offset), 1.0, 0.0)
    return np.asarray(vote(line, along, offset, quality, 1, reach, np.ones(count))[0])


def test_a_straight_edge_wins_over_more_points_that_scatter() -> None:
    rng = np.random.default_rng(0)
    along = np.linspace(-1, 1, 80)
    offset = np.full((1, 80, 3), np.nan)
    offset[0, ::2, 0] = (1.5 + 1.0 * along)[::2]
    offset[0, :, 1] = rng.uniform(-6, 6, 80)
    shift = voted(offset)
    assert abs(shift[0] - 1.5) < 0.7
    assert abs(shift[1] - 1.0) < 0.9


def test_the_edge_that_is_there_in_every_channel_wins() -> None:
    offset = np.full((3, 60, 2), np.nan)
    offset[:, :, 0] = -2.0
    for channel, shadow in enumerate((4.0, 1.0, 3.0)):
        offset[channel, :, 1] = shadow
    shift = voted(offset)
    assert abs(shift[0] + 2.0) < 0.7


def test_of_two_equal_edges_the_nearer_one_wins() -> None:
    offset = np.full((1, 60, 2), np.nan)
    offset[0, :, 0], offset[0, :, 1] = 4.8, -1.2
    shift = voted(offset)
    assert abs(shift[0] + 1.2) < 0.7


def test_without_edge_points_there_is_no_vote() -> None:
    shift = voted(np.full((2, 30, 3), np.nan))
    assert shift.tolist() == [0.0, 0.0]


def test_the_chosen_point_is_the_one_on_the_voted_edge() -> None:
    offset = np.array([[[3.0, 0.4, np.nan], [np.nan, np.nan, np.nan], [0.6, 5.0, 0.45]]])
    chosen = choose(
        np.zeros(3, dtype=np.int64),
        np.array([-1.0, 0.0, 1.0]),
        offset,
        np.array([[0.5, 0.0]]),
        np.ones(3),
    )
    assert chosen.tolist() == [[1, -1, 2]]
