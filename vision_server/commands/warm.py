"""`python -m vision_server warm`: compile every kernel into numba's cache by one small estimate."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

import cv2
import numpy as np

from geometry.camera import Camera
from geometry.model import TARGETS, Model, load_model
from geometry.pose import Pose
from vision_server.image_set import ImageSet
from vision_server.pipeline import PipelineSettings, estimate_pose

__all__ = ["warm_up"]


def add_options(parser: ArgumentParser) -> None:
    """It has none."""


def run(_: Namespace) -> int:
    """Compile what is not in the cache; the exit status."""
    warm_up()
    return 0


def warm_up() -> None:
    """Draw a cube with each face in its own grey and estimate its pose with both matchers."""
    model = load_model(TARGETS / "cube.cao")
    camera = Camera(320, 240, 400.0, 400.0, 159.5, 119.5)
    pose = Pose(np.array([0.5, 0.7, 0.1]), np.array([0.0, 0.0, 4.0 * model.diameter]))
    images = ImageSet(camera.width, camera.height)
    images.add("i1", drawn(model, camera, pose), 1.0, 1.0)
    for matcher in ("search", "genetic"):
        estimate_pose(images, ["i1"], model, camera, pose, PipelineSettings(matcher=matcher))


def drawn(model: Model, camera: Camera, pose: Pose) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    """A plain picture of a convex model, uint8 (H, W): each face that looks at the camera in one grey."""
    picture = np.full((camera.height, camera.width), 20, dtype=np.uint8)
    points = pose.apply(model.vertices)
    normals = model.face_normals @ pose.matrix.T
    pixels = camera.project(points)
    for index, face in enumerate(model.faces):
        if normals[index] @ points[face[0]] < 0.0:
            grey = 80 + 140 * index // max(1, len(model.faces) - 1)
            cv2.fillConvexPoly(picture, np.round(pixels[face] * 16).astype(np.int32), grey, cv2.LINE_AA, 4)
    blurred = cv2.GaussianBlur(picture, (0, 0), 0.7)
    return np.asarray(blurred, dtype=np.uint8)
