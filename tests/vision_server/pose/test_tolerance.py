"""Parts that are not quite their model, and how far they may be off as it is told beforehand."""

import numpy as np

from experiments.kinds.estimate import normalised_error_squared
from geometry.model import Model
from geometry.pose import disturbed
from tests.vision_server.refined_poses import GREYS, channels_of, misshapen, scaled
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture, photographed
from vision_server.pose.covariance import pose_covariance
from vision_server.pose.observation import PoseProblem
from vision_server.pose.refinement import Solution, refine

OFF = 0.001  # of the size


def solved(model: Model, seed: int, tolerance: float) -> Solution:
    random = np.random.default_rng(seed)
    pixels = photographed(linear_picture(misshapen(model, random, OFF), CAMERA, POSE, GREYS))
    start = disturbed(POSE, random, 1.0, 1.5, CAMERA.fx)
    tolerance_m = tolerance * model.diameter
    problem = PoseProblem.at_scale(channels_of(pixels), model, CAMERA, tolerance_m=tolerance_m)
    solution = refine(scaled(problem, start), start)
    assert solution is not None
    return solution


def test_the_covariance_of_a_part_that_is_off_is_honest_once_it_is_told(model: Model) -> None:
    exact, told = ([solved(model, seed, tolerance) for seed in range(8)] for tolerance in (0.0, OFF))
    squares = [
        np.mean([normalised_error_squared(one.pose, pose_covariance(one), POSE) for one in those])
        for those in (exact, told)
    ]
    assert squares[0] > 14.0  # 20 of 16 parts, where 6 are expected
    assert 2.0 < squares[1] < 10.0  # 4.3 of 16
    off = [np.sqrt(np.mean([one.pose.error_to(POSE).rotation_deg ** 2 for one in those]))
           for those in (exact, told)]  # fmt: skip
    assert off[1] < off[0]  # .155 and .174 degrees, of 16


def test_each_line_is_off_by_as_many_pixels_as_its_range_makes_of_it(model: Model) -> None:
    seen = solved(model, 0, OFF).observation
    expected = OFF * model.diameter * CAMERA.fx / POSE.translation[2]
    np.testing.assert_allclose(np.median(seen.tolerance), expected, rtol=0.1)
    assert (solved(model, 0, 0.0).observation.tolerance == 0.0).all()
