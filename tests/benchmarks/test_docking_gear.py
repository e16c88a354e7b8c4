"""Docking gear: bodies of about 200 mm that no turn brings back, each the same whenever it is written."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.docking_gear import GEAR
from benchmarks.drawn_parts import part_file
from geometry.model import load_model
from geometry.symmetries import symmetry_of


@pytest.mark.parametrize("name", GEAR)
def test_gear_is_written_alike_and_no_turn_brings_it_back(tmp_path: Path, name: str) -> None:
    file = part_file(name, tmp_path, np.random.default_rng(1))
    written = file.read_bytes()
    assert part_file(name, tmp_path, np.random.default_rng(2)).read_bytes() == written
    model = load_model(file)
    assert 0.15 < model.diameter < 0.6
    assert len(symmetry_of(model).turns) == 1
