"""A journal that is cut anywhere leads to the same outcome; `cuts` does it everywhere."""

import pytest

from tests.session.cuts import cut_everywhere

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("case", "every", "last_lines"),
    [("turning-sun", 5, 0), ("drifting", 7, 0), ("approach", 7, 0), ("long", 9, 1)],
)
def test_cut_anywhere_it_comes_to_the_same_outcome(case: str, every: int, last_lines: int) -> None:
    found = list(cut_everywhere(case, every, last_lines))
    assert len(found) > 3
    assert [one for one in found if not one["same"]] == []
