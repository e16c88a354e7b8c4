"""How far edges stray about the lines of a pose, where it is known how far they do."""

import numpy as np
import pytest

from geometry.model import Model
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture, one_image, photographed
from vision_server.pose.observation import PoseProblem, observe
from vision_server.prediction.straying import PRIOR_LINES, line_scatter, straying_share


def test_edges_of_a_clean_image_scatter_less_than_those_about_a_pose_that_is_off(model: Model) -> None:
    images = one_image(photographed(linear_picture(model, CAMERA, POSE)))
    problem = PoseProblem.at_scale(images.gradients(["i1"]), model, CAMERA)
    here, off = (
        line_scatter(observe(problem, pose, 4.0, 2.0, pulls=False))
        for pose in (POSE, POSE.stepped([0.0, 0.0, 0.0, 0.003, 0.0, 0.0]))
    )
    assert here.shape == (1, len(model.lines))
    assert np.isnan(here).any()  # those behind
    assert np.nanmedian(np.sqrt(here)) < 0.1
    assert np.nanmax(np.sqrt(off)) > 1.0


def test_the_share_is_of_what_is_not_noise_and_few_lines_hardly_change_it() -> None:
    expected = np.array([0.1, 0.4])
    scatter = 0.05 + 0.25 * np.repeat(expected[:, None], 40, axis=1)
    noise = np.full(scatter.shape, 0.05)
    assert straying_share(scatter, noise, expected) == pytest.approx(0.25)
    few = np.full(scatter.shape, np.nan)
    few[0, : PRIOR_LINES // 2] = scatter[0, 0]
    assert straying_share(few, noise, expected) == 1.0
    assert straying_share(np.zeros(scatter.shape), noise, expected) > 0.0
