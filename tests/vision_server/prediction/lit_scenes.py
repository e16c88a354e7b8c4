"""A cuboid lit by two lights and a sun, with the truth known."""

import numpy as np

from geometry.model import Model
from numerics.arrays import Floats
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture
from vision_server.prediction.causes import Cause, likely_causes
from vision_server.prediction.lit_target import LitTarget
from vision_server.prediction.places import read
from vision_server.prediction.response import LitImage

POSITIONS = [np.array([-0.35, 0.0, 0.0]), np.array([0.35, 0.0, 0.0])]
SUN = 0.03
ASKED = ((1.0, 1.0), (0.3, 1.0), (1.0, 0.0), (0.4, 0.7))  # of the lights, image by image
ARM_PX, ARM_GREY = 15, 0.1  # half of its width, and how bright it is


def lambert(model: Model, position: Floats) -> tuple[float, ...]:
    """Brightness of each face by one light."""
    middles = POSE.apply(np.array([model.vertices[face].mean(axis=0) for face in model.faces]))
    towards = position - middles
    cosine = ((model.face_normals @ POSE.matrix.T) * towards).sum(axis=1) / np.linalg.norm(towards, axis=1)
    return tuple(0.8 * np.maximum(cosine, 0.0))


def lit(model: Model, lights: tuple[float, float], exposure: float = 1.0) -> LitImage:
    greys = SUN + sum(
        power * np.array(lambert(model, place)) for power, place in zip(lights, POSITIONS, strict=True)
    )
    picture = linear_picture(model, CAMERA, POSE, tuple(greys), background=0.0) * exposure
    return LitImage(np.minimum(picture, 1.0).astype(np.float32), exposure, np.array(lights), 0.7)


def taken(
    model: Model,
    asked: tuple[float, float],
    given: tuple[float, float],
    sun: float = SUN,
    blur_px: float = 0.7,
) -> LitImage:
    """An image under lights that give other than was asked for."""
    greys = sun + sum(
        power * np.array(lambert(model, place)) for power, place in zip(given, POSITIONS, strict=True)
    )
    picture = linear_picture(model, CAMERA, POSE, tuple(0.5 * greys), background=0.0)
    return LitImage(np.minimum(picture, 1.0).astype(np.float32), 0.5, np.array(asked), 0.7)


def found(model: Model, images: list[LitImage], positions: list[Floats | None] | None = None) -> list[Cause]:
    places, readings = read(LitTarget(model, CAMERA, POSE, positions or POSITIONS), images)
    return likely_causes(places, readings, np.array([image.lights for image in images]))


def behind_arm(image: LitImage) -> LitImage:
    """The image with an upright bar over the target's middle."""
    linear = image.linear.copy()
    column = round(CAMERA.project(POSE.translation[None])[0, 0])
    linear[:, column - ARM_PX : column + ARM_PX] = ARM_GREY
    return LitImage(linear, image.exposure, image.lights, image.blur_px)
