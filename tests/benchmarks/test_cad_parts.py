"""Drawn parts are closed and wound outwards; gears and shafts have the features that tell their turn."""

import numpy as np
import pytest

from benchmarks.cad_parts import CAD
from benchmarks.free_form import FREE_FORM
from benchmarks.machined_parts import surface_of
from geometry.model import Model
from geometry.symmetries import symmetry_of
from geometry.turns import round_axes

DRAWN = CAD | FREE_FORM


@pytest.mark.parametrize("name", sorted(DRAWN))
@pytest.mark.parametrize("segments", [24, 96])
def test_each_part_is_closed_and_wound_outwards(name: str, segments: int) -> None:
    for number in range(2):
        for vertices, faces in DRAWN[name](np.random.default_rng((7, number)), segments):
            sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
            there, back = np.unique(sides, axis=0), np.unique(sides[:, ::-1], axis=0)
            assert len(there) == len(sides)  # each side once ...
            np.testing.assert_array_equal(there, back)  # ... and once the other way round
            a, b, c = (vertices[faces[:, k]] for k in range(3))
            assert np.sum(a * np.cross(b, c)) > 0.0


@pytest.mark.parametrize("name", ["gear", "shaft"])
def test_a_key_seat_leaves_no_symmetry_however_thin_the_part(name: str) -> None:
    for number in range(4):
        model = Model.of_surface(name, surface_of(CAD[name](np.random.default_rng((501, number)), 96)))
        symmetry = symmetry_of(model)
        assert len(symmetry.turns) == 1 and symmetry.free_axis is None
        assert len(round_axes(model)) == 1
        assert len(model.lines) > 500


def test_a_free_form_body_is_the_same_however_fine_and_smooth() -> None:
    for name, part in FREE_FORM.items():
        coarse, fine = (part(np.random.default_rng(3), segments)[0][0] for segments in (32, 128))
        np.testing.assert_allclose(np.ptp(coarse, axis=0), np.ptp(fine, axis=0), rtol=0.03, err_msg=name)
    for name in ("lumpy", "bottle"):
        model = Model.of_surface(name, surface_of(FREE_FORM[name](np.random.default_rng(3), 128)))
        assert model.smooth.mean() > 0.98
        assert (symmetry_of(model).free_axis is not None) == (name == "bottle")
