"""Poses refined on synthetic pictures."""

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from tests.vision_server.synthetic import CAMERA, one_image
from vision_server.channels.gradients import GradientChannel
from vision_server.pose.line_scales import line_scales
from vision_server.pose.refinement import REACHES_PX, Solution, refine


def channels_of(pixels: NDArray[np.uint8], gamma: float = 1.0) -> list[GradientChannel]:
    return one_image(pixels, gamma).gradients(["i1"])


def refined(
    pixels: NDArray[np.uint8],
    model: Model,
    start: Pose,
    camera: Camera = CAMERA,
    gamma: float = 1.0,
    tone_sd_px: float = 0.01,
) -> Solution:
    channels = channels_of(pixels, gamma)
    scale = line_scales(channels, model, camera, start, 4.0)
    solution = refine(channels, model, camera, start, scale, REACHES_PX, tone_sd_px)
    assert solution is not None
    return solution
