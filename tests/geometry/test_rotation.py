"""Angles about the axes in turn agree with SciPy."""

import numpy as np
from scipy.spatial.transform import Rotation

from geometry.rotation import euler_matrices, euler_matrix


def test_turns_about_x_then_y_then_z_of_the_turned_axes() -> None:
    angles = np.random.default_rng(0).uniform(-3, 3, (20, 3))
    expected = Rotation.from_euler("XYZ", angles).as_matrix()
    np.testing.assert_allclose(euler_matrices(angles), expected, atol=1e-12)
    np.testing.assert_allclose(euler_matrix(*angles[0]), expected[0], atol=1e-12)
