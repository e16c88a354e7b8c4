"""Poses refined on synthetic pictures."""

from dataclasses import replace

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose
from numerics.arrays import Grey
from tests.vision_server.synthetic import CAMERA, one_image
from vision_server.channels.gradients import GradientChannel
from vision_server.pose.line_scales import line_scales
from vision_server.pose.observation import PoseProblem
from vision_server.pose.refinement import Solution, refine


def channels_of(pixels: Grey, gamma: float = 1.0) -> list[GradientChannel]:
    return one_image(pixels, gamma).gradients(["i1"])


def refined(
    pixels: Grey,
    model: Model,
    start: Pose,
    camera: Camera = CAMERA,
    gamma: float = 1.0,
    tone_sd_px: float = 0.01,
) -> Solution:
    problem = PoseProblem.at_scale(channels_of(pixels, gamma), model, camera, tone_sd_px=tone_sd_px)
    solution = refine(scaled(problem, start), start)
    assert solution is not None
    return solution


def scaled(problem: PoseProblem, pose: Pose) -> PoseProblem:
    """With the filters that suit the lines' blur."""
    return replace(problem, scale=line_scales(problem, pose))
