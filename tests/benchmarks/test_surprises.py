"""The benchmarks ask about the settings that sessions ask about."""

from benchmarks.surprises import candidates
from image_server.simulator.simulator import Simulator


def test_candidates_are_those_of_a_session() -> None:
    asked = candidates(Simulator("cube", "nominal", 1).describe())
    assert len(set(asked)) == len(asked) == 13 * 5 * 3  # lightings of three lights, shutters, apertures
    assert {one.lights for one in asked} >= {(0, 0, 0), (4, 0, 0), (7, 7, 0), (5, 5, 5)}
