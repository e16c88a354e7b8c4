"""Gears, shafts and brackets are closed, wound outwards, and have the features that tell their turn."""

import numpy as np
import pytest

from benchmarks.cad_parts import CAD
from benchmarks.machined_parts import surface_of
from geometry.model import Model
from geometry.symmetries import symmetry_of


@pytest.mark.parametrize("name", sorted(CAD))
@pytest.mark.parametrize("segments", [24, 96])
def test_each_part_is_closed_and_wound_outwards(name: str, segments: int) -> None:
    for number in range(4):
        for vertices, faces in CAD[name](np.random.default_rng((7, number)), segments):
            sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
            there, back = np.unique(sides, axis=0), np.unique(sides[:, ::-1], axis=0)
            assert len(there) == len(sides)  # each side once ...
            np.testing.assert_array_equal(there, back)  # ... and once the other way round
            a, b, c = (vertices[faces[:, k]] for k in range(3))
            assert np.sum(a * np.cross(b, c)) > 0.0


def test_a_key_seat_leaves_a_gear_no_symmetry() -> None:
    model = Model.of_surface("gear", surface_of(CAD["gear"](np.random.default_rng((7, 0)), 96)))
    assert len(symmetry_of(model).turns) == 1
    assert len(model.lines) > 1000
