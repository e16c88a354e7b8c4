"""`python -m vision_server warm`: compile every kernel into numba's cache."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from numerics.stale_kernels import remove_stale_kernels
from numerics.warming import warming

if TYPE_CHECKING:
    import numpy as np

    from geometry.camera import Camera
    from geometry.model import Model
    from geometry.pose import Pose


def add_options(_: ArgumentParser) -> None:
    """It has none."""


def run(_: Namespace) -> None:
    """Compile what has changed."""
    remove_stale_kernels()
    with warming("vision server", "numerics", "geometry", "vision_server"):
        warm_up()


def warm_up() -> None:
    """Draw a cube in several ways; find the kinds of its edges, and its pose in every way there is."""
    import numpy as np

    from geometry.camera import Camera
    from geometry.model import TARGETS, load_model
    from geometry.pose import Pose
    from vision_server.channels.depth import PER_GREY
    from vision_server.edges.kinds import edge_kinds
    from vision_server.image_set import ImageSet
    from vision_server.matching import Anywhere
    from vision_server.pipeline import PipelineSettings, estimate_pose
    from vision_server.tracking.tracker import Tracker

    model = load_model(TARGETS / "cube.cao")
    camera = Camera(320, 240, 400.0, 400.0, 159.5, 119.5)
    pose = Pose(np.array([0.5, 0.7, 0.1]), np.array([0.0, 0.0, 4.0 * model.diameter]))
    images = ImageSet(camera.width, camera.height)
    sharp = drawn(model, camera, pose, 0.7)
    noise = np.random.default_rng(0).normal(0.0, 4.0, sharp.shape)
    images.add("sharp", sharp, 1.0, 1.0)
    images.add("blurred", drawn(model, camera, pose, 3.0), 1.0, 1.0)
    images.add("bright", np.minimum(2 * sharp.astype(np.uint16), 255).astype(np.uint8), 2.0, 1.0)
    images.add("toned", sharp, 1.0, 2.2)
    images.add("deep", sharp.astype(np.uint16) * np.uint16(PER_GREY), 1.0, 1.0)
    images.add("noisy", np.clip(sharp + noise, 0.0, 255.0).astype(np.uint8), 1.0, 1.0)
    edge_kinds([image.statistics for image in images.images.values()])
    for names, matcher in (
        (["sharp"], "search"),
        (["blurred", "bright"], "search"),
        (["sharp", "blurred"], "genetic"),
    ):
        estimate_pose(images, names, model, camera, pose, PipelineSettings(matcher=matcher))
    estimate_pose(images, ["sharp"], model, camera, Anywhere())
    tracker = Tracker(model, camera, pose)
    for frame in (sharp, images.images["noisy"].pixels):
        tracker.step(frame)


def drawn(
    model: Model, camera: Camera, pose: Pose, sigma_px: float
) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    """A plain picture of a convex model, uint8 (H, W): each face that looks at the camera in one grey."""
    import cv2
    import numpy as np

    picture = np.full((camera.height, camera.width), 20, dtype=np.uint8)
    points = pose.apply(model.vertices)
    normals = model.face_normals @ pose.matrix.T
    pixels = camera.project(points)
    for index, face in enumerate(model.faces):
        if normals[index] @ points[face[0]] < 0.0:
            grey = 80 + 140 * index // max(1, len(model.faces) - 1)
            cv2.fillConvexPoly(picture, np.round(pixels[face] * 16).astype(np.int32), grey, cv2.LINE_AA, 4)
    blurred = cv2.GaussianBlur(picture, (0, 0), sigma_px)
    return np.asarray(blurred, dtype=np.uint8)
