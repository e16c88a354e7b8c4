"""Which constants the benchmark of constants halves and doubles, and to what."""

from types import ModuleType

from benchmarks.constants import holders, in_kernels, named, scaled
from vision_server.matching import icp
from vision_server.pose import refinement
from vision_server.trust import ranking


def test_numbers_are_halved_and_doubled_and_shares_stay_shares() -> None:
    assert scaled("REACHES_PX", (6.0, 4), 0.5) == (3.0, 2)
    assert scaled("LIMIT_PX", 0.8, 2.0) == 1.6
    assert scaled("SHARE", 0.8, 2.0) == 0.9
    assert scaled("SHARE", 0.3, 2.0) == 0.6
    assert scaled("ROUNDS", 1, 0.5) == 1
    assert scaled("EXACT", True, 2.0) is scaled("NAME", "x", 2.0) is scaled("MIXED", (1, "x"), 2.0) is None


def test_a_constant_is_changed_wherever_it_is_imported() -> None:
    modules: list[ModuleType] = holders("EXACT_REACH_PX", refinement.EXACT_REACH_PX)
    assert refinement in modules
    assert ranking in modules


def test_constants_of_kernels_are_told() -> None:
    assert in_kernels("DAMPING", icp.DAMPING)
    assert not in_kernels("LINE_BIAS_PX", refinement.LINE_BIAS_PX)


def test_of_a_module_its_own_constants_are_meant() -> None:
    module, names = named("vision_server.trust.ranking")
    assert module == "vision_server.trust.ranking"
    assert {"ONE_OPTIMUM", "COARSE_REACHES_PX", "COARSENING"} <= set(names)
    assert "EXACT_REACH_PX" not in names
    assert named("vision_server.trust.ranking.MOST_BESIDE") == (module, ["MOST_BESIDE"])
