"""A model that is too long along an axis that is seen is told from the target's own by a frame's lines."""

from dataclasses import replace

import numpy as np
import pytest

from geometry.model import Model
from tests.vision_server.synthetic import POSE
from tests.vision_server.tracking.framed import problem
from vision_server.pose.refinement import refine
from vision_server.tracking.strain import LEAST_STRAIN, clearly_strained, is_strained
from vision_server.trust.stretch import stretched


@pytest.mark.parametrize("axis", [1, 2])  # of the first one this view tells too little
def test_a_model_too_long_along_an_axis_is_told_from_the_true_one(model: Model, axis: int) -> None:
    true = problem(model, printed=False)
    wrong = replace(true, model=stretched(model, 0.05 * np.eye(3)[axis]))
    for one, strained in ((true, False), (wrong, True)):
        solution = refine(one, POSE)
        assert solution is not None
        assert is_strained(one, solution.pose, 2.0) == strained


def test_a_strain_counts_where_it_is_large_and_known() -> None:
    strain = np.array([1.6, 0.0, 0.0]) * LEAST_STRAIN
    assert clearly_strained(strain, 1e-6 * np.eye(3))
    assert not clearly_strained(0.9 * strain, 1e-6 * np.eye(3))
    assert not clearly_strained(strain, 1e-3 * np.eye(3))
    assert not clearly_strained(np.full(3, 0.1), 1e-6 * np.eye(3))  # that is another range
