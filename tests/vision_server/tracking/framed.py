"""The cuboid, perhaps with a frame printed inside of the edges of its front face."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from geometry.model import Model
from tests.vision_server.synthetic import CAMERA, POSE, linear_picture
from tests.vision_server.tracking.films import GREYS
from vision_server.pose.line_scales import line_scales
from vision_server.pose.observation import PoseProblem
from vision_server.tracking.frame import Tone, problem_of, window

GAP_PX = 4.0


def front(model: Model) -> int:
    """The face that is seen most squarely."""
    normals = model.face_normals @ POSE.matrix.T
    return int(np.argmin(normals[:, 2]))


def problem(model: Model, printed: bool) -> PoseProblem:
    """The cuboid, perhaps with a frame printed inside of its front face."""
    picture = linear_picture(model, CAMERA, POSE, GREYS)
    if printed:
        corners = CAMERA.project(POSE.apply(model.vertices[model.faces[front(model)]]))
        middle = corners.mean(axis=0)
        inner = middle + (corners - middle) * (1.0 - 2.6 * GAP_PX / np.ptp(corners, axis=0).mean())
        points = np.round(16 * inner).astype(np.int32)
        grey = 0.5 * float(picture[int(middle[1]), int(middle[0])])
        cv2.fillPoly(picture, [points], grey, cv2.LINE_AA, 4)
    pixels = np.asarray(np.clip(np.round(255.0 * picture), 0, 255), dtype=np.uint8)
    seen = window(pixels, model, CAMERA, POSE, 40.0)
    assert seen is not None
    found = problem_of(seen, model, Tone.of(1.0, 0.01))
    return replace(found, scale=line_scales(found, POSE))
