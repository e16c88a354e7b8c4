"""The benchmark of tracking counts the frames that it should."""

from benchmarks.films import film
from benchmarks.tracking import followed, summary


def test_at_first_sight_the_first_frame_counts() -> None:
    model, frames = film(3300, "calm", 2)
    rows = followed(model, frames, first_sight=True)
    assert rows[0][1].state != "lost"
    assert summary("calm", [rows], given=0)["frames"] == 2
    assert summary("calm", [rows])["frames"] == 1
