"""Poses refined on synthetic pictures."""

from dataclasses import replace

import numpy as np

from geometry.camera import Camera
from geometry.model import Model
from geometry.pose import Pose, disturbed
from geometry.surface import face_normals
from numerics.arrays import Floats, Grey
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture, one_image, photographed
from vision_server.channels.gradients import GradientChannel
from vision_server.pose.courses import BLUR, Courses
from vision_server.pose.line_scales import line_scales
from vision_server.pose.observation import PoseProblem
from vision_server.pose.refinement import Solution, refine
from vision_server.trust.ranking import Refined, best_first

UNKNOWNS = BLUR + 3
GREYS = (0.3, 0.7, 0.2, 0.9, 0.5, 0.8)


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


def found(part: Model, model: Model, seed: int) -> Refined:
    """Where refinement ends on a picture of a part."""
    random = np.random.default_rng(seed)
    pixels = photographed(linear_picture(part, CAMERA, POSE, GREYS), seed=seed)
    start = disturbed(POSE, random, 1.0, 1.5, CAMERA.fx)
    return best_first(PoseProblem.at_scale(channels_of(pixels), model, CAMERA), [start])[0]


def drawn_courses(count: int, seed: int) -> tuple[Courses, Floats]:
    """Lines that say where they are to a fiftieth of a pixel, and the unknowns that they agree on."""
    random = np.random.default_rng(seed)
    motion = random.normal(0.0, 1.0, (count, 2, UNKNOWNS)) * 300.0
    motion[:, :, 6:] = 0.0
    true = np.zeros(UNKNOWNS)
    true[:6] = random.normal(0.0, 0.003, 6)
    noise = np.tile(0.02**2 * np.eye(2), (count, 1, 1))
    place = motion @ true + random.normal(0.0, 0.02, (count, 2))
    return Courses(
        place,
        motion,
        noise,
        np.full(count, 0.06),
        np.ones(count),
        np.arange(count),
        np.zeros(count, np.int64),
        np.zeros((count, 2)),
    ), true


def misshapen(model: Model, random: np.random.Generator, off: float) -> Model:
    """The part, with corners that lie elsewhere, by a share of its size."""
    vertices = model.vertices + random.normal(0.0, off * model.diameter, model.vertices.shape)
    return replace(model, vertices=vertices, face_normals=face_normals(vertices, model.faces))
