"""Sessions whose processes are killed come to what they would have come to; `kills` runs hundreds of them."""

import random

import pytest

from tests.session.cases import CASES
from tests.session.kills import VICTIMS, kill_library, killed_at, killed_once, scratch

pytestmark = pytest.mark.slow

DRAW = random.Random(7)
LIKE_OTHERS = {"short", "long", "satellite", "turning-sun"}
"""Cases in which a kill meets nothing that it does not meet in others."""
LEAST_WRITES = {"controller": 30, "image_server": 50, "vision_server": 45}
"""Of a short session: it has 33, 57 and 52 to 59."""
KILLS = [
    (case, VICTIMS[number % len(VICTIMS)], DRAW.random())
    for number, case in enumerate((case for case in CASES if case not in LIKE_OTHERS), 1)
]


@pytest.mark.parametrize(("case", "victim", "share"), KILLS)
def test_killed_at_a_random_moment(case: str, victim: str, share: float) -> None:
    found = killed_once(case, 1, victim, share)
    assert found["same"], found
    assert (found["lost"], found["twice"], found["strays"], found["sockets"]) == (0, 0, 0, 0), found


@pytest.mark.parametrize(("victim", "places"), [("controller", 2), ("image_server", 1), ("vision_server", 1)])
def test_killed_in_the_middle_of_a_write(victim: str, places: int) -> None:
    with scratch() as folder:
        library = kill_library(folder)
        for place in random.Random(victim).sample(range(1, LEAST_WRITES[victim] + 1), places):
            found = killed_at("short", 1, victim, library, place)
            assert found["same"] and found["died"], found
            assert (found["lost"], found["twice"], found["strays"], found["sockets"]) == (0, 0, 0, 0), found
