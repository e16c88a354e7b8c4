"""Edges that no light makes of the images before are new; those of the target are not, whatever the light."""

import cv2
import numpy as np
import pytest

from geometry.model import Model
from tests.vision_server.prediction.lit_scenes import ASKED, behind_arm, taken
from tests.vision_server.synthetic import CAMERA, POSE
from vision_server.prediction.lit_target import LitTarget
from vision_server.prediction.new_edges import NEW, new_edges
from vision_server.prediction.response import LitImage


@pytest.mark.parametrize("before", [1, 2, 3])
def test_an_arm_has_edges_of_its_own_and_light_has_none(model: Model, before: int) -> None:
    images = [taken(model, asked, asked) for asked in ASKED[:before]]
    dead, sun = taken(model, (1.0, 0.6), (0.0, 0.6)), taken(model, (1.0, 0.6), (1.0, 0.6), sun=0.4)
    for lit in (taken(model, (1.0, 0.6), (1.0, 0.6)), dead, sun):
        assert new_edges(LitTarget(model, CAMERA, POSE), [*images, lit]) < 0.2 * NEW
        assert new_edges(LitTarget(model, CAMERA, POSE), [*images, behind_arm(lit)]) > 2.0 * NEW


def test_what_was_there_before_is_not_new(model: Model) -> None:
    images = [behind_arm(taken(model, asked, asked)) for asked in ASKED[:2]]
    assert new_edges(LitTarget(model, CAMERA, POSE), images) < 0.2 * NEW


def test_a_blurred_or_noisy_image_has_no_new_edges(model: Model) -> None:
    sharp, other = (taken(model, asked, asked) for asked in ASKED[:2])
    soft = np.asarray(cv2.GaussianBlur(other.linear, (0, 0), 3.0), dtype=np.float32)
    grain = np.random.default_rng(1).normal(0.0, 0.01, other.linear.shape)
    noisy = np.maximum(other.linear + grain, 0.0).astype(np.float32)
    for linear, blur_px in ((soft, 3.1), (noisy, 0.7)):
        image = LitImage(linear, other.exposure, other.lights, blur_px)
        assert new_edges(LitTarget(model, CAMERA, POSE), [sharp, image]) < NEW


def test_where_all_is_clipped_nothing_is_new(model: Model) -> None:
    image = taken(model, (1.0, 1.0), (1.0, 1.0))
    clipped = LitImage(np.ones_like(image.linear), image.exposure, image.lights, image.blur_px)
    assert new_edges(LitTarget(model, CAMERA, POSE), [image, clipped]) == 0.0
    assert new_edges(LitTarget(model, CAMERA, POSE), [clipped, behind_arm(image)]) == 0.0
