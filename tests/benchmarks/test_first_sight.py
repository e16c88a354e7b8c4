"""First sights that are written down add up, and are not made again."""

from pathlib import Path

import pytest

from benchmarks import first_sight
from benchmarks.first_sight import Conditions, Trial


def test_runs_of_several_seeds_add_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    made: list[tuple[str, int, int]] = []

    def tried(given: Conditions, seed: int, number: int, write: Path | None) -> Trial:
        assert write == tmp_path
        made.append((given.target, seed, number))
        right = (seed == 1, True, False)
        return Trial(seed, number, right, right, 1, 2.0, 0.5, 300.0)

    monkeypatch.setattr(first_sight, "tried", tried)
    for seed in (1, 2, 2):
        first_sight.main(2, "plate,wheel", 3, seed, 0, 640, tmp_path)
    assert made == [(name, seed, k) for seed in (1, 2) for name in ("plate", "wheel") for k in (0, 1)]
    last = capsys.readouterr().out.splitlines()[-1]
    assert '"name": "first sight of wheel", "value": 0.5' in last
    assert '"trials": 4' in last
    assert first_sight.known(tmp_path, Conditions("plate", 640, 1, 0)) == []  # other conditions
