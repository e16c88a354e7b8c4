import numpy as np
import pytest

from geometry.model import Model
from geometry.pose import disturbed
from tests.vision_server.refined_poses import channels_of
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture, photographed
from vision_server.pose.observation import PoseProblem, observe
from vision_server.pose.refinement import line_biases, prior_precision, solve
from vision_server.pose.solver import (
    MEDIAN_BIN_PX,
    SAMPLES_TOGETHER,
    Equations,
    solve_plainly,
    solve_reweighted,
    weighted_median,
)
from vision_server.pose.weights import base_weights


@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("seed", range(3))
def test_the_kernel_is_the_definition(channels: int, seed: int) -> None:
    """Random lines with biases, outliers and missing edge points."""
    random = np.random.default_rng(seed)
    line = np.repeat([0, 2, 3], (40, 7, 60))
    jacobian = random.normal(0.0, [400, 400, 400, 900, 900, 300], (len(line), 6))
    offset = jacobian @ random.normal(0.0, 2e-3, 6) + random.normal(0.0, 0.2, (channels, len(line)))
    offset[random.uniform(size=offset.shape) < 0.1] += 4.0
    base = random.uniform(0.5, 2.0, offset.shape)
    absent = random.uniform(size=offset.shape) < 0.2
    offset[absent], base[absent] = np.nan, 0.0
    equations = Equations(
        jacobian=jacobian,
        nuisance=random.normal(0.0, 0.5, (*offset.shape, 2)),
        offset=offset,
        bias=np.abs(random.normal(0.0, 0.1, offset.shape)),
        line=line,
        base=base,
        prior=prior_precision(0.5, 0.01),
    )
    step, weight = solve_reweighted(equations)
    plain_step, plain_weight = solve_plainly(equations)
    assert 0.0 < (weight[base > 0] == 0.0).mean() < 0.5  # the outliers
    np.testing.assert_allclose(step, plain_step, rtol=1e-9, atol=1e-14)
    np.testing.assert_allclose(weight, plain_weight, rtol=1e-9, atol=1e-12)


def test_the_weighted_median_agrees_with_sorting() -> None:
    random = np.random.default_rng(0)
    values, weights = random.exponential(1.0, (3, 200)), random.uniform(0, 1, (3, 200))
    weights[random.uniform(size=weights.shape) < 0.3] = 0.0
    order = np.argsort(values, axis=None)
    total = np.cumsum(weights.ravel()[order])
    expected = values.ravel()[order][np.searchsorted(total, 0.5 * total[-1])]
    assert weighted_median(values, weights) == pytest.approx(expected, abs=MEDIAN_BIN_PX)
    assert weighted_median(values, np.zeros_like(weights)) == 0.0


def test_a_solution_is_the_reweighted_least_squares_one(model: Model) -> None:
    """No reweighting moves it further, and each line's bias may as well be an unknown of its own."""
    pixels = photographed(linear_picture(model, CAMERA, POSE))
    start = disturbed(POSE, np.random.default_rng(0), 1.0, 1.5, CAMERA.fx)
    seen = observe(PoseProblem.at_scale(channels_of(pixels), model, CAMERA), start, 4.0, 2.0)
    step, weight = solve(seen, base_weights(seen, True), 0.42, 0.01)
    used = weight > 0
    samples = np.nonzero(used)[1]
    of_line = seen.samples.line[samples][:, None] == np.arange(len(model.lines))
    biases = line_biases(seen)[used][:, None] * of_line  # an unknown of its own for each line
    rows = np.column_stack([seen.jacobian[samples], seen.nuisance[used], biases])
    prior = SAMPLES_TOGETHER * np.diag(np.r_[prior_precision(0.42, 0.01), np.ones(len(model.lines))])
    pull = rows.T @ (weight[used] * seen.offset[used])
    plain = np.linalg.solve((rows * weight[used][:, None]).T @ rows + prior, pull)[:8]
    np.testing.assert_allclose(step, plain, rtol=1e-6, atol=1e-12)
    before = np.sum(weight[used] * seen.offset[used] ** 2)
    assert np.sum(weight[used] * (seen.offset[used] - rows[:, :8] @ step) ** 2) < 0.2 * before
