"""A cuboid lit by two lights and a sun, with the truth known."""

import numpy as np
from numpy.typing import NDArray

from geometry.model import Model
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture
from vision_server.prediction.response import LitImage

POSITIONS = [np.array([-0.35, 0.0, 0.0]), np.array([0.35, 0.0, 0.0])]
SUN = 0.03


def lambert(model: Model, position: NDArray[np.float64]) -> tuple[float, ...]:
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
